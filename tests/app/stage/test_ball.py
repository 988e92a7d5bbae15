"""The stage of the ball: pushed by its arrows, pulled across the view, nudged by keys."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from app.page.handles.gizmos import NUDGE
from app.session.session import Session
from controllers.kinematics import Array
from scenes.room import BALL_RADIUS, PATH, POINT_RADIUS
from scenes.targets import BallTarget
from tests.app.conftest import HAND, Guest
from tests.app.page.helpers import press
from tests.app.stage.conftest import BALL, GRIP, ball, change, comes, drag, drawn, drawn_pose, home, place, pull, settle


def test_the_path_is_drawn_from_a_to_b(one: Guest) -> None:
    change(one, scene="ball")
    way = np.array(one.visitor.mirror.nodes["/path/line"]["points"], float).reshape(2, 3)
    assert_allclose(way[1] - way[0], PATH, atol=1e-6)
    assert_allclose(way[0], one.ask(home), atol=1e-6)
    for name, end in (("A", way[0]), ("B", way[1])):
        assert one.visitor.mirror.nodes[f"/path/{name}"]["text"] == name
        assert np.linalg.norm(place(one, f"/path/{name}") - end) < 0.05
    one.run_on(4.0)
    one.visitor.wait_for(lambda v: v.mirror.nodes["/trace"].get("visible"))


@pytest.mark.parametrize("point", ["hand", "elbow", "arm"])
def test_the_control_point_hangs_on_the_arm(one: Guest, point: str) -> None:
    change(one, scene="ball", point=point)
    shown = [name for name in drawn(one.visitor) if name.endswith("control_point")]
    assert one.visitor.mirror.nodes["/ball"]["radius"] == BALL_RADIUS
    if point == "arm":
        assert shown == []
        return
    (name,) = shown
    node = one.visitor.mirror.nodes[name]
    assert node["radius"] == POINT_RADIUS and 0.0 < node["opacity"] < 1.0

    def measured(s: Session) -> tuple[Array, Array]:
        simulation = s.simulation
        simulation.kinematics.update(simulation.positions)
        near = simulation.detector.detect("single", 100.0)
        return simulation.positions.copy(), simulation.detector.witness_points(near.pair)[0].copy()

    press(one, "pause")
    settle(one)
    q, closest = one.ask(measured)
    # Along the nested nodes it comes out where the detector has it: a radius from the closest point.
    middle = drawn_pose(one, name).translation
    assert np.linalg.norm(closest - middle) == pytest.approx(POINT_RADIUS, abs=2e-3)
    toward = (q[-3:] - middle) / np.linalg.norm(q[-3:] - middle)
    assert_allclose(closest, middle + POINT_RADIUS * toward, atol=2e-3)


def test_the_ball_is_pushed_by_its_arrows_and_leaves_the_autopilot(one: Guest) -> None:
    change(one, scene="ball", ball="cross", autopilot=True)
    one.run_on(0.5)
    assert one.session.settings.page.autopilot
    visitor = one.visitor
    goal = one.ask(ball) + np.array([0.1, -0.05, 0.0])
    drag(one, BALL, goal)
    one.wait(lambda s: isinstance(s.held, BallTarget) and not s.settings.page.autopilot)
    comes(one, lambda s: float(np.linalg.norm(ball(s) - goal)), 2e-3)
    visitor.wait_for(lambda _: np.linalg.norm(place(one, "/ball") - goal) < 3e-3)
    visitor.move_gizmo(BALL, phase="end")
    one.wait(lambda s: s.held is None)
    one.run_on(0.3)
    rest = one.ask(ball)
    visitor.wait_for(lambda _: all(np.allclose(place(one, node), rest, atol=1e-4) for node in ("/ball", BALL, GRIP)))


def test_the_ball_itself_is_pulled_across_the_view(one: Guest) -> None:
    change(one, scene="ball")
    middle = one.ask(ball)
    taken = middle + np.array([BALL_RADIUS, 0.0, 0.0])
    way = np.array([0.0, 0.12, -0.03])
    pull(one, GRIP, "start", taken, taken)
    one.wait(lambda s: isinstance(s.held, BallTarget))
    # Taken at its surface, it does not jump.
    assert np.linalg.norm(one.session.held.position - middle) < 1e-6  # type: ignore[union-attr]
    pull(one, GRIP, "update", taken, taken + way)
    comes(one, lambda s: float(np.linalg.norm(ball(s) - middle - way)), 2e-3)
    # Odd places are not followed, far ones end at the edge of the room.
    pull(one, GRIP, "update", taken, np.array([1e7, 0.0, 0.0]))
    one.run_on(0.1)
    assert np.abs(one.session.held.position).max() <= 2.6  # type: ignore[union-attr]
    pull(one, GRIP, "end", taken, taken + way)
    one.wait(lambda s: s.held is None)


def test_keys_nudge_the_ball(one: Guest) -> None:
    change(one, scene="ball")
    start = one.ask(ball)
    press(one, "up")
    press(one, "up")
    held = one.session.held
    assert isinstance(held, BallTarget)
    assert_allclose(held.position - start, (0.0, 0.0, 2.0 * NUDGE), atol=2e-3)
    comes(one, lambda s: float(np.linalg.norm(ball(s) - held.position)), 2e-3)


def test_another_scene_in_mid_drag_lets_go(one: Guest) -> None:
    change(one, scene="ball")
    drag(one, BALL, np.array([0.3, 0.0, 1.0]))
    one.wait(lambda s: s.held is not None)
    change(one, scene="hold")
    assert one.session.held is None
    one.visitor.wait_for(lambda v: BALL not in v.mirror.nodes and HAND in v.mirror.nodes)
    one.run_on(0.1)
    assert one.session.held is None
