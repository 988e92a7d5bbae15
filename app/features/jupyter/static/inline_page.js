// In a notebook: puts the page of the kernel's server into the cell's output, by way of jupyter-server-proxy. Only Jupyter's own page
// knows the address and the folder under which a browser reaches it.
(() => {
  const { place, port, run, query, height, texts } = duet.inline;
  const spoken = (navigator.languages || []).map((language) => language.slice(0, 2)).find((language) => texts[language]);
  const words = texts[spoken ?? "en"];

  const baseUrl = () => {
    const config = document.getElementById("jupyter-config-data");
    const base = config ? JSON.parse(config.textContent).baseUrl : document.body.dataset.baseUrl;
    return (base ?? "/").replace(/\/*$/, "/");
  };

  const explain = (box, status) => {
    box.textContent = status === 404 ? `${words.noProxy} ` : words.ended;
    if (status !== 404) return;
    const link = document.createElement("a");
    link.href = `http://127.0.0.1:${port}/?${query}`;
    link.target = "_blank";
    link.textContent = `http://127.0.0.1:${port}`;
    box.append(link);
  };

  const show = async (box) => {
    const folder = `${baseUrl()}proxy/${port}/`;
    const answer = await fetch(`${folder}healthz`, { cache: "no-store" }).catch(() => null);
    const state = answer?.ok ? await answer.json().catch(() => null) : null;
    if (state?.run !== run) {
      explain(box, answer?.status);
      return;
    }
    const frame = document.createElement("iframe");
    frame.src = `${folder}?${query}`;
    frame.title = "Duet";
    frame.allow = "fullscreen; clipboard-write";
    frame.style.cssText = `display: block; width: 100%; height: ${height}px; border: 0`;
    box.replaceChildren(frame);
  };

  // JupyterLab runs the script before the output is on the page.
  let looks = 0;
  const find = () => {
    const box = document.getElementById(place);
    if (box) show(box);
    else if (looks++ < 600) requestAnimationFrame(find);
  };
  find();
})();
