"""What those see who just play: a few controls, on a phone; all of them when they ask, and from then on in this browser."""

import numpy as np
import pytest

from app.page.panels.controls import SMALL
from app.session.relevant_settings import matters
from tests.accessibility import accessible
from tests.app.conftest import Arrive, OpenHouse, ask
from tests.app.page.by_hand import drag, visit
from tests.app.page.helpers import ON_PAGE, bodies, page_label
from tests.browser import CAMERA, PageAt, screenshot, settled_view, until


@pytest.mark.thorough
def test_a_phone_begins_with_few_controls_and_its_browser_keeps_all(
    house: OpenHouse, page_at: PageAt
) -> None:
    page, opened = page_at(390, 844), house()
    session = visit(page, opened, "panel=small")
    shown = [key for key in SMALL if matters(key, session.settings)]
    few, every = ({page_label(key) for key in keys} for keys in (shown, ON_PAGE))
    labels, tab = page.locator("label:visible"), page.get_by_role("tab", name="Arms")
    until(page, lambda: every & set(labels.all_inner_texts()) == few, "few controls")
    assert not tab.is_visible() and not page.get_by_role("button", name="Keep and replay").is_visible()
    until(
        page,
        lambda: (
            page.locator(".duet-status").count() and not page.locator(".duet-status > .go:visible").count()
        ),
        "no praise",
    )
    accessible(page)
    screenshot(page, "small-panel")
    # A lesson asks for any of them.
    page.get_by_role("button", name="Lessons", exact=True).click()
    until(page, lambda: "rig" in labels.all_inner_texts(), "every control")
    page.get_by_role("button", name="Close the list").click()
    until(page, lambda: every & set(labels.all_inner_texts()) == few, "few controls again")
    page.get_by_role("button", name="Pause", exact=True).click()
    until(page, lambda: session.paused, "a pause")
    # λ is silent until it is asked for.
    tone, lam = (
        page.get_by_role("button", name="λ as a tone"),
        ask(session, lambda s: s.simulation.sample().activation),
    )
    assert tone.get_attribute("aria-pressed") == "false" and not tone.get_attribute("data-hertz")
    tone.click()
    until(
        page,
        lambda: int(tone.get_attribute("data-hertz") or 0) == pytest.approx(220.0 * 4.0**lam, abs=2.0),
        "the tone of λ",
    )
    tone.click()
    until(page, lambda: not tone.get_attribute("data-hertz"), "silence")
    view = settled_view(page)
    drag(page, [(20, 400), (145, 400)])
    until(page, lambda: not np.allclose(page.evaluate(CAMERA), view, atol=0.05), "a turned view")
    page.get_by_role("button", name="First view").click()
    until(page, lambda: np.allclose(page.evaluate(CAMERA)[3:], view[3:], atol=2e-3), "the first view")
    page.get_by_role("button", name="All settings").click()
    tab.click()
    page.get_by_role("button", name="Keep and replay").wait_for()
    until(page, lambda: page.evaluate("localStorage.duetPanel") == "all", "what the browser keeps")
    page.goto(opened.url)
    page.get_by_role("button", name="Fewer settings").click()
    # The tab that was open is not what is left.
    until(page, lambda: every & set(labels.all_inner_texts()) == few, "few controls once more")
    until(
        page, lambda: page.evaluate("localStorage.duetPanel") == "small", "what the browser keeps from now on"
    )


def test_a_phone_has_a_button_for_the_view_and_a_browser_that_wants_less_motion(
    house: OpenHouse, arrive: Arrive
) -> None:
    opened = house()
    phone = arrive(opened, "window=390x844&motion=less")
    assert phone.session.paused, "nothing moves until it is asked for"
    desk = arrive(opened, "window=1440x900")
    assert not desk.session.paused
    groups = [bodies(one.visitor, "GuiButtonGroupMessage") for one in (phone, desk)]
    assert [any("First view" in row["options"] for row in rows) for rows in groups] == [True, False]
