"""A robot with delays and noisy sensors: no effect if off, and reproducible if on."""

import math
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from controllers.budget import distance_rate
from controllers.errors import BadInputFile
from controllers.kinematics import Array, Kinematics
from controllers.laws.situation import Situation, Unanswered
from scenes import random_runs
from scenes.hardware import measured_positions
from scenes.headless import run
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.promise import Condition, missing
from scenes.random_draws import random_run
from scenes.rerun import newest_piece, rerun
from scenes.room import World
from scenes.settings import HardwareSettings, RunSettings, changed
from scenes.simulation import Simulation
from tests.scenes.helpers import SCENES, column, groups_of, recorded_run, scene_settings, with_values
from tests.scenes.inputs.helpers import rewritten

REAL = {"dead": 0.05, "lag": 0.02, "qnoise": 1e-4, "qstep": 2e-4, "fps": 30.0, "dnoise": 5e-4}


def real(settings: RunSettings, **changes: Any) -> RunSettings:
    """The settings with a robot that is not ideal."""
    return with_values(settings, **(changes or REAL))


@pytest.mark.parametrize("scene", SCENES)
def test_a_run_is_reproduced_to_the_bit(scene: str) -> None:
    """From the middle of a run with changes of the robot, from a file, and from the last seconds."""
    settings = real(scene_settings(scene))
    changes = {
        0.3: {"dead": 0.08},
        0.6: {"dead": 0.0, "fps": 0.0},
        0.65: {"lag": 0.0, "qnoise": 0.0, "qstep": 0.0, "dnoise": 0.0},
        0.7: REAL,
    }
    simulation, recorded = recorded_run(settings, 2.0, 1.6, changes)
    table = simulation.history.table(recorded.steps)
    assert rerun(recorded).table.tobytes() == table.tobytes()
    file = recorded_from(recorded_bytes(recorded), "file")
    assert rerun(file).table.tobytes() == table.tobytes()
    piece = newest_piece(recorded, 0.45)
    assert rerun(piece).table.tobytes() == table[-piece.steps :].tobytes()
    # The same start gives the same bits; another seed gives another noise.
    once, again, other = (
        run(one, 0.5).table.tobytes() for one in (settings, settings, changed(settings, "seed", 7))
    )
    assert once == again != other


def test_a_lag_continues_after_a_slider_and_in_a_rerun() -> None:
    settings = real(scene_settings("hold", pairs="single"), lag=0.03)
    simulation, recorded = recorded_run(settings, 5.0, 2.0, {4.0: {"k": 1.5}})
    assert recorded.begin > 1.5
    assert rerun(recorded).table.tobytes() == simulation.history.table(recorded.steps).tobytes()
    # A setting without effect on the joints changes nothing.
    touched, _ = recorded_run(settings, 4.0, 1.0, {3.0: {"beta": 90.0}})
    left_alone, _ = recorded_run(settings, 4.0, 1.0)
    assert touched.history.table().tobytes() == left_alone.history.table().tobytes()


def test_a_slow_camera_keeps_the_task_velocity_of_both_hands() -> None:
    """d and J_d are from the last frame, the hands' Jacobians are current."""
    settings = with_values(
        scene_settings("hold"), avoid="both", law="null_space_avoidance", fps=5.0, d0=0.6, wmax=0.5
    )
    simulation = Simulation(settings, 10)
    person, arms = simulation.source(), {arm.joints.start: arm for arm in simulation.room.arms}
    kinematics, moved = Kinematics(simulation.room.model, simulation.room.arms), 0.0
    for _ in range(600):
        kinematics.update(simulation.positions)
        simulation.step(person.target(simulation.time))
        for group in groups_of(simulation):
            J, added = kinematics.hand_jacobian(arms[group.joints.start], 3), group.velocities - group.nominal
            assert np.abs(J @ added).max() < 1e-8
            moved = max(moved, float(np.abs(added).max()))
    assert moved > 0.05, "the arms did not avoid"


@pytest.mark.parametrize("key", REAL)
def test_each_imperfection_alone_changes_the_run(key: str) -> None:
    settings = scene_settings("master_slave")
    assert run(real(settings, **{key: REAL[key]}), 0.5).table.tobytes() != run(settings, 0.5).table.tobytes()


@pytest.mark.parametrize("scene", ["ball", "hold", "imitation"])
def test_the_distance_is_true_and_the_law_s_input_can_be_recomputed(scene: str) -> None:
    settings = real(scene_settings(scene))
    result = run(settings, 2.0)
    table, simulation = result.table, result.simulation
    q = simulation.history.positions(table)
    world, law, hardware = World(simulation.room, settings.limit_gain), settings.law, settings.hardware
    activation = law.made().activation
    held: Array | None = None
    frame, seen, noise = -1, math.nan, math.nan
    for step in range(len(table)):
        world.kinematics.update(q[step])
        assert world.detector.detect().distance == column(table, "d")[step]
        now = int(column(table, "t")[step] * hardware.frame_rate + 1e-6)
        if now != frame:
            frame, held = now, measured_positions(settings, q[step], simulation.room.arms, step)
            world.kinematics.update(held)
            seen = world.detector.detect(law.pairs, law.beta, law.convexity).law_distance
            noise = column(table, "law_d")[step] - seen
            assert abs(noise) < 5.0 * hardware.distance_noise
        # Between two frames it is constant, noise included.
        assert column(table, "law_d")[step] == seen + noise
        assert column(table, "lambda")[step] == activation(seen + noise)
    assert np.ptp(column(table, "law_d") - column(table, "d")) > 1e-4


def test_joint_sensors_show_noise_and_steps() -> None:
    settings = real(RunSettings(), qnoise=1e-3)
    simulation = Simulation(settings)
    q, arms = simulation.positions, simulation.room.arms
    shown = np.array([measured_positions(settings, q, arms, step) - q for step in range(2000)])
    assert shown.std() == pytest.approx(1e-3, rel=0.02)
    assert abs(shown.mean()) < 5.0 * 1e-3 / math.sqrt(shown.size)
    # White noise: steps are independent.
    assert abs((shown[1:] * shown[:-1]).mean()) < 5e-6 / math.sqrt(shown.size)
    coarse = measured_positions(real(RunSettings(), qstep=0.01), q, arms, 0)
    assert coarse / 0.01 == pytest.approx(np.round(coarse / 0.01), abs=1e-9)
    assert 1e-4 < np.abs(coarse - q).max() <= 0.005 + 1e-12
    # The ball has no sensor.
    simulation = Simulation(real(scene_settings("ball"), qnoise=0.01, qstep=0.01))
    assert simulation.room.ball is not None
    shown = measured_positions(simulation.settings, simulation.positions, simulation.room.arms, 3)
    assert (shown[simulation.room.ball] == simulation.positions[simulation.room.ball]).all()


def test_a_dead_time_delays_the_arm_by_whole_steps() -> None:
    """The first command acts N steps later; meanwhile the law sees the same posture."""
    settings = scene_settings("ball")
    late = 4
    ideal = run(settings, 1.0)
    delayed = run(real(settings, dead=(late - 0.5) * settings.dt), 1.0)
    arm = ideal.simulation.avoiding.joints
    first = ideal.simulation.history.velocities(ideal.table)[0, arm]
    velocities = delayed.simulation.history.velocities(delayed.table)[:, arm]
    assert np.abs(first).max() > 0.0
    assert (velocities[:late] == 0.0).all() and (velocities[late] == first).all()


class Reluctant:
    """The paper's law, answering only every second call."""

    wants_all_pairs: ClassVar[bool] = False
    wants_task: ClassVar[bool] = False

    def __init__(self, settings: RunSettings) -> None:
        self._law, self._asked = settings.law.made(), False
        self.activation, self.line_rate = self._law.activation, self._law.line_rate

    def __call__(self, situation: Situation) -> Array:
        self._asked = not self._asked
        if self._asked:
            raise Unanswered
        return self._law(situation)


def test_a_step_without_an_answer_is_repeated_with_the_same_bits() -> None:
    settings = real(scene_settings("hold"))
    once = run(settings, 0.5)
    simulation = Simulation(settings)
    simulation.use(Reluctant(settings))
    source = simulation.source()
    for _ in range(once.summary.steps):
        target, q = source.target(simulation.time), simulation.positions.copy()
        with pytest.raises(Unanswered):
            simulation.step(target)
        assert (simulation.positions == q).all()
        simulation.step(target)
    assert simulation.history.table().tobytes() == once.table.tobytes()


def test_the_line_holds_for_the_command_and_a_late_robot_has_no_promise() -> None:
    settings = real(scene_settings("ball"), dead=0.05)
    result = run(settings, 4.0)
    table, law = result.table, settings.law
    # The law's part of ḋ is N steps late; the ball's part is immediate.
    late = round(settings.hardware.dead_time / settings.dt)
    w = column(table, "w_law")[:-1]
    asked = np.array(
        [
            distance_rate(lam, law.nominal_velocity, u, 0.0)
            for lam, u in zip(column(table, "lambda"), column(table, "u"), strict=True)
        ]
    )[:-1]
    really = np.diff(column(table, "law_d")) / settings.dt + w
    assert np.abs(really[late:] - asked[:-late]).max() < 0.02
    assert np.abs(really - asked).max() > 0.025
    assert missing(settings, table)[Condition.ROBOT].all()
    assert not missing(scene_settings("ball"), table)[Condition.ROBOT].any()


def test_a_file_with_an_impossible_robot_is_refused() -> None:
    _, recorded = recorded_run(real(scene_settings("hold")), 1.2, 0.6)
    data = recorded_bytes(recorded)
    for name, value in (
        ("robot_0", np.zeros(3)),
        ("robot_1", np.zeros((2, 2))),
        ("robot_2", np.full(14, 1e9)),
        ("robot_3", np.array(-7)),
        ("robot_1", np.zeros((0, 14), "U1")),
    ):
        with pytest.raises(BadInputFile, match="impossible robot"):
            recorded_from(rewritten(data, **{name: value}), "file")


@pytest.mark.parametrize("index", [2, 8, 18])
@pytest.mark.parametrize("sensors", [{"qnoise": 0.02}, {"qstep": 0.02}], ids=["noise", "steps"])
def test_the_true_joints_keep_their_limits_with_any_sensor_noise(
    index: int, sensors: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = random_run(5, index)
    seen_badly = replace(
        drawn, settings=real(replace(drawn.settings, hardware=HardwareSettings()), **sensors)
    )
    monkeypatch.setattr(random_runs, "random_run", lambda *_: seen_badly)
    assert random_runs.run_verdict(5, index, 3.0).faults == ()
