// Hands the recorded scene to viser's client, which draws it without a server.
window.__VISER_EMBED_DATA__ = duet.scene;
window.__VISER_EMBED_CONFIG__ = { darkMode: duet.dark };
document.documentElement.classList.toggle("dark", duet.dark);
