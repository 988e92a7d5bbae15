"""Facts of a browser's request."""

from __future__ import annotations

import re
from typing import Final, cast

import viser

from app.i18n.reader_language import preferred
from app.settings import Language
from app.web.pages import accepted_languages, page_query
from app.web.server import DuetServer
from app.web.viser_internals import request_of, server_of

_ADDRESS: Final = re.compile(r"https?://[A-Za-z0-9.\-]+(:\d{1,5})?|https?://\[[0-9A-Fa-f:.]+\](:\d{1,5})?")
_FOLDER: Final = re.compile(r"(/[\w.~%-]+)*", re.ASCII)


def request_query(client: viser.ClientHandle) -> dict[str, str]:
    """Query (`?dm=0.1&n=10`), unchecked; empty if it is missing or the browser is gone."""
    request = request_of(client)
    return {} if request is None else page_query(request.path)


def frames_of(client: viser.ClientHandle) -> bool:
    """True if foreign pages may show this one in a frame."""
    return bool(cast(DuetServer, server_of(client)).embed_origins)


def browser_language(client: viser.ClientHandle) -> Language:
    """Favourite among our languages; English if the browser is gone."""
    request = request_of(client)
    return "en" if request is None else preferred(accepted_languages(request))


def request_address(client: viser.ClientHandle) -> str:
    """Address of the page in a browser, perhaps with a proxy's folder (https://example.org/duet)."""
    request = request_of(client)
    headers = {} if request is None else request.headers
    origin, host = headers.get("Origin", ""), headers.get("Host", "")
    folder = request_query(client).get("folder", "")
    if _ADDRESS.fullmatch(origin):
        return origin + (folder if _FOLDER.fullmatch(folder) else "")
    return (
        f"http://{host}" if _ADDRESS.fullmatch(f"http://{host}") else cast(DuetServer, server_of(client)).url
    )
