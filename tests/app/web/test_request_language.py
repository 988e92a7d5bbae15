"""Language of a request: the page's own list precedes the header, which a worker's websocket may lack."""

import pytest
from websockets.datastructures import Headers
from websockets.http11 import Request

from app.i18n.reader_language import preferred
from app.web.pages import accepted_languages


@pytest.mark.parametrize(
    ("path", "header", "language"),
    [
        ("/?languages=sl-SI%2Cen&dm=0.1", "en-US", "sl"),
        ("/?languages=fr,de-AT", "", "de"),
        ("/?dm=0.1", "de-DE,en;q=0.5", "de"),
        ("/?languages=", "sl", "sl"),
        ("/", "", "en"),
    ],
)
def test_the_pages_languages_precede_the_header(path: str, header: str, language: str) -> None:
    headers = Headers({"Accept-Language": header} if header else {})
    assert preferred(accepted_languages(Request(path, headers))) == language
