"""Two people in two tabs: one invites, the other opens the link and pulls the silver arm with the mouse."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.features.second_person.guest import ENDED
from app.i18n.catalogue import words_of
from app.session.session import Session
from app.settings import Settings
from scenes.settings import RunSettings
from scenes.targets import LinkTarget
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import grab, visit
from tests.browser import (
    CAMERA,
    PageAt,
    screenshot,
    settled_view,
    until,
    wait_ready,
    world_position,
    world_to_px,
)

HAND_LINK = "/arms/{}/base/j1/j2/j3/j4/j5/j6"
SENTENCE = "#duet-overlay h2"


@pytest.mark.thorough
def test_a_second_person_opens_the_link_and_pulls_the_silver_arm(house: OpenHouse, page_at: PageAt) -> None:
    mine = page_at(1440, 900)
    session = visit(mine, house(Settings(run=RunSettings(scene="hold", avoid="both"))), "autopilot=0")
    theirs = page_at(1024, 768, fresh=True, locale="de-DE")
    theirs.goto(f"{invitation(mine)}&theme=dark")
    wait_ready(theirs, "/room")
    theirs.get_by_text("Sie halten den silbernen Arm").first.wait_for()
    mine.get_by_text("The second person is here").first.wait_for()
    pull_the_silver_arm(theirs, mine, session)
    # The guest's keys move the guest's arm and do not pause.
    theirs.keyboard.press("Space")
    theirs.keyboard.press("ArrowUp")
    until(theirs, lambda: session.hand.other is not None, "a nudge")
    assert not session.paused and session.held is None

    mine.get_by_role("button", name="End the invitation").click()
    theirs.locator(SENTENCE, has_text=words_of("de")(ENDED)).wait_for()
    screenshot(theirs, "two-ended")
    theirs.set_viewport_size({"width": 390, "height": 844})
    screenshot(theirs, "two-ended-phone")


def invitation(mine: Page) -> str:
    mine.get_by_role("button", name="Two people, one arm each").click()
    mine.get_by_role("button", name="Invite a second person").click()
    box = mine.get_by_label("Link for the second person")
    box.wait_for()
    assert mine.locator(".duet-join svg[role=img]").is_visible()
    screenshot(mine, "two-invited")
    return box.input_value()


def pull_the_silver_arm(theirs: Page, mine: Page, session: Session) -> None:
    silver, orange = (HAND_LINK.format(arm.name) for arm in (session.simulation.avoiding, session.hand.arm))
    view = settled_view(theirs)
    before = ask(session, lambda s: s.simulation.positions.copy())
    # The guest cannot pull the orange arm.
    theirs.mouse.move(*world_to_px(theirs, world_position(theirs, orange)))
    x, y = grab(theirs, silver, lambda: isinstance(session.hand.other, LinkTarget))
    for step in range(1, 13):
        theirs.mouse.move(x + 6.0 * step, y - 2.0 * step)
    moved = session.simulation.avoiding.joints
    far = lambda s: np.abs(s.simulation.positions - before)[moved].max() > 0.05  # noqa: E731
    until(theirs, lambda: ask(session, far), "the silver arm moves")
    mark = "!!__viserMutable.nodeRefFromName['/other_grip/point']?.visible"
    until(mine, lambda: mine.evaluate(mark), "the mark at the host's")
    screenshot(mine, "two-host")
    screenshot(theirs, "two-guest")
    assert np.allclose(theirs.evaluate(CAMERA), view, atol=1e-6), "the view must not move under the mouse"
    theirs.mouse.up()
    until(theirs, lambda: session.hand.other is None, "letting go")
