"""The stage of imitation: a figure moves, is pulled, and the robots follow."""

from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_allclose

from app.stage.person_figure import SCALE, on_person, on_stage
from controllers.kinematics import Array
from scenes.person.angles import arm_points
from scenes.person.figure import Figure
from scenes.settings import ArmName
from scenes.targets import AnglesTarget
from tests.app.conftest import Guest
from tests.app.page.helpers import press
from tests.app.stage.conftest import change, drawn_pose, place, pull, settle, visible


def test_the_figure_stands_where_its_arms_are() -> None:
    point = np.array([0.2, -0.3, 0.1])
    assert_allclose(on_person(on_stage(point)), point, atol=1e-12)
    ends = [on_stage(p) for p in arm_points(Figure().angles()[0], "left")]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(SCALE * 0.276, abs=1e-3)


def drawn_wrist(guest: Guest, side: ArmName) -> Array:
    forearm = drawn_pose(guest, f"/person/body/{side}_upper_arm/{side}_forearm")
    return forearm.act(np.array([0.0, 0.0, -SCALE * Figure().proportions.forearm]))


def test_a_clip_moves_the_figure_and_the_robots(one: Guest) -> None:
    change(one, scene="imitation", clip="wave", autopilot=True)
    one.run_on(1.5)
    press(one, "pause")
    settle(one)
    wish = one.ask(lambda s: s.target())
    assert isinstance(wish, AnglesTarget) and wish.angles is not None
    for i, side in enumerate(get_args(ArmName)):
        _, _, wrist = arm_points(wish.angles[i], side)
        one.visitor.wait_for(lambda _, side=side, wrist=wrist: np.allclose(drawn_wrist(one, side), on_stage(wrist), atol=2e-3))
    assert not visible(one, "/person/lost")
    # The autopilot is that person: without it no person is seen.
    press(one, "autopilot")
    one.visitor.wait_for(lambda _: visible(one, "/person/lost"))


def test_the_figure_is_pulled_and_the_robots_follow(one: Guest) -> None:
    change(one, scene="imitation", source="figure")
    knob = "/gizmo/left_wrist"
    one.visitor.wait_for(lambda v: knob in v.mirror.nodes)
    start = place(one, knob)
    assert_allclose(drawn_wrist(one, "left"), start, atol=2e-3)
    q = one.ask(lambda s: s.simulation.positions.copy())
    goal = start + np.array([0.10, 0.05, 0.15])
    pull(one, knob, "start", start, start)
    pull(one, knob, "update", start, goal)
    one.visitor.wait_for(lambda _: np.linalg.norm(place(one, knob) - goal) < 5e-3)
    one.visitor.wait_for(lambda _: np.linalg.norm(drawn_wrist(one, "left") - goal) < 5e-3)
    pull(one, knob, "end", start, goal)
    one.run_on(2.0)
    moved = np.abs(one.ask(lambda s: s.simulation.positions.copy()) - q)
    left, right = (one.session.simulation.room.arm(side).joints for side in get_args(ArmName))
    assert moved[left].max() > 0.2 and moved[right].max() < 0.02
    # It stays as it was pulled; a reset lets it stand as at the start; another source has no handles.
    assert np.linalg.norm(place(one, knob) - goal) < 5e-3
    press(one, "reset")
    one.visitor.wait_for(lambda _: np.linalg.norm(place(one, knob) - start) < 5e-3)
    change(one, source="clips")
    assert knob not in one.visitor.mirror.nodes
    one.run_on(1.0)
    wish = one.ask(lambda s: s.target())
    assert wish is None or isinstance(wish, AnglesTarget)
