"""The stage of the ball: pushed by its arrows, pulled across the view, nudged by keys."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from app.session.session import Session
from controllers.kinematics import Array
from scenes.room import BALL_RADIUS, PATH, POINT_RADIUS
from scenes.targets import BallTarget
from tests.app.conftest import Guest
from tests.app.page.helpers import press
from tests.app.stage.conftest import GRIP, ball, change, comes, drawn, drawn_pose, home, place, pull, settle


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
