"""The experiment of another first task: rows, promises, bad input, and reproducible runs."""

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from controllers.errors import BadInputFile, BadSetting
from controllers.kinematics import Array
from scenes.first_task.autopilot import FirstTaskAutopilot
from scenes.first_task.detector import FirstTaskDetector
from scenes.first_task.wall import BASE_CLEAR, WALL_SPEED, angles_of, normal_of, plane_of, turn_of
from scenes.headless import run
from scenes.history import COLUMN
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.quantities import FIRST_TASKS
from scenes.recording import write_table
from scenes.rerun import rerun
from scenes.roles import Scripted
from scenes.room import World
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget, Target, WallTarget
from tests.approved import Approve
from tests.scenes.helpers import recorded_run, refusal

NAMES = tuple(FIRST_TASKS)
ALL_WAYS = [(name, "ratios") for name in NAMES] + [("all", "stages")]


def of(first: str, **others: Any) -> RunSettings:
    settings = RunSettings(scene="first_task", first=first)
    for key, value in others.items():
        settings = changed(settings, key, value)
    return settings


def least_of(settings: RunSettings, seconds: float, **more: Any) -> float:
    return run(settings, seconds, **more).summary.d_min


@pytest.mark.parametrize("first", NAMES)
@pytest.mark.parametrize("pairs", ["single", "soft"])
def test_the_row_is_the_gradient_also_along_the_wall(first: str, pairs: Any) -> None:
    room = Simulation(of(first)).room
    world, random = World(room, 10.0), np.random.default_rng(3)
    for _ in range(5):
        q = room.start + random.uniform(-0.25, 0.25, room.model.nq)

        def value(at: Array) -> float:
            world.kinematics.update(at)
            return world.detector.detect(pairs).law_distance

        world.kinematics.update(q)
        row = world.detector.detect(pairs).row.copy()
        step = 1e-6 * np.eye(len(q))
        expected = [(value(q + one) - value(q - one)) / 2e-6 for one in step]
        np.testing.assert_allclose(row, expected, atol=2e-7)


@pytest.mark.parametrize(("first", "together"), ALL_WAYS)
def test_the_autopilot_soon_activates_the_law_which_keeps_the_threshold(first: str, together: str) -> None:
    """λ > .2 within 8 s; the threshold, without joint bounds, is kept for a whole round."""
    kept = run(of(first, together=together), 20.0)
    lam, t = kept.table[:, COLUMN["lambda"]], kept.table[:, COLUMN["t"]]
    assert lam[t < 8.0].max() > 0.2
    assert kept.summary.d_min >= 0.15 - 2e-4
    assert least_of(of(first, law="unprotected"), 20.0) < 0.13


def test_without_the_law_the_arm_enters_the_wall_becomes_singular_and_tips() -> None:
    assert least_of(of("wall", law="unprotected"), 20.0) < 0.0
    assert least_of(of("singular", law="unprotected"), 20.0) < 0.001
    assert least_of(of("tip", law="unprotected"), 20.0) < -0.005


def test_with_stages_the_last_task_is_kept_and_with_ratios_all_are() -> None:
    far = Scripted(lambda _: HandTarget(np.array([0.9, 0.9, 1.2])))
    for together in ("ratios", "stages"):
        simulation = Simulation(of("all", together=together))
        detector = simulation.detector
        assert isinstance(detector, FirstTaskDetector)
        least = np.full(4, np.inf)
        for _ in range(1600):
            simulation.step(far.target(simulation.time))
            simulation.world.update()
            detector.detect()
            least = np.minimum(least, detector.distances())
        assert detector.pair_names[-1][1] == "edge of the foot"
        assert least[-1] >= 0.15 - 2e-4
        assert (least.min() >= 0.15 - 2e-4) or together == "stages"


@pytest.mark.parametrize(("first", "together"), ALL_WAYS)
def test_joint_speeds_change_without_jumps(first: str, together: str) -> None:
    """The largest step of q̇ falls with the time step, which a jump would not do."""
    steps = [run(of(first, together=together, dt=dt), 6.0).summary.dq_step_max for dt in (0.005, 0.00125)]
    assert steps[0] < 0.05 and steps[1] < 0.4 * steps[0]


def test_the_wall_stops_before_the_base_and_keeps_its_speed_limit() -> None:
    simulation = Simulation(of("wall"))
    wall, shoulder = simulation.room.wall, simulation.kinematics.joint_point(simulation.avoiding.shoulder)
    for _ in range(1500):
        simulation.step(WallTarget(np.array([-2.0, 0.0, 1.4]), np.array([0.3, 0.2])))
        at = simulation.positions[wall]
        assert normal_of(*at[3:].tolist()).dot(shoulder - at[:3]) > BASE_CLEAR - 1e-6
        assert (
            np.abs(simulation.velocities[wall][:3]).max()
            <= min(simulation.settings.hand_speed, WALL_SPEED) + 1e-9
        )
    assert simulation.velocities[wall] == pytest.approx(np.zeros(5), abs=1e-6)


def test_the_wall_s_angles_match_its_orientation() -> None:
    for turn, tilt in np.random.default_rng(1).uniform((-3.0, -1.5), (3.0, 1.5), (20, 2)):
        normal = normal_of(turn, tilt)
        np.testing.assert_allclose(angles_of(normal), [turn, tilt], atol=1e-12)
        at = np.array([0.1, 0.2, 0.3, turn, tilt])
        np.testing.assert_allclose(-turn_of(at)[:, 0], normal, atol=1e-12)
        np.testing.assert_allclose(plane_of(at).normal, normal, atol=0.0)


def test_a_turning_wall_slower_than_v_never_crosses_the_threshold() -> None:
    def push(time: float) -> Target:
        return WallTarget(
            np.array([0.30 - 0.12 * min(time, 3.0), 0.05, 1.4]), np.array([0.25 * np.sin(time), 0.2])
        )

    done = run(of("wall", n=6.0), 5.0, Scripted(push))
    assert done.table[:, COLUMN["w_law"]].max() > 0.05
    assert done.summary.d_min >= 0.15


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (of("tip", dm=0.3), "the edge of the foot; take a smaller d_m"),
        (of("singular", dm=0.29), "the singularity; take a smaller d_m"),
    ],
)
def test_a_threshold_above_the_start_s_margin_is_refused(settings: RunSettings, said: str) -> None:
    with pytest.raises(BadSetting, match=said):
        run(settings, 0.1)


def test_a_load_that_tips_the_cart_at_the_start_is_refused(approve: Approve) -> None:
    settings = of("tip", load=20.0)
    start = Simulation(settings).room.start.copy()
    # Stretched to the side.
    start[:7] = [np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0]
    approve("tipped cart.txt", refusal(lambda: run(settings, 0.1, start=start)) + "\n")
    assert least_of(of("tip", load=0.0, dm=0.05), 0.1, start=start) > 0.05


def test_a_wall_through_the_base_is_refused(approve: Approve) -> None:
    settings = of("wall")
    start = Simulation(settings).room.start.copy()
    start[7:10] = [-0.35, 0.0, 1.2]
    approve("wall in the base.txt", refusal(lambda: run(settings, 0.1, start=start)) + "\n")


@pytest.mark.parametrize(("first", "together"), ALL_WAYS)
def test_a_recorded_run_is_reproduced_exactly(first: str, together: str) -> None:
    """To the bit, from a file with the wall's targets and from a snapshot."""
    settings = of(first, together=together)
    simulation, recorded = recorded_run(settings, 2.0, 99.0, {})
    back = recorded_from(recorded_bytes(recorded), "a file")
    assert rerun(back).table.tobytes() == simulation.history.table().tobytes()
    moment = simulation.snapshot()
    other = Simulation(settings)
    other.resume(moment)
    for one in (simulation, other):
        for _ in range(50):
            one.step(WallTarget(np.array([0.0, 0.1, 1.3]), np.zeros(2)))
    assert other.positions.tobytes() == simulation.positions.tobytes()


def test_a_file_with_an_impossible_wall_is_refused() -> None:
    _, recorded = recorded_run(of("wall"), 0.1, 99.0, {})
    stretch = recorded.stretches[0]
    numbers = stretch.targets.numbers.copy()
    numbers[3] = 99.0
    damaged = replace(
        recorded, stretches=(stretch._replace(targets=stretch.targets._replace(numbers=numbers)),)
    )
    with pytest.raises(BadInputFile, match="beyond two turns"):
        recorded_from(recorded_bytes(damaged), "a file")


def test_the_table_has_the_unit_of_the_first_task() -> None:
    for first, unit in (("stops", "rad"), ("singular", "m/rad"), ("tip", "m")):
        done, out = run(of(first), 0.05), io.StringIO()
        write_table(out, done.simulation, done.table, {})
        assert f"d [{unit}]" in out.getvalue() and f"u [{unit}/s]" in out.getvalue()
    done, out = run(of("wall"), 0.05), io.StringIO()
    write_table(out, done.simulation, done.table, {})
    assert "wall_q_x [m]" in out.getvalue() and "wall_dq_turn [rad/s]" in out.getvalue()


def test_the_autopilot_depends_on_time_only() -> None:
    hand = np.array([-0.1, 0.0, 1.5])
    one, other = (FirstTaskAutopilot("all", 3, hand) for _ in range(2))
    times = np.linspace(0.0, 60.0, 400)
    forward = [one.target(t) for t in times.tolist()]
    backward = [other.target(t) for t in times[::-1].tolist()][::-1]
    for a, b in zip(forward, backward, strict=True):
        assert type(a) is type(b)
        np.testing.assert_array_equal(a[0], b[0])  # type: ignore[index]
