"""The pages that Duet serves itself: viser's client, one HTML file, with our scripts before it, and the one for a full room."""

from __future__ import annotations

import html
import re
from functools import lru_cache
from urllib.parse import parse_qsl, quote, urlsplit

from app.i18n.client_texts import CROWDED, KEPT_OUT, LOST, SILENT, WAIT
from app.web.page_assets import NO_ASSETS, STATIC, PageAssets, translation

ROOM_IS_FULL = "duet: every place is taken"
ELSEWHERE = "duet: this tab belongs somewhere else"
OPEN_TOO_OFTEN = "duet: too many connections of one tab"
HELLO = "DuetHello"
"""Kind of the message by which a page says that it is one: what viser's client says first waits until the scene is in view."""
QUESTION = "DuetQuestion"
"""Kind of the message by which a page that hears nothing asks whether the server is still there."""
HIDDEN, SHOWN = "DuetHidden", "DuetShown"
"""Kinds of the messages by which a page says that its tab is out of sight, and in sight again."""
KEY_LATER = "duet: one key a second"
_LONGEST_QUERY = 4000
_MOST_FIELDS, _LONGEST_KEY, _LONGEST_VALUE = 64, 40, 400

MARK = (STATIC / "mark.svg").read_text(encoding="utf-8").strip()
"""Our mark, as SVG."""

_ICON = f'<link rel="icon" href="data:image/svg+xml,{quote(MARK)}">'


def patched_index(client_html: str, *, title: str, run: str, assets: PageAssets = NO_ASSETS, body: str = "") -> str:
    """Put our additions into viser's page.

    Args:
        client_html: viser's own `index.html`.
        run: a word that is different for every start of the server.
        assets: further scripts and style sheets; a script may add to `duet.query` what the server is to know of the browser.
        body: HTML that the page's body begins with.

    Raises:
        ValueError: the page doesn't look as expected (another version of viser).
    """
    head, mark, rest = client_html.partition("<title>Viser</title>")
    program, end, root = rest.rpartition("</head>")
    if not (mark and end):
        raise ValueError("viser's page has no title in its head to put Duet's additions at")
    assets = PageAssets((STATIC / "page_query.js",)) + translation() + assets + _connection(run)
    head = re.sub(r'<link\s+rel="icon".*?/>', _ICON, head, flags=re.DOTALL)
    head = head.replace('content="Viser client"', 'content="Two robot arms, and one that gives way"')
    # viser's program is long: in the body, behind what is seen until it has arrived.
    ours = f"<title>{html.escape(title)}</title>{assets.style_html()}{assets.script_html()}</head><body>{body}"
    return head + ours + program + root.replace("<body>", "", 1)


def _connection(run: str) -> PageAssets:
    constants = {
        "run": run,
        "longestQuery": _LONGEST_QUERY,
        "messages": {"hello": HELLO, "question": QUESTION, "hidden": HIDDEN, "shown": SHOWN},
        "reasons": {"full": ROOM_IS_FULL, "elsewhere": ELSEWHERE, "tooMany": OPEN_TOO_OFTEN, "wait": KEY_LATER},
        "texts": {"lost": LOST, "silent": SILENT, "refused": KEPT_OUT, "tooMany": CROWDED, "wait": WAIT},
    }
    return PageAssets((STATIC / "connection.js",), (STATIC / "connection.css",), {"connection": constants})


def page_query(request_path: str) -> dict[str, str]:
    """Return the query in the path of a request, with bounds on the number and length of its fields; validate every value."""
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


@lru_cache(8)
def full_page(limit: int) -> str:
    """Return the page for while all `limit` places are taken, in the language of the link or the browser; it asks again by itself."""
    one = "This Duet has one place, and it is taken."
    places = one if limit == 1 else f"This Duet has {limit} places, and all of them are in use."
    assets = translation() + PageAssets((STATIC / "room_full.js",), (STATIC / "room_full.css",))
    page = (STATIC / "room_full.html").read_text(encoding="utf-8")
    parts = {"__ICON__": _ICON, "__PLACES__": places, "__STYLES__": assets.style_html(), "__SCRIPTS__": assets.script_html()}
    for name, value in parts.items():
        page = page.replace(name, value)
    return page
