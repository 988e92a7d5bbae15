// Finds out whether the browser draws without a graphics card, and says so on the page for some seconds.
(() => {
  const NOTE_MS = 6000;
  const gl = document.createElement("canvas").getContext("webgl");
  if (!gl) return;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  duet.drawnBySoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  if (!duet.drawnBySoftware) return;

  // viser asks the same, and puts a large notification over the scene that stays until it is closed.
  for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
    const getExtension = prototype.getExtension;
    prototype.getExtension = function (name) {
      return name === "WEBGL_debug_renderer_info" ? null : getExtension.call(this, name);
    };
  }
  const showNote = () => {
    const note = document.createElement("div");
    note.id = "duet-note";
    note.setAttribute("role", "status");
    document.body.append(note);
    note.textContent = duet.translate(duet.softwareNote);
    setTimeout(() => note.remove(), NOTE_MS);
  };
  addEventListener("duet-built", showNote, { once: true });
})();
