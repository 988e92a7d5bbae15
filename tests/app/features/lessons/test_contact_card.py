"""Tests of lessons beside those of the core in the file `test_contact_card.py`."""

import pytest

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, Press
from tests.app.conftest import OpenHouse, ask
from tests.app.features.lessons.helpers import unfold_controls
from tests.browser import PageAt, screenshot, until
from tests.tools.lesson_walker import enter, shown_step

LAW = (
    "#duet-contact .curve",
    "#duet-contact text.lam",
    "#duet-contact text.rest",
    "#duet-contact .term",
    "#duet-contact .trend",
)


@pytest.mark.thorough
def test_the_card_keeps_back_what_a_lesson_asks_and_d_lights_up_in_its_formulas(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(1280, 800)
    session, run = enter(page, house(), "lesson=3&step=1&lang=en")
    pill = page.locator(".duet-status").filter(has_text="is promised")

    def seen() -> list[str]:
        return [
            part
            for part in LAW
            if any(text.strip() for text in page.locator(f"{part}:visible").all_text_contents())
        ]

    # The words "an endless retreat", the curve to be drawn, the resting distance, and what the next steps make of an error.
    for lesson, step in ((2, 0), (3, 1), (5, 0), (1, 2)):
        shown_step(page, session, run, lesson, step)
        page.locator("#duet-contact.asks").wait_for()
        until(page, lambda: page.locator("#duet-contact .gap b").inner_text() != "", "d, or |e|")
        until(page, lambda: pill.count() == 0, "no word of the promise")
        assert seen() == [] and not page.locator("#duet-contact .curve").is_visible()
        assert page.locator("#duet-contact .note").inner_text() == ""
        label = page.locator("#duet-contact-picture").get_attribute("aria-label") or ""
        assert "λ" not in label and "priority" not in label and "grows" not in label
        assert page.evaluate("duet.symbols?.lam") is None
        screenshot(page, f"asks-{lesson + 1}.{step + 1}")
    assert page.get_by_text("unstable").count() == 0
    shown_step(page, session, run, 3, 1)
    # Here d lights up in the formulas, too.
    inline = page.locator(".duet-lesson p path.d")
    inline.first.wait_for()

    def lit_in_the_text() -> bool:
        inline.first.hover(force=True)
        return inline.first.evaluate("(d) => d.classList.contains('duet-lit')")

    until(page, lit_in_the_text, "d in a line of text")
    until(page, lambda: page.locator("#duet-contact .d.duet-lit").count() > 0, "d in the card")
    page.mouse.move(640, 300)
    ask(session, lambda _: run.act(Choose(0)))
    ask(session, lambda _: run.act(Press("run")))
    until(
        page,
        lambda: {LAW[1], LAW[3], LAW[4]} <= set(seen()),
        "the law, now that the prediction is given and it runs",
    )
    page.locator("#duet-contact .curve").wait_for()
    unfold_controls(page)
    pill.first.wait_for()
    ask(session, lambda _: setattr(run.walk, "phase", Phase.EXPLAIN))
    hits = page.locator(".duet-l-explain .hit[data-symbol=d]")
    hits.first.wait_for()
    page.mouse.move(640, 300)

    def lit_in_the_equation() -> bool:
        # It is drawn again with the run's numbers, and has lost the focus then.
        hits.nth(1).focus()
        return page.locator(".duet-l-explain path.d.duet-lit").count() == 4

    until(page, lit_in_the_equation, "d in eq. (31)")
