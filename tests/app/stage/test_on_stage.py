"""Objects of the 3-D view are drawn at their places and can be dragged."""

import math
from typing import get_args

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from viser import SceneApi

from app.page.handles.transform_handles import swivel_frame, wanted_pose
from app.session.session import Session
from app.stage.arms import SHAPE, ArmView
from app.stage.person_figure import SCALE, on_person, on_stage
from controllers.kinematics import Array
from scenes import solo
from scenes.ball import BALL_RADIUS, PATH, POINT_RADIUS
from scenes.person.angles import FOREARM, arm_points
from scenes.person.figure import Figure
from scenes.robots import RobotName, robot
from scenes.settings import ArmName
from scenes.targets import AnglesTarget, BallTarget, HandTarget, LinkTarget
from tests.app.conftest import ELBOW, HAND, Arrive, Guest, OpenHouse
from tests.app.page.helpers import press
from tests.app.stage.conftest import (
    ball,
    change,
    comes,
    drag,
    drawn,
    drawn_pose,
    hand,
    home,
    place,
    pull,
    settle,
    visible,
)


def test_the_single_arms_hand_follows_its_handle(one: Guest) -> None:
    change(one, scene="solo")
    visitor, start = one.visitor, one.ask(hand)
    # A position task has no rotation handles.
    visitor.wait_for(
        lambda v: np.abs(place(one, HAND) - start).max() < 2e-3 and v.mirror.nodes[HAND]["disable_rotations"]
    )
    goal = start + np.array([0.05, 0.08, 0.04])
    drag(one, HAND, goal)
    one.wait(lambda s: isinstance(s.held, HandTarget) and s.held.rotation is None)
    comes(one, lambda s: float(np.linalg.norm(hand(s) - goal)), 5e-3)
    visitor.move_gizmo(HAND, phase="end")
    one.wait(lambda s: s.held is None)
    # After the release, place, hand and handle stay there.
    one.run_on(1.0)
    assert np.linalg.norm(one.ask(hand) - goal) < 5e-3
    wanted = one.ask(lambda s: wanted_pose(s.hand)[0])
    visitor.wait_for(lambda _: np.allclose(place(one, "/place/ring"), wanted, atol=1e-4))
    assert np.linalg.norm(place(one, "/place/ring") - goal) < 1e-3
    change(one, task="pose")
    visitor.wait_for(lambda v: not v.mirror.nodes[HAND]["disable_rotations"])


def test_the_elbow_of_the_single_arm_moves_in_the_null_space(one: Guest) -> None:
    change(one, scene="solo", speed=2.0)

    def state(s: Session) -> tuple[Array, Array, Array, Array]:
        frame, foot = swivel_frame(s.hand)
        return s.simulation.kinematics.joint_point(s.simulation.guided.elbow).copy(), hand(s), frame, foot

    for made, task, left in (
        ("lwr", "position", 0.1),
        ("lwr", "pose", 0.1),
        ("panda", "pose", 0.1),
        ("ur5", "position", 0.75),
    ):
        change(one, robot=made, task=task)
        press(one, "reset")
        # Another robot gets new handles; a drag of an old handle ends.
        settle(one)
        elbow, start, frame, foot = one.ask(state)
        q = pin.Quaternion(frame @ pin.rpy.rpyToMatrix(0.3, 0.0, 0.0))
        drag(one, ELBOW, elbow, (q.w, q.x, q.y, q.z))
        goal = foot + pin.exp3(frame[:, 0] * 0.3) @ (elbow - foot)
        before = float(np.linalg.norm(goal - elbow))
        comes(one, lambda s, goal=goal: float(np.linalg.norm(state(s)[0] - goal)), left * before)
        assert np.linalg.norm(one.ask(hand) - start) < 2e-3, made
        one.visitor.move_gizmo(ELBOW, phase="end")
        one.wait(lambda s: s.held is None)


def test_the_circle_is_drawn_and_the_hand_cannot_be_held(one: Guest) -> None:
    change(one, scene="solo", path="circle", speed=2.0)
    nodes = one.visitor.mirror.nodes
    # Each node is a separate message: the line may arrive before the last handle is removed.
    one.visitor.wait_for(
        lambda v: "/path/line" in v.mirror.nodes and not {HAND, ELBOW, "/path/A"} & v.mirror.nodes.keys()
    )
    points = np.array(nodes["/path/line"]["points"], float).reshape(-1, 3)
    home = points[0]
    centre = home + np.array([0.0, 0.0, solo.RADIUS])
    assert_allclose(np.linalg.norm(points - centre, axis=1), solo.RADIUS, atol=1e-5)
    press_left = one.ask(lambda s: s.settings.page.autopilot)
    press(one, "left")
    assert one.session.held is None and one.session.settings.page.autopilot == press_left
    one.run_on(2.0)
    one.visitor.wait_for(lambda v: v.mirror.nodes["/trace"].get("visible"))
    # The trace shows the hand's path, near the circle.
    trace = np.array(nodes["/trace"]["points"], float).reshape(-1, 3)
    assert np.abs(np.linalg.norm(trace - centre, axis=1) - solo.RADIUS).max() < 0.01
    change(one, path="stay")
    one.visitor.wait_for(lambda v: "/path/line" not in v.mirror.nodes and HAND in v.mirror.nodes)


def test_the_master_is_dragged_and_the_slaves_wanted_posture_is_shown(one: Guest) -> None:
    change(one, scene="master_slave", avoid="free", speed=2.0)
    one.visitor.wait_for(
        lambda _: not any(visible(one, name) for name in drawn(one.visitor) if name.startswith("/wish"))
    )
    start = one.ask(hand)
    other = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.avoiding).translation.copy())
    goal = start + 0.7 * (other - start)
    drag(one, HAND, goal, one.visitor.mirror.nodes[HAND]["wxyz"])
    comes(one, lambda s: float(np.linalg.norm(hand(s) - goal)), 0.05)
    # Mirroring would lead the slave into the master: it avoids, and its wanted posture is drawn as well.
    one.visitor.wait_for(lambda _: visible(one, "/wish/left/base"))
    assert "/wish/right/base" not in drawn(one.visitor)
    press(one, "pause")
    settle(one)
    desired = one.ask(lambda s: s.simulation.sample().desired[s.simulation.avoiding.joints].copy())
    node = "/wish/left/base"
    for i, angle in enumerate(desired):
        node += f"/j{i + 1}"
        actual = "/arms" + node[len("/wish") :]
        turned, real = (np.array(one.visitor.mirror.nodes[name]["wxyz"]) for name in (node, actual))
        q = one.ask(lambda s, i=i: float(s.simulation.positions[s.simulation.avoiding.joints][i]))
        between = 2.0 * math.acos(min(abs(float(turned @ real)), 1.0))
        assert between == pytest.approx(abs(angle - q), abs=1e-3)


def test_a_ghost_is_visible_where_it_differs_and_removed_when_off(one: Guest) -> None:
    press(one, "ghost")
    assert one.session.settings.page.ghost == "frozen" and one.session.ghost is not None
    one.run_on(0.2)
    assert not any(name.startswith("/ghost") for name in drawn(one.visitor))
    change(one, law="unprotected", speed=2.0, autopilot=True)
    one.visitor.wait_for(lambda _: visible(one, "/ghost/left/base"))
    assert "/ghost/right/base" not in drawn(one.visitor)
    press(one, "ghost")
    assert one.session.settings.page.ghost == "off"
    one.visitor.wait_for(lambda v: not any(name.startswith("/ghost") for name in drawn(one.visitor)))


def test_the_path_is_drawn_from_a_to_b(one: Guest) -> None:
    change(one, scene="ball")
    start = one.ask(home)
    # The letters are slightly beyond its ends.
    beyond = 0.07 * PATH / np.linalg.norm(PATH)
    for name, end in (("A", start - beyond), ("B", start + PATH + beyond)):
        one.visitor.wait_for(lambda v, name=name: v.mirror.nodes.get(f"/path/{name}", {}).get("text") == name)
        one.visitor.wait_for(
            lambda _, name=name, end=end: np.linalg.norm(place(one, f"/path/{name}") - end) < 1e-3
        )
    way = np.array(one.visitor.mirror.nodes["/path/line"]["points"], float).reshape(2, 3)
    assert_allclose(way, [start, start + PATH], atol=1e-6)
    one.visitor.wait_for(lambda v: v.mirror.nodes["/trace"].get("visible"))


def test_the_control_point_is_attached_to_the_arm(one: Guest) -> None:
    change(one, scene="ball", point="arm")
    press(one, "pause")
    one.visitor.wait_for(lambda v: "/ball" in v.mirror.nodes)
    assert one.visitor.mirror.nodes["/ball"]["radius"] == BALL_RADIUS

    def points() -> list[str]:
        return [name for name in drawn(one.visitor) if name.endswith("control_point")]

    def measured(s: Session) -> tuple[Array, Array]:
        simulation = s.simulation
        simulation.kinematics.update(simulation.positions)
        near = simulation.detector.detect("single", 100.0)
        return simulation.positions.copy(), simulation.detector.witness_points(near.pair)[0].copy()

    for part in ("hand", "elbow"):
        change(one, point=part)
        one.visitor.wait_for(lambda _: len(points()) == 1)
        settle(one)
        (name,) = points()
        node = one.visitor.mirror.nodes[name]
        assert node["radius"] == POINT_RADIUS and 0.0 < node["opacity"] < 1.0
        q, closest = one.ask(measured)
        # The nested nodes give the detector's place: one radius from the closest point.
        middle = drawn_pose(one, name).translation
        assert np.linalg.norm(closest - middle) == pytest.approx(POINT_RADIUS, abs=2e-3), part
        toward = (q[-3:] - middle) / np.linalg.norm(q[-3:] - middle)
        assert_allclose(closest, middle + POINT_RADIUS * toward, atol=2e-3)
    change(one, point="arm")
    one.visitor.wait_for(lambda _: points() == [])


def test_the_ball_itself_is_dragged_across_the_view(one: Guest) -> None:
    change(one, scene="ball")
    middle = one.ask(ball)
    taken = middle + np.array([BALL_RADIUS, 0.0, 0.0])
    way = np.array([0.0, 0.12, -0.03])
    pull(one, "/ball", "start", taken, taken)
    one.wait(lambda s: isinstance(s.held, BallTarget))
    # Held at its surface, the ball does not jump.
    assert np.linalg.norm(one.session.held.position - middle) < 1e-6  # type: ignore[union-attr]
    pull(one, "/ball", "update", taken, taken + way)
    comes(one, lambda s: float(np.linalg.norm(ball(s) - middle - way)), 2e-3)
    # Bad places are ignored; far ones are limited to the edge of the room.
    pull(one, "/ball", "update", taken, np.array([1e7, 0.0, 0.0]))
    one.run_on(0.1)
    assert np.abs(one.session.held.position).max() <= 2.6  # type: ignore[union-attr]
    pull(one, "/ball", "end", taken, taken + way)
    one.wait(lambda s: s.held is None)


def test_the_figure_is_drawn_at_its_arms() -> None:
    point = np.array([0.2, -0.3, 0.1])
    assert_allclose(on_person(on_stage(point)), point, atol=1e-12)
    ends = [on_stage(p) for p in arm_points(Figure().angles()[0], "left")]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(SCALE * 0.276, abs=1e-3)


def drawn_wrist(guest: Guest, side: ArmName) -> Array:
    forearm = drawn_pose(guest, f"/person/body/{side}_upper_arm/{side}_forearm")
    return forearm.act(np.array([0.0, 0.0, -SCALE * FOREARM]))


def test_a_clip_moves_the_figure_and_the_robots(one: Guest) -> None:
    change(one, scene="imitation", clip="wave", autopilot=True)
    one.run_on(1.5)
    press(one, "pause")
    settle(one)
    wish = one.ask(lambda s: s.target())
    assert isinstance(wish, AnglesTarget) and wish.angles is not None
    for i, side in enumerate(get_args(ArmName)):
        _, _, wrist = arm_points(wish.angles[i], side)
        one.visitor.wait_for(
            lambda _, side=side, wrist=wrist: np.allclose(drawn_wrist(one, side), on_stage(wrist), atol=2e-3)
        )
    assert not visible(one, "/person/lost")
    # The autopilot plays the person: without it no person is visible.
    press(one, "autopilot")
    one.visitor.wait_for(lambda _: visible(one, "/person/lost"))


def test_the_figure_is_dragged_and_the_robots_follow(one: Guest) -> None:
    """Taking hold of the figure makes it the person, also after a clip."""
    change(one, scene="imitation", clip="wave", autopilot=True)
    one.run_on(0.5)
    one.ask(lambda s: s.change("autopilot", False))
    press(one, "pause")
    settle(one)
    press(one, "pause")
    forearm = "/person/body/left_upper_arm/left_forearm"
    one.visitor.wait_for(lambda v: forearm in v.mirror.grabbable and "/person/body" not in v.mirror.grabbable)
    start = drawn_wrist(one, "left")
    q = one.ask(lambda s: s.simulation.positions.copy())
    goal = start + np.array([0.10, 0.05, 0.15])
    pull(one, forearm, "start", start, start)
    one.wait(lambda s: s.settings.page.source == "figure" and s.settings.page.autopilot)
    first = drawn_wrist(one, "left")
    pull(one, forearm, "update", start, goal)
    one.visitor.wait_for(lambda _: np.linalg.norm(drawn_wrist(one, "left") - goal) < 5e-3)
    pull(one, forearm, "end", start, goal)
    one.run_on(2.0)
    moved = np.abs(one.ask(lambda s: s.simulation.positions.copy()) - q)
    left = one.session.simulation.room.arm("left").joints
    assert moved[left].max() > 0.2
    # The figure keeps its posture; a reset restores the first one; another source takes over.
    assert np.linalg.norm(drawn_wrist(one, "left") - goal) < 5e-3
    press(one, "reset")
    one.visitor.wait_for(lambda _: np.linalg.norm(drawn_wrist(one, "left") - first) < 5e-3)
    change(one, source="clips")
    one.run_on(1.0)
    wish = one.ask(lambda s: s.target())
    assert wish is None or isinstance(wish, AnglesTarget)


BASE = pin.SE3(pin.exp3(np.array([0.4, -0.9, 0.3])), np.array([0.1, -0.2, 0.9]))


def test_nodes_are_at_the_links_and_a_resting_joint_is_not_sent(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    guest = arrive(opened, "autopilot=0")
    guest.ask(lambda s: s.control.toggle_pause())
    for name in get_args(RobotName):
        arm_moves(guest, opened.server.scene, name)


def arm_moves(guest: Guest, scene: SceneApi, name: RobotName) -> None:
    """Check a new arm in five postures and with one joint moved in each, and its removal."""
    visitor, model, is_default = guest.visitor, robot(name).model, name == "lwr"
    arm = (
        ArmView(scene, "/arm", BASE, "ghost", False)
        if is_default
        else ArmView(scene, "/arm", BASE, "orange", False, name)
    )
    paths = [
        "/arm/base" + "".join(f"/{joint}" for joint in list(model.names)[1 : n + 1])
        for n in range(model.njoints)
    ]
    assert paths == [arm.link(joint) for joint in range(model.njoints)]
    shapes = [f"{path}/{SHAPE}" for path in paths]
    visitor.wait_for(lambda v: set(paths) | set(shapes) <= set(v.mirror.nodes))
    # A node below a mesh waits until that is loaded: only frames have children.
    assert {visitor.mirror.nodes[path]["type"] for path in paths} == {"FrameMessage"}
    assert not [
        node for node in visitor.mirror.nodes if node.startswith(tuple(f"{shape}/" for shape in shapes))
    ]
    # A ghost casts no shadow.
    assert all(visitor.mirror.nodes[shape]["cast_shadow"] is not is_default for shape in shapes)
    assert all(visitor.mirror.nodes[shape]["receive_shadow"] is not is_default for shape in shapes)
    data = model.createData()

    def stands() -> bool:
        drawn = [drawn_pose(guest, path).homogeneous for path in paths]
        return np.allclose(drawn, [(BASE * pose).homogeneous for pose in data.oMi], atol=1e-6)

    for q in np.random.default_rng(2).uniform(
        model.lowerPositionLimit, model.upperPositionLimit, (5, model.nq)
    ):
        for shift in (0.0, 0.01):
            q[2] += shift
            before = visitor.received.messages["SetOrientationMessage"]
            arm.show(q.copy())
            pin.forwardKinematics(model, data, q)
            visitor.wait_for(lambda _: stands())
        assert visitor.received.messages["SetOrientationMessage"] == before + 1
    arm.root.visible = False
    visitor.wait_for(lambda v: not v.mirror.nodes["/arm/base"].get("visible", True))
    arm.remove()
    visitor.wait_for(lambda v: not [node for node in v.mirror.nodes if node.startswith("/arm/")])


LINK = "/arms/{}/base" + "".join(f"/j{i}" for i in range(1, 6))
OFFSET = np.array([0.0, 0.05, 0.08])


@pytest.fixture
def guest(house: OpenHouse, arrive: Arrive) -> Guest:
    """A guest with arms at rest, without arrows."""
    return arrive(house(), "autopilot=0")


def point(s: Session) -> Array:
    """Place of the dragged point on the fifth link."""
    return s.simulation.kinematics.data.oMi[s.simulation.guided.joint(5)].act(OFFSET)


@pytest.mark.parametrize("scene", ["hold", "master_slave", "solo"])
def test_a_link_is_dragged(guest: Guest, scene: str) -> None:
    change(guest, scene=scene, speed=2.0)
    arm, link = ("arm" if scene == "solo" else "right"), LINK.format("arm" if scene == "solo" else "right")
    # Only the orange arm without its base can be dragged; no arrows, and no mark before a drag.
    links = {f"/arms/{arm}/base" + "".join(f"/j{i}" for i in range(1, joint + 1)) for joint in range(1, 8)}
    guest.visitor.wait_for(lambda v: set(v.mirror.grabbable) == links)
    assert not any(name.startswith("/gizmo") for name in drawn(guest.visitor))
    assert not visible(guest, "/grip/point")
    start = guest.ask(point)
    frame, _ = guest.ask(lambda s: swivel_frame(s.hand))
    # The elbow's swivel direction, which every hand task permits.
    goal = start + 0.05 * (frame[:, 2] - frame[:, 1]) / np.sqrt(2.0)
    pull(guest, link, "start", start, start)
    guest.wait(lambda s: isinstance(s.held, LinkTarget))
    held = guest.session.held
    assert isinstance(held, LinkTarget) and held.joint == 5
    assert np.allclose(held.offset, OFFSET, atol=1e-3)
    pull(guest, link, "update", start, goal)
    comes(guest, lambda s: float(np.linalg.norm(point(s) - goal)), 0.015)
    guest.visitor.wait_for(lambda _: visible(guest, "/grip/point") and visible(guest, "/grip/line"))
    guest.visitor.wait_for(lambda _: np.linalg.norm(place(guest, "/grip/point") - guest.ask(point)) < 2e-3)
    guest.visitor.wait_for(lambda _: np.allclose(place(guest, "/grip/place"), goal))
    # The end of another link's drag is ignored; its own end releases it, and the arm stays.
    pull(guest, link.removesuffix("/j5"), "end", start, goal)
    guest.run_on(0.1)
    assert guest.session.held is not None
    pull(guest, link, "end", start, goal)
    guest.wait(lambda s: s.held is None)
    guest.visitor.wait_for(lambda _: not visible(guest, "/grip/point"))
    there = guest.ask(point)
    guest.run_on(1.0)
    assert np.linalg.norm(guest.ask(point) - there) < (0.05 if scene == "solo" else 0.01)
    # The arrow keys continue from there.
    press(guest, "up")
    guest.wait(lambda s: isinstance(s.held, HandTarget))


def test_bad_drags_are_ignored_and_a_change_releases_the_link(guest: Guest) -> None:
    link, far = LINK.format("right"), np.array([1e7, 0.0, 0.0])
    # An update without a start, and a start at an invalid place.
    pull(guest, link, "update", np.zeros(3), np.ones(3))
    pull(guest, link, "start", np.array([np.nan, 0.0, 0.0]), np.ones(3))
    guest.run_on(0.1)
    assert guest.session.held is None
    start = guest.ask(point)
    pull(guest, link, "start", start, start)
    pull(guest, link, "update", start, far)
    guest.wait(lambda s: isinstance(s.held, LinkTarget) and not np.allclose(s.held.position, start, atol=0.1))
    guest.run_on(1.0)
    held = guest.session.held
    assert isinstance(held, LinkTarget) and np.abs(held.position).max() <= 2.6
    assert np.isfinite(guest.ask(lambda s: s.simulation.positions.copy())).all()
    press(guest, "reset")
    assert guest.session.held is None
    pull(guest, link, "start", start, start)
    guest.wait(lambda s: s.held is not None)
    change(guest, guided="left")
    guest.visitor.wait_for(
        lambda v: v.mirror.grabbable and all(n.startswith("/arms/left/") for n in v.mirror.grabbable)
    )
    assert guest.session.held is None


def test_a_drag_is_replayed_and_a_replayed_arm_cannot_be_held(guest: Guest) -> None:
    link, start = LINK.format("right"), guest.ask(point)
    goal = start + np.array([0.0, 0.06, 0.08])
    pull(guest, link, "start", start, start)
    pull(guest, link, "update", start, goal)
    comes(guest, lambda s: float(np.linalg.norm(point(s) - goal)), 0.01)
    pull(guest, link, "end", start, goal)
    guest.wait(lambda s: s.held is None)
    guest.visitor.set_value("replay", "Watch")
    guest.wait(lambda s: s.player.past is not None)
    guest.visitor.wait_for(lambda v: not v.mirror.grabbable)
    guest.visitor.wait_for(lambda _: visible(guest, "/grip/point"))
    # The replay begins at the drag's start.
    guest.visitor.wait_for(lambda _: np.allclose(place(guest, "/grip/place"), goal))
