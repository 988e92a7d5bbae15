"""What a person wanted, step by step: kept to the last bit, forgotten in time, written to a file and read back with suspicion."""

from __future__ import annotations

import io
import json
import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.errors import BadInputFile
from scenes import inputs_file
from scenes.headless import run
from scenes.inputs import CHAPTER, InputsLog, Recorded, RecordedPerson
from scenes.inputs_file import read_person, read_recorded, recorded_bytes, recorded_from, write_recorded
from scenes.packing import PackedTargets, decoded, encoded
from scenes.rerun import rerun
from scenes.settings import RunSettings, SceneName, changed
from scenes.simulation import Simulation
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget, Target

SCENES: tuple[SceneName, ...] = ("solo", "ball", "hold", "master_slave", "imitation")
NUMBER = st.floats(allow_nan=False, width=64)


def arrays(count: int) -> st.SearchStrategy[np.ndarray]:
    """`count` numbers, of any size and sign."""
    return st.lists(NUMBER, min_size=count, max_size=count).map(np.array)


def turned(way: np.ndarray) -> np.ndarray:
    """The same numbers, laid out column by column."""
    return way.reshape(3, 3).T


TARGETS: st.SearchStrategy[Target | None] = st.one_of(
    st.none(),
    st.builds(
        HandTarget,
        arrays(3),
        st.none() | arrays(9).map(lambda a: a.reshape(3, 3)) | arrays(9).map(turned),
        st.none() | arrays(3),
    ),
    st.builds(JointTarget, st.integers(1, 14).flatmap(arrays)),
    st.builds(BallTarget, arrays(3)),
    st.builds(AnglesTarget, st.none() | arrays(8).map(lambda a: a.reshape(2, 4))),
)


def same(a: Target | None, b: Target | None) -> bool:
    """Whether two targets are the same to the last bit, layout in memory included."""
    if a is None or b is None:
        return a is b
    if type(a) is not type(b) or len(a) != len(b):
        return False
    for x, y in zip(a, b, strict=True):
        if x is None or y is None:
            if x is not y:
                return False
        elif x.tobytes("A") != y.tobytes("A") or x.shape != y.shape or x.flags.fnc != y.flags.fnc:
            return False
    return True


def scene_settings(scene: SceneName, **changes: object) -> RunSettings:
    """The default settings in a scene."""
    settings = changed(RunSettings(), "scene", scene)
    for key, value in ({"ball": "cross"} if scene == "ball" else {} | changes).items():
        settings = changed(settings, key, value)
    return settings


def recorded_run(settings: RunSettings, seconds: float, log: InputsLog | None = None) -> tuple[Simulation, InputsLog]:
    """A run with the experiment's own person, and the log of it."""
    simulation, log = Simulation(settings), log or InputsLog()
    person = simulation.person()
    for _ in range(round(seconds / settings.dt)):
        target = person.target(simulation.time)
        log.record(simulation, target)
        simulation.step(target)
    return simulation, log


def everything(log: InputsLog) -> Recorded:
    """All that is in a log."""
    recorded = log.window(1e9)
    assert recorded is not None
    return recorded


# --- one target ----------------------------------------------------------------------------------------------------------------


@given(TARGETS)
def test_a_target_comes_back_to_the_last_bit(target: Target | None) -> None:
    code, numbers = encoded(target)
    assert same(decoded(code, np.frombuffer(numbers)), target)


def test_whole_numbers_and_slices_are_targets_too() -> None:
    rows = np.arange(12.0).reshape(4, 3)
    code, numbers = encoded(HandTarget(np.array([1, 2, 3]), rows[:3], rows[:3, 1]))
    back = decoded(code, np.frombuffer(numbers))
    assert isinstance(back, HandTarget) and back.rotation is not None and back.elbow is not None
    assert back.position.tolist() == [1.0, 2.0, 3.0]
    assert (back.rotation == rows[:3]).all() and (back.elbow == rows[:3, 1]).all()


_still = Simulation(RunSettings(), 1)
"""Of which only the clock is used."""


# --- the log -------------------------------------------------------------------------------------------------------------------


@given(st.lists(st.tuples(TARGETS, st.integers(1, 300)), min_size=1, max_size=8))
def test_every_step_comes_back(runs: list[tuple[Target | None, int]]) -> None:
    log, simulation = InputsLog(), _still
    simulation.reset()
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


def test_what_was_recorded_does_not_change_with_the_callers_arrays() -> None:
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


@pytest.mark.parametrize("seconds", [0.5, 2.0, 3.3, 5.0])
def test_a_window_is_as_long_as_asked_for_or_a_little_longer(seconds: float) -> None:
    simulation, log = recorded_run(RunSettings(), 6.4)
    recorded = log.window(seconds)
    assert recorded is not None
    assert seconds - 1e-9 <= recorded.seconds < seconds + CHAPTER
    assert recorded.begin == pytest.approx(simulation.time - recorded.seconds)
    assert recorded.snapshot.steps == simulation.steps - recorded.steps


def test_there_is_no_window_before_the_first_step() -> None:
    assert InputsLog().window(10.0) is None


def test_a_recording_is_plain_data() -> None:
    _, log = recorded_run(scene_settings("imitation"), 1.5)
    recorded = everything(log)
    again = pickle.loads(pickle.dumps(recorded))
    assert all(same(a, b) for a, b in zip(again.targets(), recorded.targets(), strict=True))
    assert rerun(again).table.tobytes() == rerun(recorded).table.tobytes()


def test_the_oldest_is_forgotten_but_never_too_soon() -> None:
    log = InputsLog(keep=3.0)
    recorded_run(RunSettings(), 3.9, log)
    assert log.seconds == pytest.approx(3.9)
    log = InputsLog(keep=3.0)
    simulation, _ = recorded_run(RunSettings(), 20.0, log)
    assert 3.0 <= log.seconds <= 3.0 + 2.0 * CHAPTER
    recorded = everything(log)
    assert recorded.seconds == pytest.approx(log.seconds)
    assert rerun(recorded).table.tobytes() == simulation.history.table(recorded.steps).tobytes()


def test_memory_is_bounded_and_told() -> None:
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
    # Somebody who holds still costs next to nothing.
    still, simulation = InputsLog(), Simulation(RunSettings(), 1)
    for _ in range(20_000):
        still.record(simulation, HandTarget(np.zeros(3)))
        simulation.steps += 1
    assert still.seconds == pytest.approx(100.0) and still.nbytes < 100 * 5_000


def test_a_log_keeps_the_settings_as_they_changed() -> None:
    settings = RunSettings()
    simulation, log = Simulation(settings), InputsLog()
    person = simulation.person()
    history = []
    for i in range(700):
        if i in (120, 121, 500):
            settings = changed(changed(settings, "dm", 0.10 + i / 10_000), "k", 1.0 + i / 1000)
            simulation.apply(settings)
        if i == 300:
            simulation.apply(changed(settings, "n", 3.0))
            simulation.apply(settings)  # there and back between two steps: nothing has happened
        history.append(settings)
        target = person.target(simulation.time)
        log.record(simulation, target)
        simulation.step(target)
    recorded = everything(log)
    kept = [stretch.settings for stretch in recorded.stretches for _ in range(stretch.targets.steps)]
    assert kept == history
    assert len(recorded.stretches) == 4


@pytest.mark.parametrize("change", [{"guided": "left"}, {"scene": "master_slave"}, {"rig": "table"}, "reset"])
def test_a_log_begins_anew_when_the_run_cannot_be_made_again(change: Any) -> None:
    simulation, log = recorded_run(RunSettings(), 1.3)
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


# --- somebody who does it again ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", SCENES)
def test_a_recorded_person_does_the_same_again(scene: SceneName) -> None:
    settings = scene_settings(scene)
    simulation, log = recorded_run(settings, 2.5)
    again = run(settings, 2.5, RecordedPerson(everything(log)))
    assert again.table.tobytes() == simulation.history.table().tobytes()


def test_a_recorded_person_acts_at_other_time_steps_and_rests_at_the_end() -> None:
    simulation, log = recorded_run(RunSettings(), 0.2)
    simulation.apply(changed(simulation.settings, "dt", 0.02))
    for place in (1.0, 2.0):
        log.record(simulation, HandTarget(np.full(3, place)))
        simulation.step(None)
    person, targets = RecordedPerson(everything(log)), list(everything(log).targets())
    assert len(targets) == 42
    for time, index in (
        (0.0, 0),
        (0.0025, 0),
        (0.005, 1),
        (0.1999, 39),
        (0.2, 40),
        (0.219, 40),
        (0.22, 41),
        (0.24, 41),
        (99.0, 41),
    ):
        assert same(person.target(time), targets[index]), time


# --- the file ------------------------------------------------------------------------------------------------------------------


def sample_file(scene: SceneName = "hold", seconds: float = 1.3) -> tuple[Recorded, bytes]:
    """Recorded inputs with a change of settings in their middle, and their file."""
    simulation, log = recorded_run(scene_settings(scene), seconds)
    simulation.apply(changed(simulation.settings, "k", 3.0))
    for _ in range(30):
        log.record(simulation, None)
        simulation.step(None)
    return everything(log), recorded_bytes(everything(log))


@pytest.mark.parametrize("scene", SCENES)
def test_a_file_brings_everything_back(scene: SceneName, tmp_path: Path) -> None:
    recorded, data = sample_file(scene)
    write_recorded(recorded, tmp_path / "a.npz")
    assert (tmp_path / "a.npz").read_bytes() == data
    back = read_recorded(tmp_path / "a.npz")
    assert back.settings == recorded.settings and back.steps == recorded.steps and len(back.stretches) == 2
    assert rerun(back).table.tobytes() == rerun(recorded).table.tobytes()


def within(low: float, high: float, count: int) -> st.SearchStrategy[np.ndarray]:
    """`count` numbers of a range."""
    return st.lists(st.floats(low, high), min_size=count, max_size=count).map(np.array)


ROTATION = within(-3.0, 3.0, 3).map(pin.exp3)
POSSIBLE: st.SearchStrategy[Target | None] = st.one_of(
    st.none(),
    st.builds(
        HandTarget, within(-2.0, 2.0, 3), st.none() | ROTATION | ROTATION.map(np.asfortranarray), st.none() | within(-2.0, 2.0, 3)
    ),
    st.builds(JointTarget, within(-3.0, 3.0, 7)),
    st.builds(BallTarget, within(-2.0, 2.0, 3)),
    st.builds(AnglesTarget, st.none() | within(-3.0, 3.0, 8).map(lambda a: a.reshape(2, 4))),
)


@settings(max_examples=50)
@given(st.lists(st.tuples(POSSIBLE, st.integers(1, 5)), min_size=1, max_size=12))
def test_every_possible_target_goes_through_a_file(runs: list[tuple[Target | None, int]]) -> None:
    codes, numbers = zip(*(encoded(target) for target, _ in runs), strict=True)
    packed = PackedTargets(
        np.array(codes, np.uint8), np.array([count for _, count in runs], np.uint32), np.frombuffer(b"".join(numbers))
    )
    base = sample()
    back = recorded_from(recorded_bytes(Recorded(base.snapshot, (base.stretches[0]._replace(targets=packed),))), "a.npz")
    assert all(same(a, b) for a, b in zip(back.targets(), packed_steps(packed), strict=True))


def packed_steps(packed: PackedTargets) -> list[Target | None]:
    """Its targets, one a step."""
    return [target for target, count in packed.runs() for _ in range(count)]


_samples: dict[str, tuple[Recorded, bytes]] = {}


def sample() -> Recorded:
    """Recorded inputs that are shared by several tests; only to be read."""
    return _samples.setdefault("hold", sample_file())[0]


def sample_data() -> bytes:
    """Their file."""
    return _samples.setdefault("hold", sample_file())[1]


def with_parts(**changes: Any) -> bytes:
    """The sample's file with some parts replaced; `about` by a dictionary of changes; None leaves a part out."""
    with np.load(io.BytesIO(sample_data())) as arrays:
        parts = {name: arrays[name] for name in arrays.files}
    for name, value in changes.items():
        if name == "about" and isinstance(value, dict):
            about = json.loads(parts["about"].tobytes()) | value
            value = np.frombuffer(json.dumps(about).encode(), np.uint8)
        if value is None:
            del parts[name]
        else:
            parts[name] = value
    out = io.BytesIO()
    np.savez(out, **parts)
    return out.getvalue()


def part(name: str) -> np.ndarray:
    """A copy of a part of the sample's file."""
    with np.load(io.BytesIO(sample_data())) as arrays:
        return arrays[name].copy()


def edited(name: str, index: int, value: float) -> dict[str, np.ndarray]:
    """A part with one number replaced."""
    array = part(name)
    array[index] = value
    return {name: array}


def test_positive_control_an_unchanged_file_is_read() -> None:
    assert recorded_from(with_parts(), "a.npz").steps == sample().steps


SETTINGS = {"scene": "hold"}
BAD: list[tuple[dict[str, Any], str]] = [
    ({"about": {"version": 2}}, "version 2"),
    ({"about": {"version": "1"}}, "version"),
    ({"about": {"format": "something else"}}, "not a file of recorded inputs"),
    ({"about": {"settings": {"scene": "circus"}}}, "scene = 'circus'"),
    ({"about": {"settings": {"dm": 7.0}}}, "dm = 7"),
    ({"about": {"settings": {"volume": 11}}}, "no setting 'volume'"),
    ({"about": {"settings": []}}, "no settings"),
    ({"about": {"changes": []}}, "settings that do not fit"),
    ({"about": {"changes": [{"scene": "solo"}]}}, "changes scene"),
    ({"about": {"changes": [7]}}, "damaged"),
    ({"about": {"settings": {"scene": "solo"}}}, "of other arms"),
    ({"about": {"settings": {"scene": "master_slave"}}}, "another experiment"),
    ({"about": {"time": -1.0}}, "impossible time"),
    ({"about": {"steps": 1.5}}, "impossible time"),
    ({"about": {"memories": [1]}}, "another experiment"),
    ({"about": np.zeros(3, np.uint8)}, "damaged"),
    ({"codes": None}, "part is missing"),
    (edited("codes", 0, 200), "unknown kind"),
    (edited("codes", 0, 16 + 2), "numbers are missing"),
    (edited("counts", 0, 0), "number of steps"),
    (edited("counts", 0, 4_000_000_000), "number of steps"),
    (edited("numbers", 3, np.nan), "not finite"),
    (edited("numbers", 3, np.inf), "not finite"),
    (edited("numbers", 3, 1e3), "out of any reach"),
    ({"numbers": np.zeros(2)}, "numbers are missing"),
    ({"numbers": np.zeros((2, 2))}, "wrong number"),
    ({"numbers": np.zeros(4, np.float32)}, "wrong type"),
    ({"lengths": np.array([1], np.uint32)}, "fit"),
    ({"lengths": np.array([], np.uint32)}, "stretches"),
    ({"lengths": np.array([-1, 2])}, "lengths"),
    (edited("positions", 0, np.nan), "impossible posture"),
    (edited("positions", 0, 100.0), "impossible posture"),
    (edited("velocities", 0, 1e9), "impossible posture"),
    ({"positions": np.zeros(3)}, "other arms"),
    ({"memory_0_0": np.zeros(99)}, "another experiment"),
    ({"memory_1_0": np.full(3, np.nan)}, "impossible number"),
    ({"memory_1_0": None}, "damaged"),
]


@pytest.mark.parametrize(("changes", "message"), BAD, ids=[f"{i}-{m}" for i, (_, m) in enumerate(BAD)])
def test_a_wrong_part_is_refused_and_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInputFile, match=message) as caught:
        recorded_from(with_parts(**changes), "a.npz")
    assert str(caught.value).startswith("a.npz: ") and "\n" not in str(caught.value)


def test_an_orientation_that_is_none_is_refused() -> None:
    base = sample()
    for rotation, fine in ((np.eye(3), True), (np.eye(3) * 1.01, False), (np.diag([1.0, 1.0, -1.0]), False)):
        code, numbers = encoded(HandTarget(np.zeros(3), rotation))
        packed = PackedTargets(np.array([code], np.uint8), np.array([1], np.uint32), np.frombuffer(numbers))
        data = recorded_bytes(Recorded(base.snapshot, (base.stretches[0]._replace(targets=packed),)))
        if fine:
            assert recorded_from(data, "a").steps == 1
        else:
            with pytest.raises(BadInputFile, match="orientation"):
                recorded_from(data, "a")


@settings(max_examples=60)
@given(st.data())
def test_a_damaged_file_is_refused_or_still_a_possible_run(data: st.DataObject) -> None:
    content = bytearray(sample_data())
    cut = data.draw(st.integers(0, len(content)))
    for _ in range(data.draw(st.integers(0, 3))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    damaged = bytes(content[: data.draw(st.sampled_from([cut, len(content)]))])
    try:
        recorded = recorded_from(damaged, "a.npz")
    except BadInputFile as error:
        assert "\n" not in str(error)
    else:
        assert np.isfinite(rerun(recorded).table[:, 0]).all()


@given(st.binary(max_size=300))
def test_no_bytes_at_all_do_harm(content: bytes) -> None:
    with pytest.raises(BadInputFile):
        recorded_from(content, "a.npz")


def test_nothing_in_a_file_is_run() -> None:
    objects = np.empty(2, object)
    objects[:] = [{"a": 1}, "b"]
    with pytest.raises(BadInputFile, match="damaged"):
        recorded_from(with_parts(numbers=objects), "a.npz")


def test_what_unpacks_to_too_much_is_not_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("numbers.npy", bytes(3_000_000))
    assert len(out.getvalue()) < 10_000
    monkeypatch.setattr(inputs_file, "LARGEST_CONTENT", 1_000_000)
    with pytest.raises(BadInputFile, match="unpacks to more"):
        recorded_from(out.getvalue(), "a.npz")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.npz").write_bytes(sample_data())
    monkeypatch.setattr(inputs_file, "LARGEST_FILE", 100)
    with pytest.raises(BadInputFile, match="larger than"):
        read_recorded(tmp_path / "a.npz")
    with pytest.raises(BadInputFile, match="larger than"):
        recorded_from(sample_data(), "a.npz")


def test_a_file_that_is_not_there_and_one_that_cannot_be_written(tmp_path: Path) -> None:
    for read in (read_recorded, lambda path: read_person(path, RunSettings())):
        with pytest.raises(BadInputFile, match=r"missing\.npz: cannot be read"):
            read(tmp_path / "missing.npz")
    with pytest.raises(BadInputFile, match="cannot be written"):
        write_recorded(sample(), tmp_path / "nowhere" / "a.npz")


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
