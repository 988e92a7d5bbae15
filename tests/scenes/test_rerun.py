"""Reruns from recorded inputs: to the bit, with other settings, in finer steps; test of smoothness."""

import math
import pickle
from dataclasses import replace
from functools import cache
from itertools import pairwise, permutations
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.errors import BadSetting
from scenes.headless import summarise
from scenes.inputs import InputsLog, Recorded
from scenes.laws import LAWS
from scenes.rerun import LOOK, WHAT_IF_KEYS, newest_piece, newest_steps, rerun, target_between, warm, what_if
from scenes.settings import RunSettings, changed, specs, values
from scenes.simulation import Simulation
from scenes.smoothness import SUBSTEPS, StepStudy, StepTrend, largest_velocity_step, unmeasured
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget, LinkTarget, Target
from scenes.wanted import Stopped, until
from tests.scenes.helpers import SCENES, column, given_settings, recorded_run, scene_settings


@cache
def session(scene: str, law: str, seconds: float, window: float) -> tuple[Simulation, Recorded]:
    return recorded_run(
        scene_settings(scene, law=law),
        seconds,
        window,
        {0.5: {"dm": 0.11, "avoid": "both"}, 0.8: {"k": 3.0, "dt": 0.004}},
    )


@pytest.mark.parametrize(
    ("scene", "law"),
    [
        *(("hold", law) for law in LAWS),
        *(
            (scene, law)
            for scene in SCENES
            if scene != "hold"
            for law in ("smooth_priority", "barrier_qp", "intermediate_value")
        ),
    ],
)
def test_a_rerun_from_the_middle_of_a_run_has_the_same_bits(scene: str, law: str) -> None:
    simulation, recorded = session(scene, law, 2.6, 1.6)
    assert recorded.begin >= 0.9 and len(recorded.stretches) == 3
    sent = pickle.loads(pickle.dumps(recorded))
    assert rerun(sent).table.tobytes() == simulation.history.table(recorded.steps).tobytes()


@pytest.mark.parametrize(("key", "value"), [("dead", 0.05), ("fps", 20.0)])
def test_a_setting_changed_and_restored_between_steps_has_no_effect(key: str, value: float) -> None:
    """The log contains only settings in force at a step."""
    tables: list[bytes] = []
    for between in (0.0, value):
        simulation = Simulation(given_settings(**{key: value}))
        source = simulation.source()
        for number in range(400):
            if number == 200:
                for one in (between, value):
                    simulation.apply(changed(simulation.settings, key, one))
            simulation.step(source.target(simulation.time))
        tables.append(simulation.history.table().tobytes())
    assert tables[0] == tables[1]


@pytest.mark.parametrize("scene", SCENES)
def test_the_last_seconds_can_be_rerun_alone(scene: str) -> None:
    simulation, recorded = session(scene, "smooth_priority", 2.6, 1.6)
    table = simulation.history.table(recorded.steps)
    for seconds in (0.004, 1.0, recorded.seconds - recorded.settings.dt, recorded.seconds, math.inf):
        piece = newest_piece(recorded, seconds)
        assert piece.steps == newest_steps(recorded, seconds)
        # With two time steps the lengths may differ slightly.
        assert abs(piece.seconds - min(seconds, recorded.seconds)) < 0.005
        assert rerun(piece).table.tobytes() == table[-piece.steps :].tobytes()
    for one, other in zip(newest_piece(recorded, math.inf).stretches, recorded.stretches, strict=True):
        assert one is other
    with pytest.raises(Stopped), until(lambda: True):
        newest_piece(recorded, 0.004)


def test_other_settings() -> None:
    simulation, recorded = recorded_run(RunSettings(), 5.0, 3.0)
    summary = summarise(simulation, simulation.history.table(recorded.steps))
    assert replace(rerun(recorded).summary, step_us_median=0.0) == replace(summary, step_us_median=0.0)
    _, recorded = recorded_run(RunSettings(), 4.5, 99.0, {0.5: {"k": 1.0}})
    would = Simulation(given_settings(dm=0.2, n=3.0, k=4.0))
    for target in recorded.targets():
        would.step(target)
    again = rerun(recorded, {"dm": 0.2, "n": "3", "k": 4.0})
    assert again.table.tobytes() == would.history.table().tobytes()
    assert again.summary.d_min > rerun(recorded).summary.d_min + 0.01
    _, recorded = recorded_run(RunSettings(), 2.0, 99.0, {0.5: {"wmax": 0.1, "dm": 0.2}})
    would = Simulation(given_settings(v=0.5))
    for i, target in enumerate(recorded.targets()):
        if i == 200:
            would.apply(given_settings(v=0.5, wmax=0.1, dm=0.2))
        would.step(target)
    assert rerun(recorded, {"v": 0.5}).table.tobytes() == would.history.table().tobytes()
    assert set(WHAT_IF_KEYS) <= set(specs(RunSettings))
    _, recorded = session("hold", "smooth_priority", 2.6, 1.6)
    assert (
        rerun(recorded, {key: values(RunSettings())[key] for key in WHAT_IF_KEYS}).table.shape[0]
        == recorded.steps
    )


@pytest.mark.parametrize(
    ("impossible", "message"),
    [
        *(
            ({"overrides": {key: value}}, f"{key} cannot be given")
            for key, value in (("rig", "table"), ("dt", 0.01))
        ),
        ({"overrides": {"dm": 9.0}}, "dm = 9"),
        ({"overrides": {"mood": 1}}, "no setting 'mood'"),
        *(({"substeps": count}, f"substeps = {count} is too small") for count in (0, -1)),
    ],
)
def test_impossible_reruns_are_refused(impossible: dict[str, Any], message: str) -> None:
    _, recorded = session("hold", "smooth_priority", 2.6, 1.6)
    with pytest.raises(BadSetting, match=message):
        rerun(recorded, **impossible)


def test_what_if_is_exact() -> None:
    simulation, recorded = recorded_run(RunSettings(), 6.0, 3.0)
    table = simulation.history.table(recorded.steps)
    before = summarise(simulation, table)
    present = values(given_settings(dm=0.1))
    exact = what_if(recorded, {key: present[key] for key in WHAT_IF_KEYS}, before)
    again = rerun(recorded, {"dm": 0.1})
    assert exact.before == before and exact.settings == given_settings(dm=0.1)
    assert replace(exact.summary, step_us_median=0.0) == replace(again.summary, step_us_median=0.0)
    assert exact.times.tobytes() == column(table, "t").tobytes()
    assert exact.distance.tobytes() == column(again.table, "d").tobytes()
    assert exact.squared_error.tobytes() == column(again.table, "e2").tobytes()


def test_finer_steps_converge() -> None:
    _, recorded = recorded_run(RunSettings(), 5.5, 2.0)
    ends, times = {}, column(rerun(recorded).table, "t")
    for substeps in (1, 2, 4, 8):
        again = rerun(recorded, substeps=substeps)
        assert len(again.table) == recorded.steps * substeps
        assert np.allclose(column(again.table, "t")[::substeps], times, atol=1e-9)
        ends[substeps] = again.table[-substeps, len(again.table[0]) - 42 :][:14]
    differences = [float(np.abs(ends[2 * k] - ends[k]).max()) for k in (1, 2, 4)]
    # Euler's method has an error of first order: half the dt, half the remaining error.
    assert 0.0 < differences[2] < differences[1] < differences[0] < 0.02
    assert 0.35 < differences[1] / differences[0] < 0.65 and 0.35 < differences[2] / differences[1] < 0.65


def test_a_cancelled_rerun_stops_soon() -> None:
    _, recorded = session("hold", "smooth_priority", 2.6, 1.6)
    asked: list[bool] = []

    def stopped() -> bool:
        asked.append(len(asked) == 3)
        return asked[-1]

    with pytest.raises(Stopped), until(stopped):
        rerun(recorded)
    assert len(asked) == 4 and recorded.steps > 4 * LOOK
    with pytest.raises(Stopped), until(lambda: True):
        warm(RunSettings())


def test_seams_and_kinds() -> None:
    # Seams are changes of settings or of the kind of target.
    simulation, log = Simulation(RunSettings()), InputsLog()
    here = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    hand, pulled = HandTarget(here), HandTarget(here, elbow=np.array([0.2, -0.4, 1.0]))
    for i, target in enumerate([None] * 10 + [hand] * 10 + [pulled] * 10 + [hand] * 5):
        if i == 33:
            simulation.apply(given_settings(dm=0.2))
        log.record(simulation, target)
        simulation.step(target)
    recorded = log.window(9.0)
    assert recorded is not None
    assert rerun(recorded).seams == (10, 20, 30, 33)
    assert rerun(recorded, substeps=3).seams == (30, 60, 90, 99)
    assert rerun(recorded, {"dm": 0.1}).seams == (10, 20, 30)
    # Between two kinds the first one is kept.
    kinds: list[Target | None] = [
        *(
            None,
            HandTarget(np.zeros(3)),
            HandTarget(np.zeros(3), np.eye(3)),
            HandTarget(np.zeros(3), None, np.zeros(3)),
        ),
        *(
            JointTarget(np.zeros(7)),
            BallTarget(np.zeros(3)),
            AnglesTarget(None),
            AnglesTarget(np.zeros((2, 4))),
        ),
    ]
    for first, second in permutations(kinds, 2):
        assert target_between(first, second, 0.5) is first
    assert target_between(AnglesTarget(None), AnglesTarget(None), 0.5) == AnglesTarget(None)
    # A jump caused by settings does not count against the law.
    changes = {share: {"dm": 0.15 + 0.05 * (i % 2)} for i, share in enumerate((0.75, 0.8, 0.9))}
    simulation, recorded = recorded_run(RunSettings(), 6.0, 2.0, changes)
    assert rerun(recorded).summary.dq_step_max > 20.0 * largest_velocity_step(
        recorded, simulation.settings, 1
    )


PLACE = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3).map(np.array)
TURN = st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3).map(lambda w: pin.exp3(np.array(w)))


@given(PLACE, PLACE, TURN, TURN, st.floats(0.0, 1.0))
def test_between_two_poses(a: np.ndarray, b: np.ndarray, A: np.ndarray, B: np.ndarray, share: float) -> None:
    target = target_between(HandTarget(a, A, b), HandTarget(b, B, a), share)
    assert isinstance(target, HandTarget) and target.rotation is not None and target.elbow is not None
    assert np.allclose(target.position, (1.0 - share) * a + share * b)
    assert np.allclose(target.position + target.elbow, a + b)
    assert np.allclose(target.rotation @ target.rotation.T, np.eye(3))
    whole = float(np.linalg.norm(pin.log3(A.T @ B)))
    assert float(np.linalg.norm(pin.log3(A.T @ target.rotation))) == pytest.approx(share * whole, abs=1e-6)


@given(st.floats(0.0, 1.0))
def test_between_two_targets_of_other_kinds(share: float) -> None:
    for kind, shape in ((JointTarget, 3), (BallTarget, 3), (AnglesTarget, (2, 4))):
        target = target_between(kind(np.zeros(shape)), kind(np.ones(shape)), share)
        assert isinstance(target, kind) and np.allclose(np.array(target[0]), share)
    first = LinkTarget(4, np.ones(3), np.zeros(3))
    pulled = target_between(first, first._replace(position=np.ones(3)), share)
    assert isinstance(pulled, LinkTarget) and (pulled.joint, pulled.offset.tolist()) == (4, [1.0, 1.0, 1.0])
    assert np.allclose(pulled.position, share)
    # Another point or link is grasped at once.
    assert target_between(first, first._replace(joint=5), share) is first
    assert target_between(first, first._replace(offset=np.zeros(3)), share) is first


def test_the_paper_s_law_is_smooth_only_over_all_pairs() -> None:
    # Two seconds of the hold scene with a near hand and a change of the closest pair.
    _, recorded = recorded_run(RunSettings(), 6.0, 2.0)
    for changes, verdict in (
        ({"pairs": "soft"}, "smooth"),
        ({"pairs": "single"}, "jump"),
        ({"law": "strict_switched"}, "jump"),
    ):
        settings = given_settings(**changes)
        largest = tuple(largest_velocity_step(recorded, settings, substeps) for substeps in SUBSTEPS)
        measured = replace(unmeasured(recorded, settings), largest=largest)
        assert measured.verdict == verdict, largest
        low, high = (0.4, 0.6) if verdict == "smooth" else (0.95, 1.05)
        assert all(low < b / a < high for a, b in pairwise(largest)), largest


@pytest.mark.parametrize(
    ("largest", "verdict"),
    [
        ((0.8, 0.4, 0.2, 0.1), "smooth"), ((0.8, 0.45, 0.2, 0.12), "smooth"),
        ((0.5, 0.5, 0.5, 0.5), "jump"), ((0.5, 0.52, 0.48, 0.51), "jump"),
        # A jump of 0.1 below the smooth motion of the longer steps.
        ((0.4, 0.2, 0.105, 0.1), "jump"),
        # Measured in a window of the hold scene under `single`: small jumps that become rarer.
        ((5.977e-4, 5.145e-4, 4.027e-4, 2.444e-4), "between"),
        ((0.8, 0.4, 0.2, 0.15), "between"), ((0.0, 0.0, 0.0, 0.0), "still"),
        ((1e-14, 1e-15, 1e-14, 1e-13), "still"), ((0.0, 0.0, 0.0, 0.1), "jump"),
        ((0.1, 0.0, 0.0, 0.0), "still"), ((0.8, 0.4, None, 0.1), "measuring"),
        ((None, None, None, None), "measuring"),
    ],
)  # fmt: skip
def test_verdicts(largest: tuple[float | None, ...], verdict: StepTrend) -> None:
    assert StepStudy(RunSettings(), 10.0, tuple(0.005 / k for k in SUBSTEPS), largest).verdict == verdict
