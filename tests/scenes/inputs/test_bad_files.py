"""A file of inputs is read back with suspicion: what is wrong in it is named, and nothing in it is run."""

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.errors import BadInputFile
from scenes import inputs_file
from scenes.inputs import Recorded
from scenes.inputs_file import read_person, read_recorded, recorded_bytes, recorded_from
from scenes.packing import PackedTargets, encoded
from scenes.rerun import rerun
from scenes.settings import RunSettings
from scenes.targets import HandTarget, LinkTarget
from tests.scenes.inputs.helpers import sample_file

SAMPLE, DATA = sample_file()


def with_parts(**changes: Any) -> bytes:
    """The sample's file with some parts replaced; `about` by a dictionary of changes; None leaves a part out."""
    with np.load(io.BytesIO(DATA)) as arrays:
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


def edited(name: str, index: int, value: float) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(DATA)) as arrays:
        array = arrays[name].copy()
    array[index] = value
    return {name: array}


def test_files_that_are_wrong_as_a_whole() -> None:
    assert recorded_from(with_parts(), "a.npz").steps == SAMPLE.steps
    for rotation, fine in ((np.eye(3), True), (np.eye(3) * 1.01, False), (np.diag([1.0, 1.0, -1.0]), False)):
        code, numbers = encoded(HandTarget(np.zeros(3), rotation))
        packed = PackedTargets(np.array([code], np.uint8), np.array([1], np.uint32), np.frombuffer(numbers))
        data = recorded_bytes(Recorded(SAMPLE.snapshot, (SAMPLE.stretches[0]._replace(targets=packed),)))
        if fine:
            assert recorded_from(data, "a").steps == 1
        else:
            with pytest.raises(BadInputFile, match="orientation"):
                recorded_from(data, "a")
    # A pull at a link of the arm, at one that it has not, and at none.
    for joint, place, message in ((7, 0.0, ""), (8, 0.0, "link that no arm"), (0, 0.0, "link that no arm"), (3, 11.0, "reach")):
        code, numbers = encoded(LinkTarget(joint, np.zeros(3), np.full(3, place)))
        packed = PackedTargets(np.array([code], np.uint8), np.array([1], np.uint32), np.frombuffer(numbers))
        data = recorded_bytes(Recorded(SAMPLE.snapshot, (SAMPLE.stretches[0]._replace(targets=packed),)))
        if message:
            with pytest.raises(BadInputFile, match=message):
                recorded_from(data, "a")
        else:
            assert np.isfinite(rerun(recorded_from(data, "a")).table[:, 0]).all()
    objects = np.empty(2, object)
    objects[:] = [{"a": 1}, "b"]
    with pytest.raises(BadInputFile, match="damaged"):
        recorded_from(with_parts(numbers=objects), "a.npz")


BAD: list[tuple[dict[str, Any], str]] = [
    ({"about": {"version": 2}}, "version 2"), ({"about": {"version": "1"}}, "version"),
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
    ({"memory_1_0": None}, "damaged"),
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
def test_no_bytes_at_all_do_harm(content: bytes) -> None:
    with pytest.raises(BadInputFile):
        recorded_from(content, "a.npz")


def test_what_is_too_large_is_neither_read_nor_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    for read in (read_recorded, lambda path: read_person(path, RunSettings())):
        with pytest.raises(BadInputFile, match=r"missing\.npz: cannot be read"):
            read(tmp_path / "missing.npz")
