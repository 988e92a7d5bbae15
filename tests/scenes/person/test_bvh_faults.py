"""Whatever is wrong with a BVH file, one line says what and where, and nothing else happens."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.errors import BadInputFile, DuetError
from scenes.person import bvh_file
from scenes.person.bvh import read_bvh
from scenes.person.clips import Clip
from tests.scenes.person.bvh_text import MIXAMO, write_bvh

GOOD = write_bvh(Clip("wave", 1), MIXAMO, frames=4)
LINES = GOOD.splitlines()
ROW = next(i for i, line in enumerate(LINES) if line.startswith("Frame Time")) + 1


def refused(source: Path | str | bytes, *words: str) -> None:
    with pytest.raises(BadInputFile) as caught:
        read_bvh(source)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 500 + len(str(source)) * isinstance(source, (Path, str))
    for word in words:
        assert word in text, text


def with_line(index: int, line: str) -> str:
    return "\n".join([*LINES[:index], line, *LINES[index + 1 :]])


NUMBERS = LINES[ROW + 1].split()


def test_no_person_in_it() -> None:
    assert len(read_bvh(GOOD).table) == 4
    # Without thighs, hips or a spine it is not known where up is.
    text = GOOD
    for old, new in (("LeftUpLeg", "a"), ("RightUpLeg", "b"), ("Hips", "c"), ("Spine", "d")):
        text = text.replace(f"mixamorig:{old}", new)
    refused(text, "no hips")
    # A skeleton whose joints all lie in one place is none.
    text = "\n".join("OFFSET 0 0 0" if line.startswith("OFFSET") else line for line in LINES)
    refused(text, "in no frame")
    # A small file that promises many frames of many channels takes no memory for them.
    joints = "JOINT a\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation\n" * 400
    head = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n" + joints + "}\n" * 401
    text = f"{head}MOTION\nFrames: 100000\nFrame Time: 0.01\n" + "1\n" * 100_000
    tracemalloc.start()
    try:
        refused(text, "numbers stand here")
        assert tracemalloc.get_traced_memory()[1] < 100_000_000
    finally:
        tracemalloc.stop()


ROOT = "HIERARCHY\nROOT Hips\n{\n"
FIVE = ROOT + "OFFSET 0 0 0\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *((text, ("line 1", "HIERARCHY")) for text in ("", " ", "\n")),
        ("time,x,y\n1,2,3\n", ("line 1", "not a BVH file", "HIERARCHY")),
        ("HIERARCHY\n", ("line 1", "ends where ROOT or MOTION is due")),
        ("HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 0.1\n1\n", ("line 5", "1 numbers", "0 channels")),
        ("HIERARCHY\nROOT\n{\n", ("line 2", "ROOT and a name")),
        ("HIERARCHY\nROOT Hips\nOFFSET 0 0 0\n", ("line 3", "{ is missing")),
        (ROOT + "OFFSET 0 0\n", ("line 4", "OFFSET and 3 numbers")),
        (ROOT + "OFFSET 0 x 0\nCHANNELS 1 Xrotation\n", ("line 5", "'x' is not a number")),
        (ROOT + "OFFSET 0 0 nan\nCHANNELS 1 Xrotation\n", ("'nan' is not a finite number",)),
        (ROOT + "OFFSET 0 0 1e9\nCHANNELS 1 Xrotation\n", ("'1e9' is not believable",)),
        (FIVE + "CHANNELS 2 Xrotation\n", ("line 5", "CHANNELS needs their number")),
        (FIVE + "CHANNELS 2 Xrotation Xrotation\n", ("line 5", "different names")),
        (FIVE + "CHANNELS 1 Wrotation\n", ("line 5", "Xposition … Zrotation")),
        (FIVE + "CHANNELS 0\nROTATE\n", ("line 6", "'ROTATE'")),
        (FIVE + "CHANNELS 1 Xrotation\nJOIN a\n", ("line 6", "'JOIN a'", "JOINT and a name")),
        (with_line(ROW - 2, "Frames: 5"), ("4 frames follow, but Frames: says 5", "export it again")),
        (with_line(ROW - 2, "Frames: 3"), ("4 frames follow, but Frames: says 3",)),
        *((with_line(ROW - 2, f"Frames: {count}"), (f"line {ROW - 1}", "1 to 100000")) for count in (0, 999999999)),
        *((with_line(ROW - 2, f"Frames: {count}"), (f"line {ROW - 1}", "whole number")) for count in (-4, 9999999999999999)),
        (with_line(ROW - 2, "Frame 5"), (f"line {ROW - 1}", "Frames:")),
        (with_line(ROW - 1, "Frame Time: 0"), (f"line {ROW}", "not believable")),
        (with_line(ROW - 1, "Frame Time: inf"), (f"line {ROW}", "not a finite number")),
        (with_line(ROW - 1, "Time: 0.1"), (f"line {ROW}", "Frame Time:")),
        (with_line(ROW + 1, " ".join([*NUMBERS, "3"])), (f"line {ROW + 2}", "numbers stand here")),
        (with_line(ROW + 1, " ".join(NUMBERS[:-1])), (f"line {ROW + 2}", "numbers stand here")),
        (with_line(ROW + 1, " ".join(["zero", *NUMBERS[1:]])), (f"line {ROW + 2}", "is not a number")),
        (with_line(ROW + 2, " ".join(["nan", *NUMBERS[1:]])), (f"line {ROW + 3}", "'nan'")),
        (with_line(ROW + 2, " ".join([*NUMBERS[1:], "-1e300"])), (f"line {ROW + 3}", "'-1e300'", "not believable")),
        *(("\n".join(LINES[:keep]) + "\n", ("line ",)) for keep in (1, 5, 20, ROW - 3, ROW - 2, ROW - 1, ROW, ROW + 2)),
        (GOOD.replace(":LeftForeArm", ":LeftThing"), ("no left elbow", "'mixamorig:Hips'", "L_LowerArm")),
        (GOOD.replace(":RightForeArm", ":Elbow"), ("no right elbow",)),
        (GOOD.replace(":RightArm", ":RightClavicle"), ("no right upper arm",)),
        (GOOD.replace(":LeftArm", ":Chest"), ("no left upper arm",)),
    ],
)
def test_a_fault_is_named_with_its_line_what_is_due_and_the_remedy(text: str, words: tuple[str, ...]) -> None:
    refused(text, *words)


def test_bad_files(tmp_path: Path) -> None:
    refused(tmp_path / "none.bvh", "none.bvh", "no such file")
    refused(str(tmp_path / "none.bvh"), "no such file")
    refused(tmp_path, "cannot be read", "a folder")
    refused(Path("/dev/zero"), "cannot be read", "a device")
    picture = tmp_path / "a.bvh"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff" * 50)
    refused(picture, "not a BVH file")
    refused("a\0b", "no such file")
    refused("a" * 5000, "cannot be read", "too long")


def test_too_large(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "big.bvh"
    path.write_text(GOOD)
    monkeypatch.setattr(bvh_file, "MOST_BYTES", 100)
    for source in (path, GOOD, GOOD.encode()):
        refused(source, "larger than", "fewer frames")
    monkeypatch.undo()
    refused("\n" * (bvh_file.MOST_LINES + 1), "lines")
    deep = "HIERARCHY\nROOT a\n" + "{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nJOINT a\n" * (bvh_file.MOST_JOINTS + 1)
    refused(deep, "more than 500 joints")


@given(st.binary(max_size=400))
def test_any_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(DuetError):
        read_bvh(data)


WORDS = ["ROOT Hips", "JOINT LeftArm", "End Site", "{", "}", "OFFSET 1 2 3", "CHANNELS 1 Xrotation"]
WORDS += ["MOTION", "Frames: 1", "1", "Frame Time: 1"]


@given(st.lists(st.sampled_from(WORDS), max_size=40))
def test_words_of_the_format_in_any_order_are_refused(found: list[str]) -> None:
    with pytest.raises(BadInputFile):
        read_bvh("HIERARCHY\n" + "\n".join(found) + "\n")


@given(st.integers(0, len(GOOD) - 1), st.integers(0, 60), st.text(max_size=6))
def test_any_damage(start: int, length: int, patch: str) -> None:
    try:
        motion = read_bvh(GOOD[:start] + patch + GOOD[start + length :])
    except BadInputFile as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(motion.table).all() and motion.table.shape[1:] == (2, 4)
