// The connection to the server. viser's client opens its websocket from a worker; this script stands between the page and it, and
// - hands the page's own query to the websocket, so that every tab brings its own link along,
// - shows when the connection is lost, when the server is silent for 3 s, and when it does not know the page's address,
// - comes back as soon as the server answers, also while the tab is not in front (a projector beside the window that one types in),
// - reloads the page when it meets another server than before, and when the server sends it elsewhere,
// - says when the tab goes out of sight and comes back, so that the server rests meanwhile,
// - says hello at once, because a tab in the background draws no scene, and viser waits for one.
(() => {
  const { messages, reasons, texts, longestQuery, longestPush } = duet.connection;
  texts.refused = texts.refused.replace("{name}", location.origin);

  // viser rewrites the address bar a moment from now.
  const given = new URLSearchParams(location.search);
  given.delete("websocket");
  for (const [key, value] of Object.entries(duet.query)) if (!given.has(key)) given.set(key, value);
  // One that is too long is to be named as such.
  if (given.has("push")) given.set("push", given.get("push").slice(0, longestPush + 1));
  const query = given.toString().length > longestQuery ? "" : given.toString();

  let retryTimer = 0;
  // When the websocket that may still open was asked for [ms].
  let tried = null;
  let leaving = false;
  let shown = "";
  // The server that has this tab; behind a proxy with several, the page may come from another one.
  let met = null;
  // When the server was last heard [ms]; null without a connection.
  let heard = null;

  const statusElement = () => {
    let element = document.getElementById("duet-connection");
    if (!element && document.body) {
      element = document.createElement("div");
      element.id = "duet-connection";
      element.setAttribute("role", "status");
      element.setAttribute("aria-live", "polite");
      document.body.append(element);
    }
    return element;
  };
  addEventListener("DOMContentLoaded", statusElement);

  const show = (text, spinner = true) => {
    const element = statusElement();
    if (!element || text === shown) return;
    shown = text;
    element.textContent = "";
    if (text && spinner) element.append(document.createElement("i"));
    element.append(text);
  };

  const onMessage = () => {
    heard = performance.now();
    if (shown === texts.silent) show("");
  };

  const watchSilence = (worker) => {
    let checked = performance.now();
    setInterval(() => {
      const now = performance.now();
      // A page in the background, or one that was held up itself, cannot tell how long the server has been silent.
      if (heard !== null && (document.hidden || now - checked > 1500)) heard = now;
      checked = now;
      if (heard === null || now - heard < 900) return;
      worker.postMessage({ type: "send", message: { type: messages.question } });
      if (now - heard > 3000) show(texts.silent);
    }, 1000);
  };

  const tellSight = (worker) =>
    worker.postMessage({ type: "send", message: { type: document.hidden ? messages.hidden : messages.shown } });

  const health = (query) => fetch(`healthz${query}`, { cache: "no-store" }).then((answer) => answer.json());

  // A browser lets a page of which many websockets have failed wait for the next one, longer than viser waits before it gives that up:
  // after a minute none would open any more. So none is opened before the server answers, and each has its time.
  const seek = (retry) => {
    if (tried !== null && performance.now() - tried < 6000) return;
    // A browser does not tell its page why a connection was refused.
    health(`?origin=${encodeURIComponent(location.origin)}`)
      .then((state) => {
        if (heard !== null || leaving) return;
        show(state.admitted === false ? texts.refused : texts.lost);
        tried = performance.now();
        retry();
      })
      .catch(() => {});
  };

  const onClosed = (retry, reason) => {
    heard = null;
    if (leaving) return;
    if (reason === reasons.full || reason === reasons.elsewhere) {
      leaving = true;
      // The tabs of a class come back at different times, but none waits for long.
      setTimeout(() => location.reload(), (reason === reasons.full ? 300 : 0) + 700 * Math.random());
      return;
    }
    if (reason === reasons.tooMany) {
      leaving = true;
      show(texts.tooMany, false);
      return;
    }
    if (reason === reasons.takenOver) {
      leaving = true;
      show(texts.takenOver, false);
      // The tab that is used is the one that goes on.
      for (const used of ["focus", "pointerdown", "keydown"]) addEventListener(used, () => location.reload());
      return;
    }
    if (shown !== texts.refused) show(texts.lost);
    tried = null;
    if (retryTimer) return;
    retryTimer = setInterval(() => seek(retry), 900 + 300 * Math.random());
    seek(retry);
  };

  const onConnected = () => {
    duet.waitForControls?.();
    show("");
    clearInterval(retryTimer);
    retryTimer = 0;
    health(`?resume=${duet.query.resume ?? ""}`)
      .then((state) => {
        met ??= state.run;
        if (state.run && state.run !== met) location.reload();
      })
      .catch(() => {});
  };

  const Native = window.Worker;
  window.Worker = class extends Native {
    postMessage(message, ...rest) {
      if (message && message.type === "retry") return;
      if (message && message.type === "set_server" && typeof message.server === "string") {
        this.addEventListener("message", ({ data }) => {
          if (leaving || !data) return;
          if (data.type === "closed") onClosed(() => super.postMessage({ type: "retry" }), data.closeReason);
          else onMessage();
          if (data.type === "connected") {
            super.postMessage({ type: "send", message: { type: messages.hello } });
            if (document.hidden) tellSight(this);
            onConnected();
          }
        });
        watchSilence(this);
        document.addEventListener("visibilitychange", () => {
          if (heard !== null) tellSight(this);
        });
        if (query && !message.server.includes("?")) {
          message = { ...message, server: `${message.server.replace(/\/*$/, "/")}?${query}` };
        }
      }
      super.postMessage(message, ...rest);
    }
  };
})();
