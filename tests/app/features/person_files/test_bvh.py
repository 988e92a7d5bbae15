"""Recorded persons from BVH files; one sentence names each fault and its place, in the page's language."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from app.features.person_files import bvh_file
from app.features.person_files.bvh import joint_part, read_bvh
from app.i18n.catalogue import words_of
from app.settings import LANGUAGES, Language
from controllers.errors import BadInputFile, DuetError
from scenes.person.angles import arm_directions
from scenes.person.clips import Clip
from tests.app.features.person_files.bvh_text import BLENDER, MIXAMO, POSER, STYLES, write_bvh
from tests.app.features.said import lines_of
from tests.app.i18n.helpers import assert_said
from tests.approved import Approve
from tests.scenes.person.strategies import SIDES


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("clip", ["wave", "cross"])
def test_round_trip(style: str, clip: str) -> None:
    source = Clip(clip, 2)  # type: ignore[arg-type]
    motion = read_bvh(write_bvh(source, STYLES[style], frames=120).encode())
    assert motion.duration == pytest.approx(119 * 0.05)
    for t in np.arange(120) * 0.05:
        found = motion.angles(float(t))
        assert found is not None
        assert_allclose(found, source.angles(t), atol=1e-5)


def test_frames_layout_and_offsets() -> None:
    motion = read_bvh(write_bvh(Clip("wave", 1), MIXAMO, frames=60).encode())
    a, b, half = (motion.angles(t) for t in (1.0, 1.05, 1.025))
    assert a is not None and b is not None and half is not None
    assert_allclose(half, (a + b) / 2.0, atol=1e-9)
    for beyond, edge in ((-3.0, 0.0), (1e6, motion.duration)):
        assert_allclose(motion.angles(beyond), motion.angles(edge))  # type: ignore[arg-type]
    # Existing variants: tabs, blank lines, braces at line ends, lower case, no blank after "Frames:".
    text = write_bvh(Clip("clap", 1), POSER, frames=4)
    loose = (
        text.replace("\n{", " {")
        .replace("OFFSET ", "\tOffset\t")
        .replace("\n", "\n\n")
        .replace("Frames: ", "Frames:")
    )
    loose = loose.replace("Xrotation", "XROTATION").replace("HIERARCHY", "Hierarchy")
    assert_allclose(read_bvh(loose.encode()).table, read_bvh(text.encode()).table, atol=0.0)
    # A joint is at its position channels if they move, or at its offset if they are all zero.
    text = write_bvh(Clip("wave", 1), MIXAMO, frames=3)
    spine = "JOINT mixamorig:Spine\n{\nOFFSET 0.000000 20.000000 0.000000\nCHANNELS 3 "
    assert spine in text
    head, rows = text.split("Frame Time: 0.05\n")
    head = head.replace(
        spine, spine.replace("20.000000", "77.000000").replace("3 ", "6 Xposition Yposition Zposition ")
    )
    # Columns before it: 6 of the root and 3 of each thigh.
    at = 12
    moved = [" ".join([*row.split()[:at], "0 20 0", *row.split()[at:]]) for row in rows.splitlines()]
    text_of_moved = head + "Frame Time: 0.05\n" + "\n".join(moved)
    assert_allclose(read_bvh(text_of_moved.encode()).table, read_bvh(text.encode()).table, atol=1e-9)

    # Angles are continuous beyond ±180°, so values between two frames are near both.
    class Windmill:
        def angles(self, time: float) -> np.ndarray:
            return np.array([[4.0 * time, 0.1, 0.0, 0.3]] * 2)

    motion = read_bvh(write_bvh(Windmill(), MIXAMO, frames=60).encode())
    assert np.abs(np.diff(motion.table, axis=0)).max() < 0.3
    for t in np.arange(0.0, 2.9, 0.025):
        found = motion.angles(float(t))
        assert found is not None
        for i, side in enumerate(SIDES):
            assert_allclose(
                arm_directions(found[i], side), arm_directions(Windmill().angles(t)[i], side), atol=0.01
            )


def test_files_are_read_from_paths_and_bytes_with_any_line_ends(tmp_path: Path) -> None:
    text = write_bvh(Clip("reach", 1), BLENDER, frames=5)
    path = tmp_path / "walk.bvh"
    path.write_text(text)
    wanted = read_bvh(text.encode())
    other_ends = text.replace("\n", "\r\n").encode(), text.replace("\n", "\r").encode()
    for source in (path, *other_ends, b"\xef\xbb\xbf" + text.encode()):
        assert_allclose(read_bvh(source).table, wanted.table, atol=0.0)


def test_side_and_part_of_a_joint_in_all_usual_spellings() -> None:
    spellings = {
        ("left", "forearm"): ("LeftForeArm", "lForeArm", "LForeArm", "Bip01 L Forearm"),
        ("right", "forearm"): ("CC_Base_R_Forearm", "rightforearm"),
        ("right", "upperarm"): ("R_UpperArm", "upper_arm.R"),
        ("left", "elbow"): ("ElbowLeft", "lelbow"),
        ("left", "hand"): ("mixamorig:LeftHand",),
        ("right", "shldr"): ("rShldr",),
        ("left", "hip"): ("LHipJoint",),
        (None, "hips"): ("Hips",),
        (None, "lowerback"): ("LowerBack",),
        (None, "neck"): ("Neck1",),
        (None, ""): ("",),
    }
    for found, names in spellings.items():
        assert {name: joint_part(name) for name in names} == dict.fromkeys(names, found)


GOOD = write_bvh(Clip("wave", 1), MIXAMO, frames=4)
LINES = GOOD.splitlines()
ROW = next(i for i, line in enumerate(LINES) if line.startswith("Frame Time")) + 1


def refused(source: Path | str | bytes, *words: str) -> None:
    with pytest.raises(BadInputFile) as caught:
        read_bvh(source.encode() if isinstance(source, str) else source)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 500 + len(str(source)) * isinstance(source, Path)
    for word in words:
        assert word in text, text


def with_line(index: int, line: str) -> str:
    return "\n".join([*LINES[:index], line, *LINES[index + 1 :]])


NUMBERS = LINES[ROW + 1].split()


def test_files_without_a_person_are_refused() -> None:
    assert len(read_bvh(GOOD.encode()).table) == 4
    # Without thighs, hips or spine the upward direction is unknown.
    text = GOOD
    for old, new in (("LeftUpLeg", "a"), ("RightUpLeg", "b"), ("Hips", "c"), ("Spine", "d")):
        text = text.replace(f"mixamorig:{old}", new)
    refused(text, "no hips")
    # A skeleton with all joints in one place.
    text = "\n".join("OFFSET 0 0 0" if line.startswith("OFFSET") else line for line in LINES)
    refused(text, "in no frame")
    # A small file that announces many frames of many channels must not allocate memory for them.
    joints = (
        "JOINT a\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation\n"
        * 400
    )
    head = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n" + joints + "}\n" * 401
    text = f"{head}MOTION\nFrames: 100000\nFrame Time: 0.01\n" + "1\n" * 100_000
    tracemalloc.start()
    try:
        refused(text, "numbers in this line")
        assert tracemalloc.get_traced_memory()[1] < 100_000_000
    finally:
        tracemalloc.stop()


ROOT = "HIERARCHY\nROOT Hips\n{\n"
FIVE = ROOT + "OFFSET 0 0 0\n"


def with_first(*numbers: str) -> str:
    """The file with these numbers as its first frame."""
    return with_line(ROW + 1, " ".join(numbers))


FAULTY = {
    "nothing": "",
    "a blank": " ",
    "a line break": "\n",
    "a table": "time,x,y\n1,2,3\n",
    "no root": "HIERARCHY\n",
    "no joints": "HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 0.1\n1\n",
    "a root without a name": "HIERARCHY\nROOT\n{\n",
    "no brace": "HIERARCHY\nROOT Hips\nOFFSET 0 0 0\n",
    "an offset of two": ROOT + "OFFSET 0 0\n",
    "a letter": ROOT + "OFFSET 0 x 0\nCHANNELS 1 Xrotation\n",
    "nan": ROOT + "OFFSET 0 0 nan\nCHANNELS 1 Xrotation\n",
    "far away": ROOT + "OFFSET 0 0 1e9\nCHANNELS 1 Xrotation\n",
    "fewer channels": FIVE + "CHANNELS 2 Xrotation\n",
    "one channel twice": FIVE + "CHANNELS 2 Xrotation Xrotation\n",
    "another channel": FIVE + "CHANNELS 1 Wrotation\n",
    "another word": FIVE + "CHANNELS 0\nROTATE\n",
    "a word without its last letter": FIVE + "CHANNELS 1 Xrotation\nJOIN a\n",
    "a frame less": with_line(ROW - 2, "Frames: 5"),
    "a frame more": with_line(ROW - 2, "Frames: 3"),
    "no frame": with_line(ROW - 2, "Frames: 0"),
    "too many frames": with_line(ROW - 2, "Frames: 999999999"),
    "a negative number of frames": with_line(ROW - 2, "Frames: -4"),
    "a very large number of frames": with_line(ROW - 2, "Frames: 9999999999999999"),
    "no word Frames": with_line(ROW - 2, "Frame 5"),
    "no time": with_line(ROW - 1, "Frame Time: 0"),
    "endless time": with_line(ROW - 1, "Frame Time: inf"),
    "no word Frame Time": with_line(ROW - 1, "Time: 0.1"),
    "a number more": with_first(*NUMBERS, "3"),
    "a number less": with_first(*NUMBERS[:-1]),
    "a word among the numbers": with_first("zero", *NUMBERS[1:]),
    "nan among the numbers": with_first("nan", *NUMBERS[1:]),
    "a large number": with_first(*NUMBERS[1:], "-1e300"),
    **{
        f"cut off, line {keep}": "\n".join(LINES[:keep]) + "\n"
        for keep in (1, 5, 20, ROW - 3, ROW - 1, ROW + 2)
    },
    "no left elbow": GOOD.replace(":LeftForeArm", ":LeftThing"),
    "no right elbow": GOOD.replace(":RightForeArm", ":Elbow"),
    "no right upper arm": GOOD.replace(":RightArm", ":RightClavicle"),
    "no left upper arm": GOOD.replace(":LeftArm", ":Chest"),
}


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_fault_is_named_with_line_expected_input_and_remedy(language: Language, approve: Approve) -> None:
    said = dict[str, str]()
    for case, text in FAULTY.items():
        with pytest.raises(BadInputFile) as error:
            read_bvh(text.encode(), "walk.bvh")
        said[case] = str(error.value)
    assert all("\n" not in text for text in said.values())
    approve(f"faults {language}.txt", lines_of(said, language))


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    refused(tmp_path / "none.bvh", "none.bvh", "no such file")
    refused(tmp_path, "cannot be read", "a folder")
    refused(Path("/dev/zero"), "cannot be read", "a device")
    picture = tmp_path / "a.bvh"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff" * 50)
    refused(picture, "not a BVH file")
    refused(Path("a\0b"), "no such file")
    refused(Path("a" * 5000), "cannot be read", "too long")


def test_too_large_files_are_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "big.bvh"
    path.write_text(GOOD)
    monkeypatch.setattr(bvh_file, "MOST_BYTES", 100)
    for source in (path, GOOD):
        refused(source, "larger than", "fewer frames")
    monkeypatch.undo()
    refused("\n" * (bvh_file.MOST_LINES + 1), "lines")
    deep = "HIERARCHY\nROOT a\n" + "{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nJOINT a\n" * (
        bvh_file.MOST_JOINTS + 1
    )
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
        read_bvh(("HIERARCHY\n" + "\n".join(found) + "\n").encode())


@given(st.integers(0, len(GOOD) - 1), st.integers(0, 60), st.text(max_size=6))
def test_damage_is_refused_or_gives_a_finite_motion(start: int, length: int, patch: str) -> None:
    try:
        motion = read_bvh((GOOD[:start] + patch + GOOD[start + length :]).encode())
    except BadInputFile as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(motion.table).all() and motion.table.shape[1:] == (2, 4)


FAULTS: dict[str, Callable[[], object]] = {
    "not a skeleton": lambda: read_bvh(b"1\n2\n", "🦆"),
    "cut skeleton": lambda: read_bvh(GOOD[: len(GOOD) // 3].encode(), "🦆"),
    "no elbow": lambda: read_bvh(GOOD.replace("ForeArm", "1").replace("forearm", "1").encode(), "🦆"),
    "a word among the numbers": lambda: read_bvh(GOOD.rstrip().rsplit(" ", 1)[0].encode() + b" -", "🦆"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_described_in_the_pages_language(name: str) -> None:
    assert_said(FAULTS[name])


def test_its_errors_are_texts_of_the_page() -> None:
    # The catalogue has the texts of the page and no others, see `tests/app/i18n/test_words.py`.
    assert {"hips", "The video has ended."} <= set(words_of("sl").texts)
