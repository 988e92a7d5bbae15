"""What a person wanted, step by step: kept to the last bit, forgotten in time, and done again from a log or a file."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.errors import BadInputFile
from scenes.headless import run
from scenes.inputs import CHAPTER, InputsLog, Recorded, RecordedPerson
from scenes.inputs_file import read_person, read_recorded, recorded_bytes, recorded_from
from scenes.packing import PackedTargets, decoded, encoded
from scenes.rerun import rerun
from scenes.settings import RunSettings, SceneName, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget, Target
from tests.scenes.helpers import SCENES, logged_run, scene_settings
from tests.scenes.inputs.helpers import TARGETS, arrays, everything, same, sample_file, targets


def test_whole_numbers_and_slices_are_targets_too() -> None:
    rows = np.arange(12.0).reshape(4, 3)
    code, numbers = encoded(HandTarget(np.array([1, 2, 3]), rows[:3], rows[:3, 1]))
    back = decoded(code, np.frombuffer(numbers))
    assert isinstance(back, HandTarget) and back.rotation is not None and back.elbow is not None
    assert back.position.tolist() == [1.0, 2.0, 3.0]
    assert (back.rotation == rows[:3]).all() and (back.elbow == rows[:3, 1]).all()


@given(st.lists(st.tuples(TARGETS, st.integers(1, 300)), min_size=1, max_size=8))
def test_every_step_comes_back(runs: list[tuple[Target | None, int]]) -> None:
    log, simulation = InputsLog(), Simulation(RunSettings(), 1)
    wanted = [target for target, count in runs for _ in range(count)]
    for target in wanted:
        log.record(simulation, target)
        # Only the clock goes on: an odd target need not be followed to be remembered.
        simulation.steps += 1
        simulation.time += simulation.settings.dt
    recorded = everything(log)
    assert recorded.steps == len(wanted)
    assert recorded.seconds == pytest.approx(len(wanted) * recorded.dt) == pytest.approx(log.seconds)
    assert all(same(a, b) for a, b in zip(recorded.targets(), wanted, strict=True))


def test_a_log_copies_and_forgets() -> None:
    log, simulation = InputsLog(), Simulation(RunSettings(), 1)
    place = np.array([0.4, 0.0, 1.0])
    log.record(simulation, HandTarget(place))
    simulation.step(HandTarget(place))
    place[0] = 0.5
    log.record(simulation, HandTarget(place))
    first, second = everything(log).targets()
    assert isinstance(first, HandTarget) and isinstance(second, HandTarget)
    assert first.position[0] == 0.4 and second.position[0] == 0.5
    with pytest.raises(ValueError, match="read-only"):
        first.position[0] = 1.0
    assert InputsLog().window(10.0) is None
    log = InputsLog(keep=3.0)
    logged_run(RunSettings(), 3.9, log)
    assert log.seconds == pytest.approx(3.9)
    log = InputsLog(keep=3.0)
    simulation, _ = logged_run(RunSettings(), 20.0, log)
    assert 3.0 <= log.seconds <= 3.0 + 2.0 * CHAPTER
    recorded = everything(log)
    assert recorded.seconds == pytest.approx(log.seconds)
    assert rerun(recorded).table.tobytes() == simulation.history.table(recorded.steps).tobytes()


@pytest.mark.parametrize("seconds", [0.5, 2.0, 3.3, 5.0])
def test_a_window_is_as_long_as_asked_for_or_a_little_longer(seconds: float) -> None:
    simulation, log = logged_run(RunSettings(), 6.4)
    recorded = log.window(seconds)
    assert recorded is not None
    assert seconds - 1e-9 <= recorded.seconds < seconds + CHAPTER
    assert recorded.begin == pytest.approx(simulation.time - recorded.seconds)
    assert recorded.snapshot.steps == simulation.steps - recorded.steps


def test_the_memory_of_a_log_is_bounded() -> None:
    def wander(log: InputsLog, steps: int) -> int:
        simulation, most = Simulation(RunSettings(), 1), 0
        for i in range(steps):
            log.record(simulation, HandTarget(np.array([i, 1.0, 2.0]), np.eye(3), np.array([0.0, i, 1.0])))
            simulation.steps += 1
            most = max(most, log.nbytes)
        return most

    full, bounded = InputsLog(), InputsLog(most_bytes=200_000)
    # 15 numbers, a code and a count; what is not packed yet counts for more.
    assert 5_000 * (15 * 8 + 5) < wander(full, 5_000) < 5_000 * (15 * 8 + 5) + 200_000
    assert full.nbytes >= len(pickle.dumps(everything(full))) * 0.9
    assert wander(bounded, 20_000) < 300_000
    still, simulation = InputsLog(), Simulation(RunSettings(), 1)
    for _ in range(20_000):
        still.record(simulation, HandTarget(np.zeros(3)))
        simulation.steps += 1
    assert still.seconds == pytest.approx(100.0) and still.nbytes < 100 * 5_000


@pytest.mark.parametrize("change", [{"guided": "left"}, {"scene": "master_slave"}, {"rig": "table"}, "reset"])
def test_a_log_begins_again_when_the_run_cannot_be_made_again(change: Any) -> None:
    simulation, log = logged_run(RunSettings(), 1.3)
    if change == "reset":
        simulation.reset()
    else:
        ((key, value),) = change.items()
        simulation.apply(changed(simulation.settings, key, value))
    log.record(simulation, None)
    simulation.step(None)
    recorded = everything(log)
    assert recorded.steps == 1 and log.seconds == pytest.approx(simulation.settings.dt)
    assert rerun(recorded).table.tobytes() == simulation.history.table(1).tobytes()


@pytest.mark.parametrize("scene", SCENES)
def test_a_recorded_person_does_the_same_again(scene: SceneName) -> None:
    settings = scene_settings(scene)
    simulation, log = logged_run(settings, 2.5)
    again = run(settings, 2.5, RecordedPerson(everything(log)))
    assert again.table.tobytes() == simulation.history.table().tobytes()


def test_a_recorded_person_acts_at_other_time_steps_and_rests_at_the_end() -> None:
    simulation, log = logged_run(RunSettings(), 0.2)
    simulation.apply(changed(simulation.settings, "dt", 0.02))
    for place in (1.0, 2.0):
        log.record(simulation, HandTarget(np.full(3, place)))
        simulation.step(None)
    person, wanted = RecordedPerson(everything(log)), list(everything(log).targets())
    assert len(wanted) == 42
    early = [(0.0, 0), (0.0025, 0), (0.005, 1), (0.1999, 39)]
    for time, index in [*early, (0.2, 40), (0.219, 40), (0.22, 41), (0.24, 41), (99.0, 41)]:
        assert same(person.target(time), wanted[index]), time


@pytest.mark.parametrize("scene", SCENES)
def test_a_file_brings_everything_back(scene: SceneName, tmp_path: Path) -> None:
    recorded, data = sample_file(scene)
    (tmp_path / "a.npz").write_bytes(data)
    back = read_recorded(tmp_path / "a.npz")
    assert back.settings == recorded.settings and back.steps == recorded.steps and len(back.stretches) == 2
    assert rerun(back).table.tobytes() == rerun(recorded).table.tobytes()


POSSIBLE = targets(arrays(3, -2.0, 2.0), arrays(3, -3.0, 3.0).map(pin.exp3), arrays(7, -3.0, 3.0), arrays(8, -3.0, 3.0))


@settings(max_examples=50)
@given(st.lists(st.tuples(POSSIBLE, st.integers(1, 5)), min_size=1, max_size=12))
def test_every_possible_target_goes_through_a_file(runs: list[tuple[Target | None, int]]) -> None:
    codes, numbers = zip(*(encoded(target) for target, _ in runs), strict=True)
    packed = PackedTargets(
        np.array(codes, np.uint8), np.array([count for _, count in runs], np.uint32), np.frombuffer(b"".join(numbers))
    )
    base, _ = sample_file()
    back = recorded_from(recorded_bytes(Recorded(base.snapshot, (base.stretches[0]._replace(targets=packed),))), "a.npz")
    wanted = [target for target, count in packed.runs() for _ in range(count)]
    assert all(same(a, b) for a, b in zip(back.targets(), wanted, strict=True))


def test_inputs_of_either_kind_are_a_person(tmp_path: Path) -> None:
    recorded, data = sample_file("ball")
    (tmp_path / "a.npz").write_bytes(data)
    (tmp_path / "a.csv").write_text("t,x,y,z\n0,0.4,0,1\n")
    person = read_person(tmp_path / "a.npz", recorded.settings)
    assert same(person.target(0.5), RecordedPerson(recorded).target(0.5))
    hand = read_person(tmp_path / "a.csv", RunSettings()).target(0.0)
    assert isinstance(hand, HandTarget) and hand.position.tolist() == [0.4, 0.0, 1.0]
    with pytest.raises(BadInputFile, match=r"in the scene ball, not hold; add --scene ball\."):
        read_person(tmp_path / "a.npz", RunSettings())
