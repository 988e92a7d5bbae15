"""What the browser says by itself, viser's own client and our scripts: it cannot ask the server, which may just be what is gone.

All of it is on a list, in every language, in a script that goes with the page. The script looks at whatever comes onto the page or
changes there, and says it anew if it is on the list. What the server has sent is in the page's language already.
"""

import json
from typing import Final

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language

LOST: Final = N_("Connection lost – trying again…")
"""What `app.web.index_page` says when the server is gone, …"""
SILENT: Final = N_("The server does not answer – waiting…")
"""… when it is there and says nothing, …"""
KEPT_OUT: Final = N_("Duet does not know this address. Start it with --allow-origin {name}")
"""… and when it does not let the page in."""

NO_PICTURE: Final = N_("No picture: WebGL is switched off in this browser")
WHAT_WORKS: Final = N_("Lessons, plots, numbers and controls work all the same; the arrow keys move the hand, J and K the elbow.")
WHAT_TO_SWITCH_ON: Final = N_(
    "To see the arms, switch on graphics acceleration in the browser’s settings and start the browser again, or use another browser."
)
"""What `app.page.without_webgl` says."""

LOADING: Final = N_("Loading …")
"""What `app.page.loading` says until the page is there."""

SOFTWARE: Final = N_("Drawn without a graphics card; it may stutter.")
"""What `app.page.software_rendering` says for some seconds."""

CROWDED: Final = N_("This page is open in too many tabs. Close some of them, then reload this one.")
"""What `app.web.index_page` says where one tab was doubled too often."""

WAIT: Final = N_("A wrong key has just been tried from here. Wait: yours is tried in a second…")
"""What it says where keys are tried too fast."""

OURS: Final = (
    LOST,
    LOADING,
    SOFTWARE,
    CROWDED,
    SILENT,
    KEPT_OUT,
    NO_PICTURE,
    WHAT_WORKS,
    WHAT_TO_SWITCH_ON,
    WAIT,
    N_("every command by name"),
    N_("connection and camera"),
    N_("back to the controls"),
    N_("more"),
    N_("dismiss this message"),
    N_("From the teacher"),
    # The page of a full room.
    N_("Duet – every place is taken"),
    N_("Every place is taken"),
    N_("This Duet has one place, and it is taken."),
    N_("This Duet has {name} places, and all of them are in use."),
    N_("You needn’t do anything: this page lets you in as soon as a place is free."),
    N_("Waiting for a place…"),
    # Keys in viser's list of commands, which writes them as they are in its code.
    "space",
    "pageup",
    "pagedown",
)
"""Said by our scripts, or through them."""

VISERS: Final = (
    *("Connected", "Connecting...", "Inactive", "Connection rejected"),
    *("Search commands...", "No matching commands..."),
    *("Open navigation", "Close navigation", "Return to GUI", "Configuration & diagnostics", "Control panel"),
    *("Expand panel", "Minimize panel", "Expand column", "Collapse column", "Expand panels", "Minimize panels"),
    *("Collapse panel area", "Expand panel {name}", "Collapse panel {name}", "Expand plot", "Expand image"),
    *("Server", "Server URL", "Save Canvas", "Reset View", "Orbit Origin Tool", "Dev Settings", "Scene tree", "local"),
    "Show tool for setting the look-at point and",
    "up direction of the camera.",
    "This can be used to set the origin of the",
    "camera's orbit controls.",
    *("Dark Mode", "WebGL Stats", "Show Viser Logo", "Log Camera to Console", "Show Orbit Crosshair"),
    *("Device Pixel Ratio", "Adaptive", "Reset Panel Layout"),
    *("Log camera position and orientation to the", "Javascript console."),
    *("Show crosshair at look-at point", "when moving camera."),
    *("Device pixel ratio for rendering.", "Default (adaptive) behavior dynamically"),
    "reduces resolution to maintain framerates.",
    "Discard any panel rearrangement and restore the layout the server set.",
    *("Edit props for {name}", "Close props", "Local Props", "Invalid JSON"),
    *("Updates from the server will overwrite local changes.", "Client-local: only this client sees this node"),
    *("Toggle visibility override", "Clear visibility override", "Auto-created anchor for client-local children"),
    *("Uploading {name}", "File uploaded successfully.", "Receiving {name}", "Received {name}"),
    "WebGL unavailable",
    "WebGL is unavailable. This may be caused by hardware acceleration being disabled — check your browser settings.",
    *("Could not detect browser version", "Your browser version could not be detected. It may not be supported."),
    "Unsupported browser",
)
"""Said by viser's client; for {name} anything may stand."""

ALL: Final = (*OURS, *VISERS)

_SPOKEN: Final[tuple[Language, ...]] = ("de", "sl", "pseudo")


def client_script() -> str:
    """Return the script. It defines `duetWord(text)`, an English text of the list in the page's language, and `duetSpeak(language)`.

    Before the server has said which language the page has, it is the one of `<html data-words>`, the one of the link, or the
    browser's first one that is known.
    """
    tables = {name: {english: words_of(name)(english) for english in ALL} for name in _SPOKEN}
    told = json.dumps(tables, ensure_ascii=False).replace("<", "\\u003c")
    return _SCRIPT.replace("__TABLES__", told)


_SCRIPT: Final = r"""
(() => {
  const tables = __TABLES__, known = tables.pseudo;
  const asked = new URLSearchParams(location.search).get("lang");
  const liked = () => (navigator.languages || []).map((l) => l.slice(0, 2).toLowerCase()).find((l) => l === "en" || tables[l]);
  const given = document.documentElement.dataset.words || asked;
  let now = given === "en" || tables[given] ? given : liked() || "en";
  if (now !== "pseudo") document.documentElement.lang = now;
  const open = Object.keys(known).filter((k) => k.includes("{name}")).map((k) => [k, ...k.split("{name}")]);
  window.duetWord = (english) => {
    const table = tables[now];
    if (!table) return english;
    if (known[english]) return table[english];
    const fits = ([, a, b]) => english.startsWith(a) && english.endsWith(b) && english.length > a.length + b.length;
    const found = open.find(fits);
    if (!found) return english;
    const [key, begin, end] = found;
    return table[key].replace("{name}", () => english.slice(begin.length, english.length - end.length));
  };
  // What was English before, of everything that was said anew: another language begins with that, not with ours.
  const before = new WeakMap();
  const anew = (node, key, present, put) => {
    const text = present.trim();
    if (!text) return;
    const kept = before.get(node) || {}, same = kept[key] && kept[key].said === text;
    const english = same ? kept[key].english : text, said = window.duetWord(english);
    if (said === text || (said === english && !same)) return;
    kept[key] = { english, said };
    before.set(node, kept);
    put(present.replace(text, () => said));
  };
  const names = ["aria-label", "placeholder", "title"];
  const ours = (element) => element.closest?.(".duet, script, style, svg[data-duet]");
  const look = (node) => {
    if (node.nodeType === 3) {
      if (node.parentElement && !ours(node.parentElement)) anew(node, "text", node.data, (t) => { node.data = t; });
      return;
    }
    if (node.nodeType !== 1 || ours(node)) return;
    for (const name of names) {
      const value = node.getAttribute(name);
      if (value) anew(node, name, value, (t) => node.setAttribute(name, t));
    }
    for (const child of node.childNodes) look(child);
  };
  window.duetSpeak = (language) => {
    if (language === now) return;
    now = language;
    look(document.body);
  };
  addEventListener("DOMContentLoaded", () => {
    look(document.body);
    new MutationObserver((changes) => {
      for (const change of changes) {
        if (change.type === "childList") change.addedNodes.forEach(look);
        else if (change.type === "characterData") look(change.target);
        else if (!ours(change.target)) {
          const name = change.attributeName, value = change.target.getAttribute(name);
          if (value) anew(change.target, name, value, (t) => change.target.setAttribute(name, t));
        }
      }
    }).observe(document.body, { childList: true, subtree: true, characterData: true, attributes: true, attributeFilter: names });
  });
})();
"""
