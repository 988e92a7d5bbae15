"""The documents that teachers read, as the server gives them out."""

import re
import urllib.error
import urllib.request
from html.parser import HTMLParser

import pytest

from app.text.documents import DOCUMENTS, FOLDER, document_html, document_page
from tests.app.conftest import OpenHouse

VOID = {"br", "hr", "img", "meta", "path", "rect", "circle", "line", "use", "polyline", "ellipse"}


class Tags(HTMLParser):
    """Which elements are open; an AssertionError if one closes what is not."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attrs if name in ("href", "src")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_document_is_whole(name: str) -> None:
    read = Tags()
    read.feed(document_page(name).decode())
    assert read.open == []
    # Nothing comes from elsewhere, and what it points to on this server exists.
    here = {link for link in read.links if not link.startswith(("https://", "data:"))}
    assert here <= {"../", *DOCUMENTS}
    title = (FOLDER / DOCUMENTS[name][0]).read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
    assert title.replace("`", "") in read.text
    assert not re.search("[\ue000\ue001]", read.text)


def test_formulas_tables_and_numbers_of_equations() -> None:
    page = document_page("model").decode()
    assert (
        page.count("<svg") > 20 and "<table>" in page and "(30, 32, 33)" in page and "$" not in re.sub("<svg.*?</svg>", "", page)
    )


def test_code_keeps_its_dollars_and_html_stays_text() -> None:
    made = document_html("`$a$` and $a$ and <b onclick=x>b</b>\n\n```sh\necho $HOME $HOME\n```\n")
    assert "<code>$a$</code>" in made and made.count("<svg") == 1
    assert "echo $HOME $HOME" in made and "<b onclick" not in made


def test_the_server_gives_them_out(house: OpenHouse) -> None:
    url = house().url
    with urllib.request.urlopen(f"{url}/documents/model", timeout=60) as answer:
        assert answer.status == 200 and answer.headers["Content-Type"].startswith("text/html")
        assert answer.read() == document_page("model")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{url}/documents/10-limits.notes", timeout=60)
