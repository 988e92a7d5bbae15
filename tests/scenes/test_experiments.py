"""Every experiment, robot and law in one loop: common properties, and the purpose of each experiment."""

import itertools
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from scenes import settings as options
from scenes.headless import run
from scenes.laws import LAWS
from scenes.simulation import Simulation
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget
from tests.scenes.helpers import RIG_NAMES, SCENES, column, play, recorded_run, scene_settings

pytestmark = pytest.mark.slow

ROBOTS = get_args(options.RobotName)


def experiment(scene: str, name: str = "smooth_priority", **fields: object) -> options.RunSettings:
    settings = options.RunSettings(scene=scene, law=options.LawSettings(law=name))
    return replace(settings, **fields)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scene", SCENES)
def test_every_law_runs_in_every_experiment(scene: str, law: str) -> None:
    """At the largest time step, where stops and top speeds are hardest to keep."""
    for coupled in (False, True):
        chosen = options.LawSettings(law=law, coupled=coupled, pairs="soft" if coupled else "single")
        settings = experiment(scene, law=chosen, dt=0.02)
        result = run(settings, 2.0)
        model, history = result.simulation.room.model, result.simulation.history
        q, dq = history.positions(result.table), history.velocities(result.table)
        assert np.isfinite(q).all() and np.isfinite(dq).all()
        assert (q >= model.lowerPositionLimit - 1e-9).all() and (q <= model.upperPositionLimit + 1e-9).all()
        assert (np.abs(dq) <= model.velocityLimit * (1.0 + 1e-9)).all()
        assert 0.0 <= column(result.table, "lambda").min() <= column(result.table, "lambda").max() <= 1.0


@pytest.mark.parametrize("scene", SCENES)
def test_targets_of_other_experiments_are_ignored(scene: str) -> None:
    simulation = Simulation(experiment(scene))
    n = simulation.guided.joints.stop - simulation.guided.joints.start
    places = HandTarget(np.array([0.2, 0.1, 1.1])), BallTarget(np.array([0.3, 0.0, 1.0]))
    for wish in (*places, JointTarget(np.zeros(n)), AnglesTarget(np.zeros((2, 4))), AnglesTarget(None), None):
        play(simulation, [wish] * 10)
    assert np.isfinite(simulation.positions).all()


@pytest.mark.parametrize(
    ("scene", "rig"),
    [("solo", "torso"), ("ball", "torso"), *itertools.product(("hold", "master_slave"), RIG_NAMES)],
)
@pytest.mark.parametrize("robot", ROBOTS)
def test_every_arm_does_every_experiment(robot: options.RobotName, scene: str, rig: options.RigName) -> None:
    """The place of a single arm does not depend on the rig."""
    result = run(experiment(scene, robot=robot, rig=rig, dt=0.01), 12.0)
    assert result.summary.d_min >= 0.15 - 1e-4 and result.summary.out_of_authority_s == 0.0
    # The start postures are chosen so that the hand comes near.
    assert scene != "hold" or result.summary.d_min < 1.2 * 0.15


def test_changes_of_laws_and_roles_in_a_run_do_not_move_the_arms() -> None:
    simulation = Simulation(options.RunSettings())
    for scene in SCENES:
        for robot in ROBOTS:
            simulation.apply(experiment(scene, robot=robot))
            for law in LAWS:
                for avoid in get_args(options.AvoidChoice):
                    before = simulation.positions.copy()
                    simulation.apply(experiment(scene, law, robot=robot, avoid=avoid))
                    assert_array_equal(simulation.positions, before)
                    simulation.step(None)
            assert np.isfinite(simulation.positions).all()


@pytest.mark.parametrize("v", [0.02, 0.05])
@pytest.mark.parametrize("scene", ["master_slave", "imitation"])
def test_two_avoiding_arms_keep_the_threshold_for_any_v(scene: str, v: float) -> None:
    """ḋ = 2 λ v − (1 − λ)(u_1 + u_2): both together hold d_m for any small v; one alone would lose w − v."""
    both = experiment(scene, law=options.LawSettings(nominal_velocity=v), clip="cross", seed=2, dt=0.01)
    assert run(both, 12.0).summary.d_min >= 0.15 - 1e-3
    assert run(replace(both, avoid="free"), 12.0).summary.d_min < 0.15 - 0.01


@pytest.mark.parametrize("seed", range(1, 7))
def test_two_arms_that_add_the_obstacles_speed_to_v_do_not_oscillate(seed: int) -> None:
    """With a common row each adds the other's w: no velocity jumps by .1 rad/s in a time step."""
    order, dt = ((6.0, 0.01), (20.0, 0.005))[seed % 2]
    chosen = options.LawSettings(feed_forward=True, order=order)
    settings = experiment("master_slave", law=chosen, hand_speed=0.8, seed=seed, dt=dt)
    result = run(settings, 10.0)
    assert (
        settings.one_row
        and np.abs(np.diff(result.simulation.history.velocities(result.table), axis=0)).max() <= 0.1
    )


def test_followers_copy_their_models() -> None:
    # Mirrored: joints about the vertical turn oppositely; identical: all equal; from the start posture.
    for following, signs in (
        ("identical", np.ones(7)),
        ("mirrored", np.array([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])),
    ):
        settings = experiment("master_slave", "unprotected", following=following, rig="table")
        simulation = Simulation(settings)
        master, slave, start = simulation.guided.joints, simulation.avoiding.joints, simulation.room.start
        wish = JointTarget(start[master] + np.array([0.1, -0.1, 0.05, 0.1, 0.2, -0.1, 0.1]))
        play(simulation, [wish] * 1200)
        assert_allclose(simulation.positions[master], wish.positions, atol=1e-3)
        assert_allclose(
            simulation.positions[slave] - start[slave], signs * (wish.positions - start[master]), atol=1e-3
        )
    # Without a visible person the robots rest in the last pose; they continue when the person is back.
    simulation = Simulation(experiment("imitation", "unprotected", clip="wave"))
    person = simulation.source()
    play(simulation, [person.target(i * 0.005) for i in range(400)] + [AnglesTarget(None)] * 600)
    still = simulation.positions.copy()
    play(simulation, [AnglesTarget(None)] * 50)
    assert_allclose(simulation.positions, still, atol=1e-4)
    play(simulation, (person.target(i * 0.005) for i in range(1000, 1400)))
    assert np.abs(simulation.positions - still).max() > 0.05
    coupled = experiment("imitation", law=options.LawSettings(coupled=True, pairs="single"), clip="clap")
    assert run(coupled, 15.0).summary.d_min >= 0.15 - 1e-4


@pytest.mark.parametrize(
    ("scene", "key", "value"),
    [
        ("hold", "path", "circle"),
        ("ball", "guided", "left"),
        ("imitation", "guided", "left"),
        ("solo", "start", "between"),
    ],
)
def test_settings_that_an_experiment_does_not_read_change_no_run(scene: str, key: str, value: str) -> None:
    """Neither at the start nor in the middle."""
    table = recorded_run(scene_settings(scene), 1.0, 1.0)[0].history.table()
    touched, recorded = recorded_run(scene_settings(scene), 1.0, 1.0, {0.5: {key: value}})
    assert touched.history.table().tobytes() == table.tobytes() and recorded.steps == len(table)
    assert (
        recorded_run(scene_settings(scene, **{key: value}), 1.0, 1.0)[0].history.table().tobytes()
        == table.tobytes()
    )


@pytest.mark.parametrize("clip", get_args(options.ClipName))
def test_imitated_angles_are_followed_where_nothing_is_near(clip: options.ClipName) -> None:
    result = run(experiment("imitation", "unprotected", clip=clip, dt=0.01), 12.0)
    q, wanted = (
        result.simulation.history.positions(result.table),
        result.simulation.history.desired(result.table),
    )
    assert np.isfinite(wanted).all() and np.abs(q - wanted).max() < np.radians(3.0)
    assert np.ptp(wanted[:, :4], axis=0).max() > 0.3


@pytest.mark.parametrize("point", get_args(options.ControlPoint))
@pytest.mark.parametrize("motion", get_args(options.BallMotion))
def test_the_arm_passes_the_ball_at_a_distance(
    point: options.ControlPoint, motion: options.BallMotion
) -> None:
    result = run(experiment("ball", point=point, ball=motion, dt=0.01), 15.0)
    assert result.summary.d_min >= 0.15 - 1e-4
    assert (
        run(experiment("ball", "unprotected", point=point, ball=motion, dt=0.01), 15.0).summary.d_min < 0.15
    )
    # At the far end, away from the ball, the hand is on its path.
    if point != "arm" and motion == "still":
        assert column(result.table, "e2")[int(7.4 / 0.01)] < 0.08**2


def test_a_circle_chosen_during_a_run_begins_at_the_hand() -> None:
    simulation = Simulation(experiment("solo"))
    play(simulation, [None] * 777)
    simulation.apply(experiment("solo", path="circle"))
    play(simulation, [None])
    assert simulation.sample().error < 0.002
    play(simulation, [None] * 200)
    assert simulation.sample().error < 0.01
