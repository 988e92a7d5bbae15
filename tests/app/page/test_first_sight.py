"""The first sight of every scene and rig, in windows of several sizes: nothing is cut off and nothing covers the arms; the ring is seen."""

import colorsys
import io

import numpy as np
import pinocchio as pin
import pytest
from PIL import Image
from playwright.sync_api import Page

from app.session.session import Session
from app.stage.hand_marks import RADIUS
from app.theme import PALETTES, rgb
from scenes.ball import PATH
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import LATE_UPDATE, see_free, see_plots, visit
from tests.browser import (
    PageAt,
    close_software_note,
    drawn,
    lasting,
    screenshot,
    until,
    wait_frames,
    world_to_px,
)
from tests.fonts import Font
from tests.tools.page_flaws import flaws

SEEN = "p => document.elementFromPoint(...p) === __viserMutable.canvas"
FOREARM = "/person/body/left_upper_arm/left_forearm"
SIGHTS = (
    ("hold", "torso"),
    ("hold", "table"),
    *((scene, "torso") for scene in ("solo", "ball", "master_slave", "imitation")),
)


def ring_share(page: Page, session: Session, colour: str) -> float:
    """The share of 24 points all along the ring at which its colour is seen; the hand and the handles may hide some."""
    keeper = ask(session, lambda s: s.simulation.keeper)
    assert keeper is not None
    place, rotation = keeper.place, keeper.place_rotation
    with drawn(page):
        picture = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), float) / 255.0
    wanted = colorsys.rgb_to_hsv(*(c / 255.0 for c in rgb(colour)))[0]
    seen = 0
    for angle in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
        point = pin.SE3(rotation, place).act(RADIUS * np.array([np.cos(angle), np.sin(angle), 0.0]))
        x, y = (round(value) for value in world_to_px(page, point))
        spot = picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
        hues = [colorsys.rgb_to_hsv(*pixel) for pixel in spot]
        seen += any(abs((h - wanted + 0.5) % 1.0 - 0.5) < 0.05 and s > 0.15 for h, s, _ in hues)
    return seen / 24.0


def see_ring(page: Page, session: Session) -> None:
    """See the ring in every look, while the arms stand still."""
    assert RADIUS >= 0.06, "a wrist of our robots would hide it"
    usual = {"scene": "hold", "rig": "torso", "autopilot": False}
    ask(session, lambda s: [*(s.change(key, value) for key, value in usual.items()), s.reset()])
    page.get_by_text("anywhere").wait_for()
    for look in ("light desk fast", "dark projector fast", "light desk fine"):
        choice = dict(zip(("theme", "profile", "picture"), look.split(), strict=True))
        ask(session, lambda s, choice=choice: [s.change(key, value) for key, value in choice.items()])
        error = PALETTES[session.settings.page.theme].error
        until(page, lambda error=error: ring_share(page, session, error) > 0.5, f"the ring, {look}", 180.0)
        screenshot(page, f"ring-{look.replace(' ', '-')}")


# Every sight in a large window and in one of the small ones, with letters of either width there.
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("width", "height", "font", "sights"),
    [
        (1440, 900, "narrow", SIGHTS),
        (1024, 768, "wide", SIGHTS[1::2]),
        (390, 844, "wide", SIGHTS[::2]),
    ],
)
def test_first_sight_of_every_scene_and_rig_and_of_the_ring(
    house: OpenHouse,
    page_at: PageAt,
    width: int,
    height: int,
    font: Font,
    sights: tuple[tuple[str, str], ...],
) -> None:
    page = page_at(width, height, expect=(LATE_UPDATE,), font=font)
    session = visit(page, house(), f"rig={'table' if width == 1024 else 'torso'}&speed=2")
    if width > 576:
        see_plots(page, ("distance", "error"))
    close_software_note(page)
    for scene, rig in sights:
        ask(session, lambda s, scene=scene, rig=rig: [s.change("scene", scene), s.change("rig", rig)])
        joints = ask(
            session,
            lambda s: [(arm.name, arm.joints.stop - arm.joints.start) for arm in s.simulation.room.arms],
        )
        chains = [[f"/arms/{name}/base", *(f"j{i}" for i in range(1, count + 1))] for name, count in joints]
        nodes = ["/".join(chain[: n + 1]) for chain in chains for n in range(len(chain))]
        nodes += {"ball": ["/ball"], "imitation": [FOREARM]}.get(scene, [])
        see_free(page, nodes, f"{scene}, {rig}")
        if scene == "ball":
            keeper = ask(session, lambda s: s.simulation.keeper)
            assert keeper is not None
            for end in (keeper.home, keeper.home + PATH):
                until(
                    page,
                    lambda end=end: page.evaluate(SEEN, world_to_px(page, end)),
                    "the ball's way in free sight",
                )
        # Somewhere on the way, so that the picture shows what happens.
        moment = 3.0 if scene == "hold" else session.simulation.time + 1.5
        ask(session, lambda s, moment=moment: s.control.hurry(moment))
        until(page, lambda moment=moment: session.simulation.time > moment, "a moment on the way")
        if scene == "hold":
            # On its way back the hand moves away from the other arm: the numbers are longest then.
            until(page, lambda: session.simulation.sample().law_approach < -0.02, "a retreat")
        ask(session, lambda s: s.control.toggle_pause())
        page.get_by_text("paused", exact=True).wait_for()
        wait_frames(page, 6)
        screenshot(page, f"page-{width}-{scene}-{rig}")
        assert lasting(page, lambda: flaws(page)) == [], (scene, rig)
        see_free(page, nodes, f"{scene}, {rig}, on the way")
        ask(session, lambda s: s.control.toggle_pause())
    if width == 1024:
        see_ring(page, session)
