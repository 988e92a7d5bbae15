// Says that the mouse rests on the visitor's hand or ball, so that its arrows come, and later that it has left hand and arrows. A press
// without a move since the arrows have come takes what was under the mouse before.
addEventListener("DOMContentLoaded", () => {
  const LOOK_MS = 100;
  const REST_MS = 300;
  const GONE_MS = 1500;
  // What counts as the hand, and how far its arrows reach [m].
  const HAND = 0.12;
  const ARROWS = 0.3;
  const STILL_PX = 4;
  let pointer = null;
  let watched = null;
  let shown = null;
  let since = 0;

  const nodes = () => window.__viserMutable?.nodeRefFromName ?? {};
  const distance = (a, b) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);

  // Whether the mouse is so near to the middle of the hand in the picture [m].
  const within = (node, reach) => {
    const { camera, canvas } = window.__viserMutable;
    const box = canvas.getBoundingClientRect();
    node.updateWorldMatrix(true, false);
    const at = node.getWorldPosition(camera.position.clone());
    const pixels = box.height / (2 * Math.tan((camera.fov * Math.PI) / 360) * at.distanceTo(camera.position));
    at.project(camera);
    const middle = { clientX: box.left + ((1 + at.x) / 2) * box.width, clientY: box.top + ((1 - at.y) / 2) * box.height };
    return distance(pointer, middle) < reach * pixels;
  };

  const say = (value) => {
    shown = value ? pointer : null;
    window.__viserMutable.sendMessage({ type: "GuiUpdateMessage", uuid: watched.box, updates: { value } });
  };

  const look = () => {
    // A folded panel is not on the page.
    const mark = document.querySelector("[data-duet-hover]");
    if (mark && (mark.dataset.box !== watched?.box || mark.dataset.duetHover !== watched.node)) {
      watched = { box: mark.dataset.box, node: mark.dataset.duetHover };
      shown = null;
    }
    const node = nodes()[watched?.node];
    // A finger has no place where it rests.
    if (!pointer && shown && node) say(false);
    if (!pointer || pointer.buttons || !node) {
      since = 0;
      return;
    }
    const { canvas } = window.__viserMutable;
    const over = pointer.target === canvas;
    // viser's cursor says that something that can be pulled is under the mouse.
    const near = over && within(node, shown ? ARROWS : HAND) && (shown || canvas.style.cursor === "pointer");
    if (Boolean(near) === Boolean(shown)) since = 0;
    else if (since === 0) since = performance.now();
    else if (performance.now() - since > (shown ? GONE_MS : REST_MS)) say(!shown);
  };

  const note = (event) => {
    pointer = event.pointerType === "mouse" ? event : null;
  };
  // three.js does not meet a part that says so.
  const without = (arrows) => {
    const own = [];
    arrows.traverse((part) => {
      own.push([part, Object.getOwnPropertyDescriptor(part, "raycast")]);
      part.raycast = () => {};
    });
    setTimeout(() => {
      for (const [part, raycast] of own) {
        delete part.raycast;
        if (raycast) Object.defineProperty(part, "raycast", raycast);
      }
    });
  };
  const press = (event) => {
    note(event);
    if (!shown || distance(event, shown) > STILL_PX) return;
    for (const name of ["/gizmo/hand", "/gizmo/ball"]) if (nodes()[name]) without(nodes()[name]);
  };
  addEventListener("pointerdown", press, true);
  for (const kind of ["pointermove", "pointerup"]) addEventListener(kind, note);
  document.documentElement.addEventListener("pointerleave", note);
  setInterval(look, LOOK_MS);
});
