// Says what to switch on where the browser has no WebGL, and lets viser's client run without a picture: that client takes the server's
// messages only while it draws, and draws only with WebGL. So it gets a context that accepts every call and does nothing.
(() => {
  if (document.createElement("canvas").getContext("webgl2")) return;
  duet.query.picture = "fast";
  const names = WebGL2RenderingContext.prototype;
  const parameters = {
    [names.VERSION]: "WebGL 2.0",
    [names.SHADING_LANGUAGE_VERSION]: "WebGL GLSL ES 3.00",
    [names.VIEWPORT]: new Int32Array(4),
    [names.SCISSOR_BOX]: new Int32Array(4),
  };
  const answers = {
    getParameter: (name) => parameters[name] ?? 4096,
    getExtension: (name) => (name === "EXT_color_buffer_float" ? {} : null),
    getSupportedExtensions: () => [],
    getContextAttributes: () => ({}),
    getShaderPrecisionFormat: () => ({ precision: 23, rangeMin: 127, rangeMax: 127 }),
    getProgramParameter: (_, name) => name === names.LINK_STATUS || 0,
    getShaderParameter: () => true,
    getProgramInfoLog: () => "",
    getShaderInfoLog: () => "",
    checkFramebufferStatus: () => names.FRAMEBUFFER_COMPLETE,
    isContextLost: () => false,
    getError: () => 0,
  };
  const create = () => ({});
  const ignore = () => {};
  const property = (canvas, name) => {
    if (name === "canvas") return canvas;
    if (/^[A-Z]/.test(name)) return names[name];
    return answers[name] ?? (/^(create|fence)/.test(name) ? create : ignore);
  };
  const getContext = HTMLCanvasElement.prototype.getContext;
  const contexts = new WeakMap();
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    if (kind !== "webgl2") return getContext.call(this, kind, options);
    if (!contexts.has(this)) contexts.set(this, new Proxy({}, { get: (_, name) => property(this, name) }));
    return contexts.get(this);
  };
  addEventListener("DOMContentLoaded", () => {
    const note = document.createElement("div");
    note.id = "duet-no-picture";
    note.setAttribute("role", "note");
    duet.withoutWebgl.forEach((text, i) => {
      const line = document.createElement(i ? "p" : "b");
      line.textContent = text;
      note.append(line);
    });
    document.body.append(note);
  });
})();
