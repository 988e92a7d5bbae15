"""First view of every scene and rig at several window sizes: no cut text, free arms, visible ring."""

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
    """Share of 24 points on the ring with its colour; the hand and the handles may hide some."""
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


def nodes_of(session: Session, scene: str) -> list[str]:
    """Nodes that must be visible in an experiment: every link, the ball, the figure's forearm."""
    arms = ask(
        session, lambda s: [(arm.name, arm.joints.stop - arm.joints.start) for arm in s.simulation.room.arms]
    )
    chains = [[f"/arms/{name}/base", *(f"j{i}" for i in range(1, count + 1))] for name, count in arms]
    nodes = ["/".join(chain[: n + 1]) for chain in chains for n in range(len(chain))]
    return nodes + {"ball": ["/ball"], "imitation": [FOREARM]}.get(scene, [])


def see_way_of_ball(page: Page, session: Session) -> None:
    keeper = ask(session, lambda s: s.simulation.keeper)
    assert keeper is not None
    for end in (keeper.home, keeper.home + PATH):
        until(
            page, lambda end=end: page.evaluate(SEEN, world_to_px(page, end)), "the ball's way in free sight"
        )


def pause_on_the_way(page: Page, session: Session, scene: str) -> None:
    """Pause at a characteristic moment of the run."""
    moment = 3.0 if scene == "hold" else session.simulation.time + 1.5
    ask(session, lambda s: s.control.hurry(moment))
    until(page, lambda: session.simulation.time > moment, "a moment on the way")
    if scene == "hold":
        # The numbers are longest while the hand retreats from the other arm.
        until(page, lambda: session.simulation.sample().law_approach < -0.02, "a retreat")
    ask(session, lambda s: s.control.toggle_pause())
    page.get_by_text("paused", exact=True).wait_for()
    wait_frames(page, 6)


# Each pair in the large window and in a small one, with narrow and with wide letters.
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("width", "height", "font", "sights"),
    [
        (1440, 900, "narrow", SIGHTS),
        (1024, 768, "wide", SIGHTS[1::2]),
        (390, 844, "wide", SIGHTS[::2]),
    ],
)
def test_nothing_covers_the_arms_in_the_first_view_of_a_scene(
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
        nodes = nodes_of(session, scene)
        see_free(page, nodes, f"{scene}, {rig}")
        if scene == "ball":
            see_way_of_ball(page, session)
        pause_on_the_way(page, session, scene)
        screenshot(page, f"page-{width}-{scene}-{rig}")
        assert lasting(page, lambda: flaws(page)) == [], (scene, rig)
        see_free(page, nodes, f"{scene}, {rig}, on the way")
        ask(session, lambda s: s.control.toggle_pause())


@pytest.mark.thorough
def test_the_ring_is_visible_in_every_look(house: OpenHouse, page_at: PageAt) -> None:
    """While the arms are at rest."""
    assert RADIUS >= 0.06, "a robot's wrist would hide the ring"
    page = page_at(1024, 768, expect=(LATE_UPDATE,))
    session = visit(page, house(), "autopilot=0")
    close_software_note(page)
    page.get_by_text("anywhere").wait_for()
    for look in ("light desk fast", "dark projector fast", "light desk fine"):
        choice = dict(zip(("theme", "profile", "picture"), look.split(), strict=True))
        ask(session, lambda s, choice=choice: [s.change(key, value) for key, value in choice.items()])
        error = PALETTES[session.settings.page.theme].error
        until(page, lambda error=error: ring_share(page, session, error) > 0.5, f"the ring, {look}", 180.0)
        screenshot(page, f"ring-{look.replace(' ', '-')}")
