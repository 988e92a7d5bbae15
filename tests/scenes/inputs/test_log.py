"""A person's targets step by step, kept and replayed to the bit; bad files are refused by name."""

import errno
import io
import json
import os
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
from scenes.inputs import CHAPTER, InputsLog, RecordedPerson
from scenes.inputs_file import read_person, read_recorded, recorded_bytes, recorded_from
from scenes.rerun import rerun
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget, JointTarget, LinkTarget, Target
from tests.approved import Approve, case_lines
from tests.scenes.helpers import SCENES, logged_run, refusal, scene_settings
from tests.scenes.inputs.helpers import (
    TARGETS,
    arrays,
    as_bytes,
    everything,
    rewritten,
    run_with,
    same,
    sample_file,
    targets,
)


@given(st.lists(st.tuples(TARGETS, st.integers(1, 300)), min_size=1, max_size=8))
def test_every_step_is_restored(runs: list[tuple[Target | None, int]]) -> None:
    log, simulation = InputsLog(), Simulation(RunSettings(), 1)
    wanted = [target for target, count in runs for _ in range(count)]
    for target in wanted:
        log.record(simulation, target)
        # Only the clock advances: the log does not need an odd target to be followed.
        simulation.steps += 1
        simulation.time += simulation.settings.dt
    recorded = everything(log)
    assert recorded.steps == len(wanted)
    assert recorded.seconds == pytest.approx(len(wanted) * recorded.settings.dt)
    assert all(same(a, b) for a, b in zip(recorded.targets(), wanted, strict=True))


def test_a_log_copies_its_inputs_and_drops_old_ones() -> None:
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
    assert everything(log).seconds == pytest.approx(3.9)
    log = InputsLog(keep=3.0)
    simulation, _ = logged_run(RunSettings(), 20.0, log)
    recorded = everything(log)
    assert 3.0 <= recorded.seconds <= 3.0 + 2.0 * CHAPTER
    assert rerun(recorded).table.tobytes() == simulation.history.table(recorded.steps).tobytes()


@pytest.mark.parametrize("seconds", [0.5, 2.0, 3.3, 5.0])
def test_a_window_has_the_wanted_length_or_slightly_more(seconds: float) -> None:
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
    # 15 numbers, a code and a count; unpacked steps need more.
    assert 5_000 * (15 * 8 + 5) < wander(full, 5_000) < 5_000 * (15 * 8 + 5) + 200_000
    assert full.nbytes >= len(pickle.dumps(everything(full))) * 0.9
    assert wander(bounded, 20_000) < 300_000
    still, simulation = InputsLog(), Simulation(RunSettings(), 1)
    for _ in range(20_000):
        still.record(simulation, HandTarget(np.zeros(3)))
        simulation.steps += 1
    assert everything(still).seconds == pytest.approx(100.0) and still.nbytes < 100 * 5_000


@pytest.mark.parametrize("change", [{"guided": "left"}, {"scene": "master_slave"}, {"rig": "table"}, "reset"])
def test_a_log_restarts_when_the_run_becomes_irreproducible(change: Any) -> None:
    simulation, log = logged_run(RunSettings(), 1.3)
    if change == "reset":
        simulation.reset()
    else:
        ((key, value),) = change.items()
        simulation.apply(changed(simulation.settings, key, value))
    log.record(simulation, None)
    simulation.step(None)
    recorded = everything(log)
    assert recorded.steps == 1 and recorded.seconds == pytest.approx(simulation.settings.dt)
    assert rerun(recorded).table.tobytes() == simulation.history.table(1).tobytes()


@pytest.mark.parametrize("scene", SCENES)
def test_a_recorded_person_repeats_the_run(scene: str) -> None:
    settings = scene_settings(scene)
    simulation, log = logged_run(settings, 2.5)
    again = run(settings, 2.5, RecordedPerson(everything(log)))
    assert again.table.tobytes() == simulation.history.table().tobytes()


def test_a_recorded_person_works_at_other_time_steps_and_rests_at_the_end() -> None:
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


POSSIBLE = targets(
    arrays(3, -2.0, 2.0), arrays(3, -3.0, 3.0).map(pin.exp3), arrays(7, -3.0, 3.0), arrays(8, -3.0, 3.0)
)


@settings(max_examples=50)
@given(st.lists(st.tuples(POSSIBLE, st.integers(1, 5)), min_size=1, max_size=12))
def test_every_possible_target_survives_a_file(runs: list[tuple[Target | None, int]]) -> None:
    made = run_with(*runs)
    back = recorded_from(recorded_bytes(made), "a.npz")
    assert all(same(a, b) for a, b in zip(back.targets(), made.targets(), strict=True))


def test_inputs_of_both_kinds_are_read_as_a_person(tmp_path: Path) -> None:
    recorded, data = sample_file("ball")
    (tmp_path / "a.npz").write_bytes(data)
    (tmp_path / "a.csv").write_text("t,x,y,z\n0,0.4,0,1\n")
    person = read_person(tmp_path / "a.npz", recorded.settings)
    assert same(person.target(0.5), RecordedPerson(recorded).target(0.5))
    hand = read_person(tmp_path / "a.csv", RunSettings()).target(0.0)
    assert isinstance(hand, HandTarget) and hand.position.tolist() == [0.4, 0.0, 1.0]
    with pytest.raises(BadInputFile, match=r"--scene ball\."):
        read_person(tmp_path / "a.npz", RunSettings())


@pytest.mark.parametrize(
    "target", [JointTarget(np.zeros(7)), LinkTarget(7, np.zeros(3), np.array([0.4, 0.0, 1.0]))]
)
def test_joints_of_other_arms_are_refused(tmp_path: Path, target: Target) -> None:
    (tmp_path / "a.npz").write_bytes(recorded_bytes(run_with((target, 9))))
    assert same(read_person(tmp_path / "a.npz", RunSettings()).target(0.0), target)
    with pytest.raises(BadInputFile, match="--robot lwr --guided right"):
        read_person(tmp_path / "a.npz", RunSettings(robot="ur5"))


SAMPLE, DATA = sample_file()


def with_parts(**changes: Any) -> bytes:
    """The sample's file with some parts replaced; `about` by a dictionary of changes; None removes a part."""
    if isinstance(about := changes.get("about"), dict):
        with np.load(io.BytesIO(DATA)) as arrays:
            changes["about"] = as_bytes(json.dumps(json.loads(arrays["about"].tobytes()) | about))
    return rewritten(DATA, **changes)


def edited(name: str, index: int, value: float) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(DATA)) as arrays:
        array = arrays[name].copy()
    array[index] = value
    return {name: array}


def test_wrong_targets_and_damaged_files_are_refused() -> None:
    assert recorded_from(with_parts(), "a.npz").steps == SAMPLE.steps
    turns = (np.eye(3), ""), (np.eye(3) * 1.01, "orientation"), (np.diag([1.0, 1.0, -1.0]), "orientation")
    # A pull at the last link, at two missing ones, and one out of reach.
    pulls = (7, 0.0, ""), (8, 0.0, "link that no arm"), (0, 0.0, "link that no arm"), (3, 11.0, "reach")
    for target, message in (
        *((HandTarget(np.zeros(3), rotation), message) for rotation, message in turns),
        *((LinkTarget(joint, np.zeros(3), np.full(3, place)), message) for joint, place, message in pulls),
        (JointTarget(np.zeros(5)), "moves joints that the arm does not have"),
    ):
        data = recorded_bytes(run_with((target, 1)))
        if message:
            with pytest.raises(BadInputFile, match=message):
                recorded_from(data, "a")
        else:
            table = rerun(recorded_from(data, "a")).table
            assert len(table) == 1 and np.isfinite(table[:, 0]).all()
    objects = np.empty(2, object)
    objects[:] = [{"a": 1}, "b"]
    # The library's own message would be English.
    for data in (with_parts(numbers=objects), with_parts()[:500]):
        with pytest.raises(BadInputFile, match=r"^a\.npz: .*damaged\.$"):
            recorded_from(data, "a.npz")


BAD: list[tuple[dict[str, Any], str]] = [
    ({"about": {"version": 3}}, "version 3"), ({"about": {"version": "1"}}, "version"),
    ({"about": {"format": "something else"}}, "not a file of recorded inputs"),
    ({"about": {"settings": {"scene": "circus"}}}, "scene = 'circus'"), ({"about": {"settings": {"dm": 7.0}}}, "dm = 7"),
    ({"about": {"settings": {"volume": 11}}}, "no setting 'volume'"), ({"about": {"settings": []}}, "no settings"),
    ({"about": {"changes": []}}, "settings that do not fit"), ({"about": {"changes": [{"scene": "solo"}]}}, "changes scene"),
    ({"about": {"changes": [7]}}, "damaged"), ({"about": {"settings": {"scene": "solo"}}}, "of other arms"),
    ({"about": {"settings": {"scene": "master_slave"}}}, "another experiment"),
    *(({"about": about}, "impossible time") for about in ({"time": -1.0}, {"steps": 1.5})),
    ({"about": {"memories": [1]}}, "another experiment"), ({"about": np.zeros(3, np.uint8)}, "damaged"),
    ({"codes": None}, "part is missing"), (edited("codes", 0, 200), "unknown kind"),
    (edited("codes", 0, 16 + 2), "missing numbers"),
    *((edited("counts", 0, count), "number of steps") for count in (0, 4_000_000_000)),
    *((edited("numbers", 3, number), "not finite") for number in (np.nan, np.inf)),
    (edited("numbers", 3, 1e3), "out of any reach"), ({"numbers": np.zeros(2)}, "missing numbers"),
    ({"numbers": np.zeros((2, 2))}, "wrong number"), ({"numbers": np.zeros(4, np.float32)}, "wrong type"),
    ({"lengths": np.array([1], np.uint32)}, "fit"), ({"lengths": np.array([], np.uint32)}, "stretches"),
    ({"lengths": np.array([-1, 2])}, "lengths"),
    *((edited("positions", 0, position), "impossible posture") for position in (np.nan, 100.0)),
    (edited("velocities", 0, 1e9), "impossible posture"), ({"positions": np.zeros(3)}, "other arms"),
    ({"memory_0_0": np.zeros(99)}, "another experiment"), ({"memory_1_0": np.full(3, np.nan)}, "impossible number"),
    ({"memory_1_0": None}, "part memory_1_0 is missing"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), BAD, ids=[f"{i}-{m}" for i, (_, m) in enumerate(BAD)])
def test_a_wrong_part_is_refused_and_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInputFile, match=message) as caught:
        recorded_from(with_parts(**changes), "a.npz")
    assert str(caught.value).startswith("a.npz: ") and "\n" not in str(caught.value)


@settings(max_examples=60)
@given(st.data())
def test_a_damaged_file_is_refused_or_still_a_possible_run(data: st.DataObject) -> None:
    content = bytearray(DATA)
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
def test_arbitrary_bytes_are_refused(content: bytes) -> None:
    with pytest.raises(BadInputFile):
        recorded_from(content, "a.npz")


def test_a_file_that_is_too_large_is_neither_read_nor_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("numbers.npy", bytes(3_000_000))
    assert len(out.getvalue()) < 10_000
    monkeypatch.setattr(inputs_file, "LARGEST_CONTENT", 1_000_000)
    with pytest.raises(BadInputFile, match="unpacks to more"):
        recorded_from(out.getvalue(), "a.npz")
    (tmp_path / "a.npz").write_bytes(DATA)
    monkeypatch.setattr(inputs_file, "LARGEST_FILE", 100)
    for read in (lambda: read_recorded(tmp_path / "a.npz"), lambda: recorded_from(DATA, "a.npz")):
        with pytest.raises(BadInputFile, match="larger than"):
            read()


def test_a_missing_file_is_refused_by_name(tmp_path: Path) -> None:
    for read in (read_recorded, lambda path: read_person(path, RunSettings())):
        with pytest.raises(BadInputFile, match=r"missing\.npz: "):
            read(tmp_path / "missing.npz")


def test_messages_of_files_that_do_not_fit(tmp_path: Path, approve: Approve) -> None:
    (tmp_path / "ball.npz").write_bytes(sample_file("ball")[1])
    (tmp_path / "joints.npz").write_bytes(recorded_bytes(run_with((JointTarget(np.zeros(7)), 9))))
    said = {
        "another scene": refusal(lambda: read_person(tmp_path / "ball.npz", RunSettings())),
        "other arms": refusal(lambda: read_person(tmp_path / "joints.npz", RunSettings(robot="ur5"))),
        "damaged": refusal(lambda: recorded_from(with_parts()[:500], "a.npz")),
        "missing": refusal(lambda: read_recorded(tmp_path / "missing.npz")),
    }
    approve(
        "refusals.txt", case_lines(said).replace(str(tmp_path), "…").replace(os.strerror(errno.ENOENT), "…")
    )
