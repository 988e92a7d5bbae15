"""A lecture's scripts and style sheets are on every page, after the core's."""

import re
from urllib.request import urlopen

from app.features.lecture import LECTURE, STATIC
from app.web.pages import sent_text
from tests.app.conftest import OpenHouse


def test_every_script_and_style_sheet_is_on_the_page(house: OpenHouse) -> None:
    assert LECTURE.assets is not None
    assets = LECTURE.assets()
    assert {*assets.scripts} == {*STATIC.glob("*.js")} and {*assets.styles} == {*STATIC.glob("*.css")}
    with urlopen(house().url, timeout=60.0) as answer:
        page = answer.read().decode()
    places = [page.find(sent_text(file)) for file in (*assets.styles, *assets.scripts)]
    assert min(places) > 0 and places == sorted(places)
    # A lecture's texts are added to a table that must exist already.
    assert page.index("duet.holders = {") < page.index("duet.holders;\n")


def test_the_sticky_banner_is_not_opaque() -> None:
    # With an opaque banner Chromium sometimes treats the scene above as covered; too rare for a browser test.
    sheet = (STATIC / "lecture.css").read_text(encoding="utf-8")
    (sticks,) = re.findall(r"\[data-duet-holds~=banner\]\{([^}]*)\}", sheet)
    assert "position:sticky" in sticks and re.search(r"opacity:\.9\d*", sticks)
