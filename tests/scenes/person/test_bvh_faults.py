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


def refused(source: Path | str | bytes, *words: str) -> str:
    """Check that a file is refused by one line that says all the words; return it."""
    with pytest.raises(BadInputFile) as caught:
        read_bvh(source)
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 500 + len(str(source)) * isinstance(source, (Path, str))
    for word in words:
        assert word in text, text
    return text


def with_line(index: int, line: str) -> str:
    """The good file with one line changed."""
    return "\n".join([*LINES[:index], line, *LINES[index + 1 :]])


def test_no_person_in_it() -> None:
    # The file from which the bad ones are made is good.
    assert len(read_bvh(GOOD).table) == 4
    # Without thighs, hips or a spine nobody knows where up is.
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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("line 1", "HIERARCHY")),
        (" ", ("line 1", "HIERARCHY")),
        ("\n", ("line 1", "HIERARCHY")),
        ("time,x,y\n1,2,3\n", ("line 1", "not a BVH file", "HIERARCHY")),
        ("HIERARCHY\n", ("line 1", "ends where ROOT or MOTION is due")),
        ("HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 0.1\n1\n", ("line 5", "1 numbers", "0 channels")),
        ("HIERARCHY\nROOT\n{\n", ("line 2", "ROOT and a name")),
        ("HIERARCHY\nROOT Hips\nOFFSET 0 0 0\n", ("line 3", "{ is missing")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0\n", ("line 4", "OFFSET and 3 numbers")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 x 0\nCHANNELS 1 Xrotation\n", ("line 5", "'x' is not a number")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 nan\nCHANNELS 1 Xrotation\n", ("'nan' is not a finite number",)),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 1e9\nCHANNELS 1 Xrotation\n", ("'1e9' is not believable",)),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 2 Xrotation\n", ("line 5", "CHANNELS needs their number")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 2 Xrotation Xrotation\n", ("line 5", "different names")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 1 Wrotation\n", ("line 5", "Xposition … Zrotation")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 0\nROTATE\n", ("line 6", "'ROTATE'")),
        ("HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nJOIN a\n", ("line 6", "'JOIN a'", "JOINT and a name")),
    ],
)
def test_bad_hierarchies(text: str, words: tuple[str, ...]) -> None:
    """The line and what is due there."""
    refused(text, *words)


@pytest.mark.parametrize(
    ("index", "line", "words"),
    [
        (ROW - 2, "Frames: 5", ("4 frames follow, but Frames: says 5", "export it again")),
        (ROW - 2, "Frames: 3", ("4 frames follow, but Frames: says 3",)),
        (ROW - 2, "Frames: 0", (f"line {ROW - 1}", "1 to 100000")),
        (ROW - 2, "Frames: -4", (f"line {ROW - 1}", "whole number")),
        (ROW - 2, "Frames: 9999999999999999", (f"line {ROW - 1}", "whole number")),
        (ROW - 2, "Frames: 999999999", (f"line {ROW - 1}", "1 to 100000")),
        (ROW - 2, "Frame 5", (f"line {ROW - 1}", "Frames:")),
        (ROW - 1, "Frame Time: 0", (f"line {ROW}", "not believable")),
        (ROW - 1, "Frame Time: inf", (f"line {ROW}", "not a finite number")),
        (ROW - 1, "Time: 0.1", (f"line {ROW}", "Frame Time:")),
        (ROW + 1, LINES[ROW + 1] + " 3", (f"line {ROW + 2}", "numbers stand here")),
        (ROW + 1, " ".join(LINES[ROW + 1].split()[:-1]), (f"line {ROW + 2}", "numbers stand here")),
        (ROW + 1, "zero" + LINES[ROW + 1][8:], (f"line {ROW + 2}", "is not a number")),
        (ROW + 2, " ".join(["nan", *LINES[ROW + 2].split()[1:]]), (f"line {ROW + 3}", "'nan'")),
        (ROW + 2, " ".join([*LINES[ROW + 2].split()[1:], "-1e300"]), (f"line {ROW + 3}", "'-1e300'", "not believable")),
    ],
)
def test_bad_motions(index: int, line: str, words: tuple[str, ...]) -> None:
    """The line, the number in it, and the remedy."""
    refused(with_line(index, line), *words)


@pytest.mark.parametrize("keep", [1, 5, 20, ROW - 3, ROW - 2, ROW - 1, ROW, ROW + 2])
def test_truncated(keep: int) -> None:
    """A file that ends too soon is told so, wherever it ends."""
    refused("\n".join(LINES[:keep]) + "\n", "line ")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("LeftForeArm", "LeftThing", ("no left elbow", "'mixamorig:Hips'", "L_LowerArm")),
        ("RightForeArm", "Elbow", ("no right elbow",)),
        ("RightArm", "RightClavicle", ("no right upper arm",)),
        ("LeftArm", "Chest", ("no left upper arm",)),
    ],
)
def test_missing_joints(old: str, new: str, words: tuple[str, ...]) -> None:
    """What is missing, what there is, and which names would do."""
    refused(GOOD.replace(f"mixamorig:{old}", f"mixamorig:{new}"), *words)


def test_bad_files(tmp_path: Path) -> None:
    """No file, a folder, a picture, an endless device: told apart from a bad skeleton."""
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
    """Size is bounded in bytes, lines, joints and frames, before anything large is made."""
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
def test_any_bytes(data: bytes) -> None:
    """No bytes make anything but a refusal."""
    with pytest.raises(DuetError):
        read_bvh(data)


words = st.sampled_from(
    [
        "ROOT Hips",
        "JOINT LeftArm",
        "End Site",
        "{",
        "}",
        "OFFSET 1 2 3",
        "CHANNELS 1 Xrotation",
        "MOTION",
        "Frames: 1",
        "1",
        "Frame Time: 1",
    ]
)


@given(st.lists(words, max_size=40))
def test_any_words_of_the_format(found: list[str]) -> None:
    """Nor do its own words in any order, short of a body."""
    with pytest.raises(BadInputFile):
        read_bvh("HIERARCHY\n" + "\n".join(found) + "\n")


@given(st.integers(0, len(GOOD) - 1), st.integers(0, 60), st.text(max_size=6))
def test_any_damage(start: int, length: int, patch: str) -> None:
    """A good file with a hole and a patch is read, finite and complete, or refused with one line."""
    try:
        motion = read_bvh(GOOD[:start] + patch + GOOD[start + length :])
    except BadInputFile as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(motion.table).all()
    assert motion.table.shape[1:] == (2, 4)
