"""viser's client with our scripts and styles, and the page of a full server."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Final
from urllib.parse import parse_qsl, quote

from markupsafe import Markup
from websockets.http11 import Request

from app.i18n.client_texts import CROWDED, KEPT_OUT, LOST, OPEN_TWICE, SILENT, SOFTWARE, translations
from app.settings import LANGUAGES_KEY, PUSH, is_appended, mended_key
from app.theme import css_variables

STATIC: Final = Path(__file__).parent / "static"


@dataclass(frozen=True)
class PageAssets:
    """Files of a page in running order; `constants` for `window.duet`, as JSON."""

    scripts: tuple[Path, ...] = ()
    styles: tuple[Path, ...] = ()
    constants: Mapping[str, object] = field(default_factory=dict)

    def __add__(self, other: PageAssets) -> PageAssets:
        return PageAssets(
            self.scripts + other.scripts, self.styles + other.styles, {**self.constants, **other.constants}
        )

    def style_html(self) -> Markup:
        return Markup(f"<style>{css_variables()}{_joined(self.styles)}</style>")

    def script_html(self) -> Markup:
        """Script that sets `window.duet`, and runs all files in strict mode."""
        constants = json.dumps(self.constants, ensure_ascii=False).replace("<", "\\u003c")
        first = f"window.duet = {constants};\n" if self.constants else ""
        return Markup(f'<script>"use strict";\n{first}{_joined(self.scripts)}</script>')


NO_ASSETS: Final = PageAssets()


_COMMENTS: Final = {
    ".js": re.compile(r"^\s*//.*\n", re.MULTILINE),
    ".css": re.compile(r"/\*.*?\*/\s*", re.DOTALL),
}


def sent_text(file: Path) -> str:
    return _COMMENTS[file.suffix].sub("", file.read_text(encoding="utf-8"))


def _joined(files: tuple[Path, ...]) -> str:
    return "".join(map(sent_text, files))


def translation() -> PageAssets:
    """Translation of the browser's own parts."""
    return PageAssets((STATIC / "translation.js",), constants={"translations": translations()})


def software_rendering() -> PageAssets:
    """Warning of drawing without a graphics card; needs `translation` and the event `duet-built`."""
    return PageAssets(
        (STATIC / "software_rendering.js",),
        (STATIC / "software_rendering.css",),
        constants={"softwareNote": SOFTWARE},
    )


ROOM_IS_FULL = "duet: every place is taken"
ELSEWHERE = "duet: this tab belongs somewhere else"
OPEN_TOO_OFTEN = "duet: too many connections of one tab"
TAKEN_OVER = "duet: another tab of this browser goes on"
HELLO = "DuetHello"
"""First message of a page: viser's client sends none until the scene is visible."""
QUESTION = "DuetQuestion"
HIDDEN, SHOWN = "DuetHidden", "DuetShown"
_LONGEST_QUERY = 4000
_MOST_FIELDS, _LONGEST_KEY, _LONGEST_VALUE = 64, 40, 400
LONGEST_PUSH = 3000  # as in `scenes.run_text`

MARK = (STATIC / "mark.svg").read_text(encoding="utf-8").strip()

_ICON = f'<link rel="icon" href="data:image/svg+xml,{quote(MARK)}">'


def patched_index(client_html: str, *, title: str, assets: PageAssets = NO_ASSETS, body: str = "") -> str:
    """Add our parts to viser's page.

    Args:
        assets: a script may extend `duet.query`.
        body: HTML at the beginning of the body.

    Raises:
        ValueError: another version of viser.
    """
    head, mark, rest = client_html.partition("<title>Viser</title>")
    program, end, root = rest.rpartition("</head>")
    if not (mark and end):
        raise ValueError("viser's page has no title in its head to put Duet's additions at")
    assets = PageAssets((STATIC / "page_query.js",)) + translation() + assets + _connection()
    head = re.sub(r'<link\s+rel="icon".*?/>', _ICON, head, flags=re.DOTALL)
    head = head.replace('content="Viser client"', 'content="Two robot arms, and one that gives way"')
    # viser's program is long: in the body, after what is shown until it arrives.
    ours = (
        f"<title>{html.escape(title)}</title>{assets.style_html()}{assets.script_html()}</head><body>{body}"
    )
    return head + ours + program + root.replace("<body>", "", 1)


def _connection() -> PageAssets:
    constants = {
        "longestQuery": _LONGEST_QUERY,
        "longestPush": LONGEST_PUSH,
        "messages": {"hello": HELLO, "question": QUESTION, "hidden": HIDDEN, "shown": SHOWN},
        "reasons": {
            "full": ROOM_IS_FULL,
            "elsewhere": ELSEWHERE,
            "tooMany": OPEN_TOO_OFTEN,
            "takenOver": TAKEN_OVER,
        },
        "texts": {
            "lost": LOST,
            "silent": SILENT,
            "refused": KEPT_OUT,
            "tooMany": CROWDED,
            "takenOver": OPEN_TWICE,
        },
    }
    scripts = STATIC / "same_html.js", STATIC / "entries.js", STATIC / "connection.js"
    return PageAssets(scripts, (STATIC / "connection.css",), {"connection": constants})


def accepted_languages(request: Request) -> str:
    """From the page's query, else from the header `Accept-Language`."""
    said = page_query(request.path).get(LANGUAGES_KEY)
    return said or ",".join(request.headers.get_all("Accept-Language"))


def page_query(request_path: str) -> dict[str, str]:
    """Query of a request, limited in number and length of fields; values are unchecked. Drops what others
    append, and repairs &amp;."""
    query = request_path[: 2 * _LONGEST_QUERY].partition("?")[2]
    try:
        fields = parse_qsl(query, keep_blank_values=True, max_num_fields=_MOST_FIELDS)
    except ValueError:
        return {}
    found: dict[str, str] = {}
    for key, value in ((mended_key(key), value) for key, value in fields):
        if is_appended(key):
            continue
        if key == PUSH:
            # One character more, so that a too long value is reported as such.
            found.setdefault(key, value[: LONGEST_PUSH + 1])
        elif 0 < len(key) <= _LONGEST_KEY and len(value) <= _LONGEST_VALUE:
            found.setdefault(key, value)
    return found


@lru_cache(8)
def full_page(limit: int) -> str:
    """Self-reloading page of a full server with `limit` places."""
    one = "This Duet has one place, and it is taken."
    places = one if limit == 1 else f"This Duet has {limit} places, and all of them are in use."
    assets = translation() + PageAssets((STATIC / "room_full.js",), (STATIC / "room_full.css",))
    page = (STATIC / "room_full.html").read_text(encoding="utf-8")
    parts = {
        "__ICON__": _ICON,
        "__PLACES__": places,
        "__STYLES__": assets.style_html(),
        "__SCRIPTS__": assets.script_html(),
    }
    for name, value in parts.items():
        page = page.replace(name, value)
    return page
