"""Lesson cases of the core's `test_texts_fit.py`."""

import pytest
from playwright.sync_api import Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Enter
from app.features.lessons.session.lesson_session import LessonSession
from app.page.panels.controls import TABS
from app.session.session import Session
from tests.app.conftest import OpenHouse, ask, visitor_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.by_hand import visit
from tests.app.page.helpers import STAGES, USUAL_STAGE
from tests.app.page.test_texts_fit import BROKEN_ROWS
from tests.browser import PageAt, lasting, until, wait_frames
from tests.fonts import FONTS, Font
from tests.tools.lesson_walker import shown_step
from tests.tools.page_flaws import flaws

CUT_LABELS = """() => [...document.querySelectorAll('label[for]')].filter(label => label.offsetWidth).flatMap(label => {
  const column = label.closest('p'), row = column.parentElement.parentElement.getBoundingClientRect();
  const text = label.getBoundingClientRect(), box = column.getBoundingClientRect();
  const whole = column.scrollWidth <= column.clientWidth && text.right <= box.right + 1 && text.bottom <= row.bottom + 1
    && row.right <= innerWidth + 1;
  return whole ? [] : [label.textContent + ' ' + [column.scrollWidth, column.clientWidth, text.right, box.right]];
})"""


WIDE_FORMULAS = """() => [...document.querySelectorAll('.duet-lesson svg[aria-label]')].flatMap((svg) => {
  const { left, right } = svg.getBoundingClientRect(), box = svg.closest('.duet-formula,.duet-lesson').getBoundingClientRect();
  const out = Math.max(right - box.right, box.left - left);
  return out > 0.5 ? [`${svg.getAttribute('aria-label')}: ${out.toFixed(0)} px beyond its box`] : [];
})"""


def wide_formulas(page: Page, session: Session, run: LessonSession) -> list[str]:
    """Formulas of the present step and its explanation that are wider than their box."""
    found = lasting(page, lambda: page.evaluate(WIDE_FORMULAS))
    if "$$" in run.walk.step.explain:
        ask(session, lambda _: setattr(run.walk, "phase", Phase.EXPLAIN))
        numbered = "[...document.querySelectorAll('.duet-l-explain .duet-formula svg')].every((svg) => svg.role === 'group')"
        page.locator(".duet-l-explain .duet-formula").first.wait_for(state="attached")
        page.wait_for_function(f"document.querySelector('.duet-l-explain .duet-formula svg') && {numbered}")
        found += lasting(page, lambda: page.evaluate(WIDE_FORMULAS))
    return found


def see_labels(page: Page, session: Session) -> None:
    """Check the labels of every tab in experiments and laws with long labels, and the row of tabs."""
    tabs = page.get_by_role("tab")
    assert page.locator("[role=tablist]").first.get_by_role("tab").count() > len(TABS)
    assert lasting(page, lambda: page.evaluate(BROKEN_ROWS)) == []
    seen: set[str] = set()
    for key in ("d0", "gamma", "kr", "coupled", "kx"):

        def choose(s: Session, key: str = key) -> None:
            for k, value in (USUAL_STAGE | STAGES[key]).items():
                s.change(k, value)

        ask(session, choose)
        for i in range(len(TABS)) if key in ("d0", "kx") else (0,):
            tabs.nth(i).click()
            until(page, lambda i=i: tabs.nth(i).get_attribute("aria-selected") == "true", f"tab {i}")
            wait_frames(page, 3)
            assert lasting(page, lambda: page.evaluate(CUT_LABELS)) == []
            seen |= set(page.locator("label[for]:visible").all_inner_texts())
    assert len(seen) > 30


@pytest.mark.thorough
@pytest.mark.parametrize("font", FONTS)
@pytest.mark.parametrize(
    ("size", "language", "look", "words"),
    [
        ((1440, 900), "en", {"profile": "projector"}, "critical distance d_m [mm]"),
        ((1024, 768), "de", {"theme": "dark"}, "kritischer Abstand d_m [mm]"),
        ((390, 844), "sl", {}, "kritična razdalja d_m [mm]"),
    ],
)
def test_all_texts_of_page_controls_and_lessons_fit(
    size: tuple[int, int],
    language: str,
    look: dict[str, str],
    words: str,
    font: Font,
    house: OpenHouse,
    page_at: PageAt,
) -> None:
    page, opened = page_at(*size, font=font), house()
    session = visit(page, opened, f"autopilot=0&lang={language}")
    assert lasting(page, lambda: flaws(page)) == []
    before = session.settings.page
    ask(session, lambda s: [s.change(key, value) for key, value in look.items()])
    page.get_by_text(words, exact=True).wait_for()
    see_labels(page, session)
    ask(session, lambda s: [s.change(key, getattr(before, key)) for key in look])
    run = lessons_of(visitor_of(opened))
    ask(session, lambda _: run.act(Enter(0)))
    found: list[str] = []
    # The last lesson has the texts of the first. The large window has the widest panel and the shortest
    # words: one step per lesson is enough there.
    for lesson in run.book.lessons[:-1]:
        for step in range(1 if language == "en" else len(lesson.steps)):
            shown_step(page, session, run, lesson.number - 1, step)
            wait_frames(page, 3)
            flawed = lasting(page, lambda: flaws(page))
            found += [
                f"{lesson.number}.{step + 1}: {flaw}"
                for flaw in (*flawed, *wide_formulas(page, session, run))
            ]
    assert found == []
