"""Scripted people and places of lessons: correct, reproducible, and refused if they do not fit the scene."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import Start
from app.features.lessons.reference_runs import measured, person_of
from app.features.lessons.runs import Input, Setup
from app.features.lessons.scripts import SCRIPTS, checked_script, script, to_and_fro
from app.features.measures.room_places import RoomPlace, ball_centre, mark_places, start_positions
from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.ball import BALL_RADIUS, PATH, POINT_RADIUS, build_ball_room
from scenes.experiments import EXPERIMENTS
from scenes.room import build_room
from scenes.simulation import Simulation
from scenes.solo import build_alone
from scenes.targets import BallTarget, HandTarget, JointTarget, WallTarget
from tests.approved import Approve
from tests.scenes.helpers import given_settings

PLACE = RoomPlace("goal", (0.0, 0.0, 1.0), 0.3)
MEANT: dict[str, dict[str, Any]] = {
    "push": {"speed": 0.2},
    "ball_to": {"place": PLACE},
    "ball_push": {"speed": 0.2},
    "wall_to": {"x": -0.3},
}


def fresh(scene: str, **changes: object) -> Simulation:
    return Simulation(given_settings(scene=scene, **changes), 2000)


def wishes(simulation: Simulation, name: str, times: list[float], **given: Any) -> list[Array]:
    person = script(name, checked_script(name, given, simulation.settings.scene), simulation)
    targets = [person.target(time) for time in times]
    return [target.position for target in targets if isinstance(target, (HandTarget, BallTarget, WallTarget))]


@pytest.mark.parametrize("name", SCRIPTS)
def test_every_script_is_smooth_reproducible_and_moves_something(name: str) -> None:
    for scene in filter(SCRIPTS[name].fits, EXPERIMENTS):
        given = MEANT.get(name, {})
        times = [0.01 * i for i in range(600)]
        paths = []
        for _ in range(2):
            simulation = fresh(scene)
            person = script(name, checked_script(name, given, scene), simulation)
            row = []
            for time in times:
                target = person.target(time)
                assert isinstance(target, (HandTarget, BallTarget, JointTarget, WallTarget))
                elbow = target.elbow if isinstance(target, HandTarget) else None
                place = target.positions if isinstance(target, JointTarget) else target.position
                row.append(place if elbow is None else elbow)
                simulation.step(target)
            paths.append(np.array(row))
        assert_array_equal(paths[0], paths[1])
        assert np.isfinite(paths[0]).all()
        assert np.linalg.norm(np.diff(paths[0], axis=0), axis=1).max() / 0.01 < 2.0
        if name != "hand_to":
            assert np.ptp(paths[0], axis=0).max() > 0.05


def test_a_push_is_a_straight_line_at_its_speed() -> None:
    simulation = fresh("hold", rig="table")
    start, early, one, two, far = wishes(simulation, "push", [0.0, 0.9, 2.0, 3.0, 6.0], speed=0.2)
    goal = simulation.kinematics.hand_pose(simulation.avoiding).translation
    assert_array_equal(start, early)
    assert np.linalg.norm(two - one) == pytest.approx(0.2)
    assert_allclose(np.cross(two - start, goal - start), 0.0, atol=1e-12)
    assert np.linalg.norm(far - start) > np.linalg.norm(goal - start)
    stopped = wishes(simulation, "push", [3.0, 9.0], speed=0.2, seconds=1.0)
    assert_array_equal(stopped[0], stopped[1])


@pytest.mark.parametrize("speed", [0.1, 0.2, 0.4])
def test_a_push_approaches_at_the_requested_speed(speed: float) -> None:
    """With w_max at this speed, w along the line between the hands is within 2 % of it."""
    changes = (
        ("scene", "hold"),
        ("rig", "table"),
        ("pairs", "single"),
        ("wmax", speed),
        ("law", "unprotected"),
    )
    setup = Setup(changes, Input("script", "push", (("speed", speed),)), None, 1.0 + 0.3 / speed, FOLDER)
    w = measured(setup, "largest_approach")
    assert w == pytest.approx(speed, rel=0.02)


def test_a_wall_moves_straight_tilts_and_stops() -> None:
    simulation = fresh("first_task")
    person = script(
        "wall_to",
        checked_script("wall_to", {"x": -0.3, "z": -0.4, "tilt": 0.5, "after": 1.0}, "first_task"),
        simulation,
    )
    targets = [person.target(time) for time in (1.0, 2.25, 3.5, 9.0)]
    begin, half, end, later = (target for target in targets if isinstance(target, WallTarget))
    assert_allclose(half.position - begin.position, [-0.15, 0.0, -0.2], atol=1e-12)
    assert_allclose(end.position - begin.position, [-0.3, 0.0, -0.4], atol=1e-12)
    assert_array_equal(end.position, later.position)
    tilts = [target.turn[1] for target in (begin, half, end)]
    assert_allclose(tilts, [0.0, 0.25, 0.5], atol=1e-12)


def test_without_a_wall_the_script_names_the_first_task_with_one(approve: Approve) -> None:
    with pytest.raises(BadSetting) as found:
        script("wall_to", (("x", -0.3),), fresh("first_task", first="stops"))
    approve("wall.txt", f"{found.value}\n")


def test_to_and_fro_begins_and_ends_at_rest() -> None:
    assert [to_and_fro(t, 3.0, 1.0) for t in (0.0, 1.0, 4.0, 5.0, 8.0, 9.0)] == [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]
    path = np.array([to_and_fro(0.001 * i, 3.0, 1.0) for i in range(9000)])
    assert path.min() >= 0.0 and path.max() <= 1.0 and np.abs(np.diff(path, 2)).max() < 1e-5


BAD_SCRIPTS: tuple[tuple[str, dict[str, Any], str], ...] = (
    ("shove", {}, "hold"),
    ("push", {}, "hold"),
    ("push", {"speed": "fast"}, "hold"),
    ("push", {"speed": 0.2, "at": "nose"}, "hold"),
    ("push", {"speed": 0.2}, "ball"),
    ("push", {"speed": 0.2}, "imitation"),
    ("push", {"speed": 0.2, "to": PLACE}, "hold"),
    ("ball_to", {}, "ball"),
    ("wall_to", {"x": -0.3}, "hold"),
    ("push", {"speed": 0.2}, "first_task"),
    ("ball_to", {"place": 3.0}, "ball"),
)
"""Name, parameters, scene."""


def test_bad_scripts_are_named(approve: Approve) -> None:
    said = ""
    for name, given, scene in BAD_SCRIPTS:
        with pytest.raises(BadSetting) as found:
            checked_script(name, given, scene)
        said += f"{scene}, {name}: {found.value}\n"
    approve("scripts.txt", said)


@pytest.mark.parametrize("origin", ["hand", "goal", "middle", "elbow"])
@pytest.mark.parametrize("gap", [0.0, 0.1, 0.5])
def test_a_placed_ball_has_its_gap(origin: Any, gap: float) -> None:
    room = build_ball_room("lwr", "elbow" if origin == "elbow" else "hand")
    centre = ball_centre(room, RoomPlace(origin, (1.0, 2.0, -0.5), gap))
    simulation = fresh("ball", point="elbow" if origin == "elbow" else "hand")
    simulation.kinematics.update(simulation.positions)
    arm = simulation.avoiding
    hand, elbow = (
        simulation.kinematics.hand_pose(arm).translation,
        simulation.kinematics.joint_point(arm.elbow),
    )
    at = {"hand": hand, "goal": hand + PATH, "middle": hand + PATH / 2.0, "elbow": elbow}[origin]
    assert np.linalg.norm(centre - at) == pytest.approx(gap + BALL_RADIUS + POINT_RADIUS)
    assert_allclose(np.cross(centre - at, [1.0, 2.0, -0.5]), 0.0, atol=1e-12)
    if origin in ("hand", "elbow"):
        simulation.reset(start_positions(room, Start(RoomPlace(origin, (1.0, 2.0, -0.5), gap))))
        simulation.step(None)
        assert simulation.sample().distance == pytest.approx(gap, abs=1e-9)


def test_impossible_places_are_named() -> None:
    room = build_ball_room()
    refused = [
        (lambda: ball_centre(build_alone(), PLACE), "scene = ball"),
        (lambda: ball_centre(room, RoomPlace("goal", (0.0, 0.0, 0.0), 0.1)), "not a direction"),
        (lambda: ball_centre(room, RoomPlace("goal", (1.0, 0.0, 0.0), 2.9)), "out of its room"),
        (
            lambda: start_positions(build_alone(), Start(posture=(0.0,) * 3)),
            "has 3 angles, but the arms of this room have 7",
        ),
        (
            lambda: start_positions(build_room("table"), Start(posture=(0.0, 9.0, *(0.0,) * 12))),
            "angle 2 is 9; it must be from",
        ),
    ]
    for place, message in refused:
        with pytest.raises(BadSetting, match=message):
            place()


def test_a_posture_and_a_ball_together() -> None:
    room = build_ball_room()
    posture = (0.1, 0.4, 0.0, 1.5, 0.0, -1.0, 0.0)
    positions = start_positions(room, Start(PLACE, posture))
    assert positions is not None and room.ball is not None
    assert_array_equal(positions[:7], posture)
    assert_array_equal(positions[room.ball], ball_centre(room, PLACE))
    assert start_positions(room, None) is None
    assert start_positions(room, Start()) is not None and not np.shares_memory(
        start_positions(room, Start()), room.start
    )


def test_a_mark_at_angle_0_is_at_the_elbow() -> None:
    marks = mark_places(build_alone(), (0.0, 2.0 * np.pi, 1.0))
    assert_allclose(marks[0], marks[1], atol=1e-12)
    assert np.linalg.norm(marks[2] - marks[0]) > 0.1


def test_a_file_moves_the_hand(tmp_path: Any) -> None:
    (tmp_path / "push.csv").write_text("t,x,y,z\n0,0.3,0,1.1\n2,0.0,0,1.1\n", encoding="utf-8")
    setup = Setup((("scene", "hold"), ("rig", "table")), Input("file", "push.csv"), None, 1.0, tmp_path)
    simulation = Simulation(setup.run)
    target = person_of(simulation, setup).target(1.0)
    assert isinstance(target, HandTarget)
    assert_allclose(target.position, [0.15, 0.0, 1.1])
