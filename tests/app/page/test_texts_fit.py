"""No text of the page is cut off, covered or written over another one: at first sight and in every step of every lesson, at three sizes."""

import pytest

from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import visit
from tests.browser import PageAt, wait_frames
from tests.tools.lesson_walker import enter, shown_step
from tests.tools.page_flaws import flaws

SIZES = ((1440, 900), (1024, 768), (390, 844))


@pytest.mark.parametrize(
    ("body", "kinds"),
    [
        ("<p>one line</p><p>another</p>", []),
        ('<p style="width:30px;overflow:hidden;white-space:nowrap">much too long for that</p>', ["cut at a side"]),
        ('<p style="height:9px;overflow:hidden">one<br>two</p>', ["cut above or below"]),
        ('<div style="height:30px;overflow:auto">one<br>two<br>three<br>four</div>', []),
        ('<p>under</p><div style="position:fixed;inset:0;background:#fff"></div>', ["covered by"]),
        ('<p style="position:absolute;top:5px">first</p><p style="position:absolute;top:8px">second</p>', ["over each other"]),
        ('<p style="position:absolute;left:-20px">half outside</p>', ["cut at a side"]),
    ],
)
def test_flaws_are_found(body: str, kinds: list[str], page_at: PageAt) -> None:
    page = page_at(300, 200)
    page.set_content(body)
    found = flaws(page)
    assert {text.split(":")[0].split(" p.")[0].split(" div.")[0] for text in found} >= set(kinds)
    assert bool(found) == bool(kinds), found


@pytest.mark.parametrize("size", SIZES)
def test_the_page_as_it_opens(size: tuple[int, int], house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(*size)
    visit(page, house(), "autopilot=0")
    assert flaws(page) == []


@pytest.mark.parametrize(("size", "language"), [*zip(SIZES, ("en", "de", "sl"), strict=True)])
def test_every_step_of_every_lesson(size: tuple[int, int], language: str, house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(*size)
    session, run = enter(page, house(), f"lesson=1&lang={language}")
    found: list[str] = []
    for lesson in range(len(run.book.lessons)):
        for step in range(len(run.book.lessons[lesson].steps)):
            shown_step(page, session, run, lesson, step)
            wait_frames(page, 3)
            found += [f"{lesson + 1}.{step + 1}: {flaw}" for flaw in flaws(page)]
    assert found == []
