"""The style sheet of a class is on every page."""

from urllib.request import urlopen

from app.features.classroom import CLASSROOM, STATIC
from app.web.pages import sent_text
from tests.app.conftest import OpenHouse


def test_the_style_sheet_is_on_the_page(house: OpenHouse) -> None:
    assert CLASSROOM.assets is not None
    styles = CLASSROOM.assets().styles
    assert {*styles} == {*STATIC.iterdir()}
    with urlopen(house().url, timeout=60.0) as answer:
        page = answer.read().decode()
    assert all(sent_text(file) in page for file in styles)
