"""The controls' labels, words first: none is cut off, in any language and window."""

import pytest

from app.page.panels.controls import TABS
from app.session.session import Session
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import visit
from tests.app.page.helpers import STAGES, USUAL_STAGE
from tests.browser import PageAt, screenshot, wait_frames

CUT_LABELS = """() => [...document.querySelectorAll('label[for]')].filter(label => label.offsetWidth).flatMap(label => {
  const column = label.closest('p'), row = column.parentElement.parentElement.getBoundingClientRect();
  const text = label.getBoundingClientRect(), box = column.getBoundingClientRect();
  const whole = column.scrollWidth <= column.clientWidth && text.right <= box.right + 1 && text.bottom <= row.bottom + 1
    && row.right <= innerWidth + 1;
  return whole ? [] : [label.textContent + ' ' + [column.scrollWidth, column.clientWidth, text.right, box.right]];
})"""


@pytest.mark.parametrize(
    ("width", "height", "query", "words"),
    [
        (1440, 900, "lang=en&profile=projector", "critical distance d_m [mm]"),
        (1024, 768, "lang=de&theme=dark", "kritischer Abstand d_m [mm]"),
        (390, 844, "lang=sl", "kritična razdalja d_m [mm]"),
    ],
)
def test_no_label_is_cut_off(house: OpenHouse, page_at: PageAt, width: int, height: int, query: str, words: str) -> None:
    page = page_at(width, height)
    session = visit(page, house(), f"{query}&autopilot=0")
    page.get_by_text(words, exact=True).wait_for()
    tabs = page.get_by_role("tab")
    seen: set[str] = set()
    for key in ("d0", "gamma", "kr", "coupled", "kx"):

        def choose(s: Session, key: str = key) -> None:
            for k, value in (USUAL_STAGE | STAGES[key]).items():
                s.change(k, value)

        ask(session, choose)
        for i in range(len(TABS)) if key in ("d0", "kx") else (0,):
            tabs.nth(i).click()
            wait_frames(page, 3)
            assert page.evaluate(CUT_LABELS) == []
            seen |= set(page.locator("label[for]:visible").all_inner_texts())
    assert len(seen) > 30
    screenshot(page, f"labels-{width}")
