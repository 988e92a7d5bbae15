"""The pages that Duet serves itself: viser's with a few additions of ours, and the one for a room that is full.

viser's client is one HTML file that opens its websocket from a worker. A short script put before it
- hands the page's own query (`/?dm=0.1`) to the websocket, so that every tab brings its own deep link along,
- says in large letters when the connection is lost, when the server is silent for 3 s, and when it does not know the page's address,
  and clears that when it is back,
- keeps trying while the tab is not in front (a projector next to the window one types in), which viser itself does not,
- reloads the page when it meets another server than the one it came from, when the room is full, when a class moves, and when a key
  was tried too soon after a wrong one,
- says hello at once, as the server does not wait long for that, and a tab in the background draws no scene.
"""

from __future__ import annotations

import html
import json
import re
from urllib.parse import parse_qsl, quote, urlsplit

from app.i18n.client_texts import CROWDED, KEPT_OUT, LOST, SILENT, WAIT, client_script

ROOM_IS_FULL = "duet: every place is taken"
ELSEWHERE = "duet: this tab belongs somewhere else"
OPEN_TOO_OFTEN = "duet: too many connections of one tab"
HELLO = "DuetHello"
"""Kind of the message by which a page says that it is one: what viser's client says first waits until the scene is in view."""
QUESTION = "DuetQuestion"
"""Kind of the message by which a page that hears nothing asks whether the server is still there."""
KEY_LATER = "duet: one key a second"
_LONGEST_QUERY = 4000
_MOST_FIELDS, _LONGEST_KEY, _LONGEST_VALUE = 64, 40, 400

MARK = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32" fill="none" stroke-width="4.5" stroke-linecap="round"
 stroke-linejoin="round"><path d="M6 28V18l7-8 4 5" stroke="#f26a0a"/><path d="M26 28V16l-5-11-4 5" stroke="#8a9099"/></svg>"""
_ICON = f'<link rel="icon" href="data:image/svg+xml,{quote(MARK)}">'

_STYLE = """
#duet-connection{position:fixed;top:18px;left:50%;transform:translateX(-50%);z-index:2147483647;display:flex;align-items:center;
 gap:.7em;padding:.62em 1.25em;border-radius:1.5em;width:max-content;max-width:calc(100vw - 24px);overflow-wrap:anywhere;text-wrap:balance;
 font:600 19px/1.25 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;
 box-sizing:border-box;color:#3a1d00;background:#fff4e5;border:2px solid #e07a10;
 box-shadow:0 6px 28px rgba(0,0,0,.28);pointer-events:none}
#duet-connection:empty{display:none}
[data-mantine-color-scheme=dark] #duet-connection{color:#ffe9d0;background:#3a2408;border-color:#f29a3c;
 box-shadow:0 6px 28px rgba(0,0,0,.6)}
#duet-connection i{flex:none;width:.78em;height:.78em;border-radius:50%;border:3px solid currentColor;
 border-top-color:transparent;animation:duet-turn 1s linear infinite}
@keyframes duet-turn{to{transform:rotate(1turn)}}
@media (prefers-reduced-motion:reduce){#duet-connection i{animation:none;border-top-color:currentColor;opacity:.6}}
@media (max-width:36em){#duet-connection{font-size:16px;top:10px}}
/* viser keeps the scene invisible until the reflections are computed, which takes seconds without a graphics card. */
canvas[data-engine]{opacity:1!important}
"""

_SCRIPT = """
(() => {
  const ours = __SETTINGS__;
  ours.keptOut = ours.keptOut.replace("{name}", location.origin);
  // viser rewrites the address bar a moment from now.
  const given = new URLSearchParams(location.search);
  given.delete("websocket");
  for (const [key, value] of Object.entries(window.duetQuery)) if (!given.has(key)) given.set(key, value);
  let query = given.toString();
  if (query.length > ours.longest) query = "";
  let retry = 0, leaving = false, said = "";
  // When the server was last heard [ms]; null without a connection.
  let heard = null;
  const pill = () => {
    let node = document.getElementById("duet-connection");
    if (!node && document.body) {
      node = document.createElement("div");
      node.id = "duet-connection";
      node.setAttribute("role", "status");
      node.setAttribute("aria-live", "polite");
      document.body.append(node);
    }
    return node;
  };
  addEventListener("DOMContentLoaded", pill);
  const say = (text, waits = true) => {
    const node = pill();
    if (!node || text === said) return;
    said = text;
    node.textContent = "";
    if (text && waits) node.append(document.createElement("i"));
    node.append(text);
  };
  const hear = () => {
    heard = performance.now();
    if (said === ours.silent) say("");
  };
  const watch = (worker) => {
    let looked = performance.now();
    setInterval(() => {
      const now = performance.now();
      // A page in the background, or one that was held up itself, cannot tell how long the server has been silent.
      if (heard !== null && (document.hidden || now - looked > 2500)) heard = now;
      looked = now;
      if (heard === null || now - heard < 900) return;
      worker.postMessage({ type: "send", message: { type: ours.question } });
      if (now - heard > 3000) say(ours.silent);
    }, 1000);
  };
  const ask = (query) => fetch("healthz" + query, { cache: "no-store" }).then((answer) => answer.json());
  const lost = (worker, reason) => {
    heard = null;
    if (leaving) return;
    if (reason === ours.later) say(ours.wait);
    if (reason === ours.full || reason === ours.elsewhere || reason === ours.later) {
      leaving = true;
      // A class comes back in its own time, but no page waits for long.
      const least = { [ours.full]: 300, [ours.later]: 1000 }[reason] ?? 0;
      setTimeout(() => location.reload(), least + 700 * Math.random());
      return;
    }
    if (reason === ours.often) {
      leaving = true;
      say(ours.crowded, false);
      return;
    }
    if (said !== ours.keptOut) say(ours.lost);
    // Why a connection was refused, a browser does not tell its page.
    ask("?origin=" + encodeURIComponent(location.origin))
      .then((state) => { if (heard === null) say(state.admitted === false ? ours.keptOut : ours.lost); }).catch(() => {});
    if (!retry) retry = setInterval(() => { if (!document.hasFocus()) worker.postMessage({ type: "retry" }); }, 3000);
  };
  const found = () => {
    window.duetLoading?.();
    say("");
    clearInterval(retry);
    retry = 0;
    ask("").then((state) => { if (state.run && state.run !== ours.run) location.reload(); }).catch(() => {});
  };
  const Native = window.Worker;
  window.Worker = class extends Native {
    postMessage(message, ...rest) {
      // Being turned away counts as connected for a moment, so viser would try again at once, and again.
      if (leaving && message && message.type === "retry") return;
      if (message && message.type === "set_server" && typeof message.server === "string") {
        this.addEventListener("message", ({ data }) => {
          if (leaving || !data) return;
          if (data.type === "closed") lost(this, data.closeReason);
          else hear();
          if (data.type === "connected") {
            super.postMessage({ type: "send", message: { type: ours.hello } });
            found();
          }
        });
        watch(this);
        if (query && !message.server.includes("?")) {
          message = { ...message, server: message.server.replace(/\\/*$/, "/") + "?" + query };
        }
      }
      super.postMessage(message, ...rest);
    }
  };
})();
"""


def patched_index(client_html: str, *, title: str, run: str, script: str = "", body: str = "") -> str:
    """Put our additions into viser's page.

    Args:
        client_html: viser's own `index.html`.
        title: the title of the tab.
        run: a word that is different for every start of the server.
        script: further JavaScript of the page's own, which may add to `duetQuery` what the server is to know of the browser.
        body: HTML that the page's body begins with.

    Raises:
        ValueError: the page doesn't look as expected (another version of viser).
    """
    head, mark, rest = client_html.partition("<title>Viser</title>")
    program, end, root = rest.rpartition("</head>")
    if not (mark and end):
        raise ValueError("viser's page has no title in its head to put Duet's additions at")
    settings = {"run": run, "full": ROOM_IS_FULL, "elsewhere": ELSEWHERE, "longest": _LONGEST_QUERY}
    settings |= {"lost": LOST, "often": OPEN_TOO_OFTEN, "crowded": CROWDED, "hello": HELLO}
    settings |= {"lost": LOST, "silent": SILENT, "keptOut": KEPT_OUT, "question": QUESTION}
    settings |= {"later": KEY_LATER, "wait": WAIT}
    what_we_see = "window.duetQuery={window:`${innerWidth}x${innerHeight}`};"
    # A proxy may have us in a folder of its own, which our address needs.
    what_we_see += "{const at=location.pathname.replace(/\\/[^/]*$/,'');if(at)duetQuery.folder=at}"
    script = what_we_see + script + _SCRIPT.replace("__SETTINGS__", json.dumps(settings).replace("<", "\\u003c"))
    head = re.sub(r'<link\s+rel="icon".*?/>', _ICON, head, flags=re.DOTALL)
    head = head.replace('content="Viser client"', 'content="Two robot arms, and one that gives way"')
    # viser's program is long: in the body, behind what is seen until it has arrived.
    ours = f"<title>{html.escape(title)}</title><style>{_STYLE}</style><script>{script}</script></head><body>{body}"
    return head + ours + program + root.replace("<body>", "", 1)


def page_query(request_path: str) -> dict[str, str]:
    """Return the query in the path of a request. It can hold any text: validate every value.

    Keys and values beyond a sensible length, repeated keys and more than 64 fields are left out.
    """
    query = urlsplit(request_path[: 2 * _LONGEST_QUERY]).query
    try:
        fields = parse_qsl(query, keep_blank_values=True, max_num_fields=_MOST_FIELDS)
    except ValueError:
        return {}
    found: dict[str, str] = {}
    for key, value in fields:
        if 0 < len(key) <= _LONGEST_KEY and len(value) <= _LONGEST_VALUE:
            found.setdefault(key, value)
    return found


_FULL_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Duet – every place is taken</title>__ICON__<noscript><meta http-equiv="refresh" content="10"></noscript>
<style>
:root{color-scheme:light dark;--paper:#f3f4f6;--card:#fff;--ink:#1f2328;--soft:#57606a;--arm:#8a9099;--line:#d8dce1}
@media (prefers-color-scheme:dark){:root{--paper:#16181c;--card:#212429;--ink:#eceef1;--soft:#a3abb5;
 --arm:#767e88;--line:#353a41}}
*{box-sizing:border-box}
body{margin:0;min-height:100vh;display:grid;place-items:center;padding:24px;background:var(--paper);color:var(--ink);
 font:17px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif}
main{max-width:30rem;padding:40px 40px 32px;border-radius:20px;border:1px solid var(--line);background:var(--card);
 text-align:center;box-shadow:0 12px 40px rgba(0,0,0,.10)}
svg{width:168px;height:auto;display:block;margin:0 auto 20px}
h1{font-size:1.6rem;line-height:1.25;margin:0 0 .5em;letter-spacing:-.01em}
p{margin:0 0 1em;color:var(--soft)}
#state{display:inline-flex;align-items:center;gap:.6em;margin:.4em 0 0;font-weight:600;color:var(--ink)}
#state i{width:.7em;height:.7em;border-radius:50%;background:#f26a0a;animation:breathe 2s ease-in-out infinite}
@keyframes breathe{50%{opacity:.25}}
@media (prefers-reduced-motion:reduce){#state i{animation:none}}
</style></head><body><main>
<svg viewBox="0 0 168 104" fill="none" stroke-linecap="round" stroke-linejoin="round" stroke-width="11" aria-hidden="true">
<path d="M24 96V62L56 30l22 20" stroke="#f26a0a"/><path d="M144 96V58L118 26 98 52" stroke="var(--arm)"/>
<path d="M10 98h28M130 98h28" stroke="var(--line)" stroke-width="8"/>
<g fill="var(--card)" stroke-width="5"><g stroke="#f26a0a"><circle cx="24" cy="62" r="6"/><circle cx="56" cy="30" r="6"/></g>
<g stroke="var(--arm)"><circle cx="144" cy="58" r="6"/><circle cx="118" cy="26" r="6"/></g></g></svg>
<h1>Every place is taken</h1>
<p><span>__PLACES__</span> <span>You needn’t do anything: this page lets you in as soon as a place is free.</span></p>
<div id="state" role="status"><i></i><span>Waiting for a place…</span></div>
</main><script>
__WORDS__
document.title = duetWord(document.title);
(() => {
  const ask = () => fetch("healthz", { cache: "no-store" }).then((answer) => answer.json())
    .then((state) => { if (state.room) location.reload(); else setTimeout(ask, 2500 + 1500 * Math.random()); })
    .catch(() => setTimeout(ask, 5000));
  // Soon, as the place may be the one that this very tab is just giving up by a reload.
  setTimeout(ask, 300);
})();
</script></body></html>
"""


def full_page(limit: int) -> str:
    """Return the page that is shown while all `limit` places are taken; it asks again by itself and loads nothing else.

    It speaks the language of the link, or of the browser.
    """
    one = "This Duet has one place, and it is taken."
    places = one if limit == 1 else f"This Duet has {limit} places, and all of them are in use."
    return _FULL_PAGE.replace("__ICON__", _ICON).replace("__PLACES__", places).replace("__WORDS__", client_script())
