"""The small panel on a phone: few controls, all on request; the browser remembers the choice."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.page.panels.controls import SMALL
from app.session.relevant_settings import matters
from app.session.session import Session
from tests.accessibility import accessible
from tests.app.conftest import Arrive, OpenHouse, ask
from tests.app.page.by_hand import drag, visit
from tests.app.page.helpers import ON_PAGE, bodies, page_label
from tests.app.page.shared_page import Shared, SharedPage
from tests.browser import CAMERA, PageAt, screenshot, settled_view, until

SHARED = SharedPage(390, 844, "panel=small")


def labels_of(page: Page) -> set[str]:
    """Labels of the panel's visible controls."""
    return {page_label(key) for key in ON_PAGE} & set(page.locator("label:visible").all_inner_texts())


def see_few_controls(page: Page, session: Session) -> None:
    few = {page_label(key) for key in SMALL if matters(key, session.settings)}
    until(page, lambda: labels_of(page) == few, "few controls")


@pytest.mark.thorough
def test_a_phone_begins_with_few_controls(shared: Shared) -> None:
    page = shared.page
    see_few_controls(page, shared.session)
    assert not page.get_by_role("tab", name="Arms").is_visible()
    assert not page.get_by_role("button", name="Keep and replay").is_visible()

    def is_not_praised() -> bool:
        status = page.locator(".duet-status")
        return status.count() > 0 and page.locator(".duet-status > .go:visible").count() == 0

    until(page, is_not_praised, "no praise")
    accessible(page)
    screenshot(page, "small-panel")


@pytest.mark.thorough
def test_a_list_of_lessons_shows_every_control_while_it_is_open(shared: Shared) -> None:
    """A lesson may need any control."""
    page = shared.page
    see_few_controls(page, shared.session)
    page.get_by_role("button", name="Lessons", exact=True).click()
    until(page, lambda: page_label("rig") in labels_of(page), "every control")
    page.get_by_role("button", name="Close the list").click()
    see_few_controls(page, shared.session)


@pytest.mark.thorough
def test_the_tone_of_lambda_sounds_only_on_request(shared: Shared) -> None:
    page, session = shared.page, shared.session
    page.get_by_role("button", name="Pause", exact=True).click()
    until(page, lambda: session.paused, "a pause")
    tone = page.get_by_role("button", name="λ as a tone")
    wanted = 220.0 * 4.0 ** ask(session, lambda s: s.simulation.sample().activation)
    assert tone.get_attribute("aria-pressed") == "false" and not tone.get_attribute("data-hertz")
    tone.click()
    until(
        page,
        lambda: int(tone.get_attribute("data-hertz") or 0) == pytest.approx(wanted, abs=2.0),
        "the tone of λ",
    )
    tone.click()
    until(page, lambda: not tone.get_attribute("data-hertz"), "silence")


@pytest.mark.thorough
def test_a_button_restores_a_turned_view(shared: Shared) -> None:
    page = shared.page
    page.get_by_role("button", name="Pause", exact=True).click()
    until(page, lambda: shared.session.paused, "a pause")
    view = settled_view(page)
    drag(page, [(20, 400), (145, 400)])
    until(page, lambda: not np.allclose(page.evaluate(CAMERA), view, atol=0.05), "a turned view")
    page.get_by_role("button", name="First view").click()
    until(page, lambda: np.allclose(page.evaluate(CAMERA)[3:], view[3:], atol=2e-3), "the first view")


@pytest.mark.thorough
def test_a_browser_remembers_the_chosen_panel(shared: Shared, page_at: PageAt) -> None:
    page = page_at(390, 844)
    session = visit(page, shared.opened, "panel=small")
    page.get_by_role("button", name="All settings").click()
    page.get_by_role("tab", name="Arms").click()
    page.get_by_role("button", name="Keep and replay").wait_for()
    until(page, lambda: page.evaluate("localStorage.duetPanel") == "all", "what the browser keeps")
    page.goto(shared.opened.url)
    page.get_by_role("button", name="Fewer settings").click()
    # The open tab is gone, too.
    see_few_controls(page, session)
    until(
        page, lambda: page.evaluate("localStorage.duetPanel") == "small", "what the browser keeps from now on"
    )


def test_a_phone_has_a_view_button_and_less_motion_means_a_pause(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    phone = arrive(opened, "window=390x844&motion=less")
    assert phone.session.paused, "the run moves although the visitor wants less motion"
    desk = arrive(opened, "window=1440x900")
    assert not desk.session.paused
    groups = [bodies(one.visitor, "GuiButtonGroupMessage") for one in (phone, desk)]
    assert [any("First view" in row["options"] for row in rows) for rows in groups] == [True, False]
