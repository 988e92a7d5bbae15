"""The thing that stops an arm is highlighted and named in the 3-D view."""

import numpy as np
import pytest

from app.stage.touch_view import WORDS
from scenes.settings import RigName
from scenes.simulation import Simulation
from scenes.surroundings import MARGIN
from scenes.targets import BallTarget, HandTarget, Target
from scenes.world_stages import Touch
from tests.app.conftest import Guest
from tests.app.stage.conftest import change, drawn, visible
from tests.scenes.helpers import given_settings


def touch_after(target: Target, scene: str = "hold", rig: RigName = "torso") -> tuple[Simulation, Touch]:
    simulation = Simulation(given_settings(scene=scene, rig=rig, world=True, wmax=0.5))
    for _ in range(900):
        simulation.step(target)
    simulation.kinematics.update(simulation.positions)
    assert simulation.stages is not None
    (touch,) = simulation.stages.touches()
    return simulation, touch


def test_the_point_is_on_the_table_below_the_hand() -> None:
    simulation, touch = touch_after(HandTarget(np.array([0.45, 0.1, 0.3])), rig="table")
    assert touch.thing == "table"
    assert touch.point[2] == pytest.approx(0.738, abs=0.005)
    hand = simulation.kinematics.hand_pose(simulation.guided).translation
    assert np.linalg.norm(hand - touch.point) < 0.05 + 2.0 * MARGIN + 0.15


def test_the_ball_touches_the_pedestal() -> None:
    simulation = Simulation(given_settings(scene="ball", world=True))
    base = simulation.room.rig.bases[0].translation
    _, touch = touch_after(BallTarget(base + np.array([0.0, 0.0, 0.15])), "ball")
    assert touch.thing == "pedestal" and np.hypot(*(touch.point - base)[:2]) < 0.13


def test_no_touch_at_the_start_and_no_highlight_without_the_setting() -> None:
    simulation = Simulation(given_settings(rig="table", world=True))
    simulation.world.update()
    assert simulation.stages is not None and simulation.stages.touches() == ()
    assert Simulation(given_settings(rig="table")).stages is None


def test_a_touched_thing_is_highlighted_and_named(one: Guest) -> None:
    change(one, rig="table", world=True, wmax=0.5)

    def drag(session: object) -> None:
        one.session.simulation.positions[:] = touch_after(
            HandTarget(np.array([0.45, 0.1, 0.3])), rig="table"
        )[0].positions
        one.session.simulation.world.update()

    assert not visible(one, "/touch/light0")
    one.ask(drag)
    change(one, theme="dark")
    assert visible(one, "/touch/light0") and "/touch/thing0" in drawn(one.visitor)
    assert set(WORDS) == {"table", "floor", "stand", "pedestal", "itself"}
