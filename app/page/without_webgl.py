"""What the page does where the browser has no WebGL: everything but the picture, as JavaScript that runs before viser's own."""

from typing import Final

from app.i18n.client_texts import NO_PICTURE, WHAT_TO_SWITCH_ON, WHAT_WORKS


def without_webgl_script() -> str:
    """Return a script that says what to switch on, and lets viser's client run without a picture.

    That client takes the server's messages only while it draws, and draws only with WebGL. So it gets a context that accepts every
    call and does nothing.
    """
    said = f"<b>{NO_PICTURE}</b><p>{WHAT_WORKS}</p><p>{WHAT_TO_SWITCH_ON}</p>"
    return _SCRIPT.replace("__SAID__", said).replace("__STYLE__", " ".join(_STYLE.split()))


_STYLE: Final = """
#duet-no-picture { position: fixed; z-index: 1; top: 64px; pointer-events: none; box-sizing: border-box; max-width: 34rem;
  left: calc(50% + (var(--duet-left, 0px) - var(--duet-dock, 344px)) / 2); transform: translateX(-50%);
  width: calc(100% - var(--duet-left, 0px) - var(--duet-dock, 344px) - 32px); padding: 14px 20px; border-radius: 12px;
  font: calc(15px * var(--duet-k, 1))/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif;
  color: light-dark(#1f2328, #e3e8ee); background: light-dark(#f5f7f9, #20242a); border: 1px solid light-dark(#d5dae0, #3a4149) }
#duet-no-picture p { margin: .5em 0 0 }
@media (max-width: 36em) { #duet-no-picture { left: 50%; width: calc(100% - 32px) } }
"""

_SCRIPT: Final = """(() => {
  if (document.createElement("canvas").getContext("webgl2")) return;
  duetQuery.picture = "fast";
  const names = WebGL2RenderingContext.prototype;
  const answers = {
    getParameter: (name) => ({
      [names.VERSION]: "WebGL 2.0", [names.SHADING_LANGUAGE_VERSION]: "WebGL GLSL ES 3.00",
      [names.VIEWPORT]: new Int32Array(4), [names.SCISSOR_BOX]: new Int32Array(4),
    })[name] ?? 4096,
    getExtension: (name) => name === "EXT_color_buffer_float" ? {} : null,
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
  const made = () => ({});
  const nothing = () => {};
  const context = (canvas) => new Proxy({}, {
    get: (_, name) => name === "canvas" ? canvas : /^[A-Z]/.test(name) ? names[name]
      : answers[name] ?? (/^(create|fence)/.test(name) ? made : nothing),
  });
  const get = HTMLCanvasElement.prototype.getContext, contexts = new WeakMap();
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    if (kind !== "webgl2") return get.call(this, kind, options);
    if (!contexts.has(this)) contexts.set(this, context(this));
    return contexts.get(this);
  };
  addEventListener("DOMContentLoaded", () => {
    const note = document.createElement("div");
    note.id = "duet-no-picture";
    note.setAttribute("role", "note");
    note.innerHTML = "__SAID__";
    const style = document.createElement("style");
    style.textContent = `__STYLE__`;
    document.head.append(style);
    document.body.append(note);
  });
})();
"""
