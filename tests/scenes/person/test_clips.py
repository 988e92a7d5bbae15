"""Clips and recorded people: between samples, outside them, and from BVH files, of whose faults one line says what and where."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.person import bvh_file
from scenes.person.angles import arm_directions, arm_points
from scenes.person.bvh import joint_part, read_bvh
from scenes.person.clips import CLIP_NAMES, REST, Clip, ClipName
from scenes.person.source import PersonSource, SampledAngles
from tests.scenes.person.bvh_text import BLENDER, MIXAMO, POSER, STYLES, write_bvh
from tests.scenes.person.strategies import SIDES

SEEDS = (0, 1, 2, 17, -3)


@pytest.mark.parametrize("name", CLIP_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_loop(name: ClipName, seed: int) -> None:
    clip = Clip(name, seed)
    assert_allclose(clip.angles(0.0), REST, atol=1e-12)
    assert_allclose(clip.angles(clip.duration), REST, atol=1e-9)
    for t in (0.0, 1.3, 0.7 * clip.duration):
        assert_allclose(clip.angles(t + 2.0 * clip.duration), clip.angles(t), atol=1e-9)
    assert np.abs(clip.angles(0.5 * clip.duration) - REST).max() > 0.01


@pytest.mark.parametrize("name", CLIP_NAMES)
def test_smoothness_and_seeds(name: ClipName) -> None:
    # The steps of the second differences shrink with h: no jump of the acceleration, over the seam neither.
    clip = Clip(name, 3)

    def roughest(h: float) -> float:
        times = np.arange(-0.5, clip.duration + 0.5, h)
        q = np.array([clip.angles(t) for t in times]).reshape(len(times), -1)
        return float(np.abs(np.diff(np.diff(q, 2, axis=0) / h**2, axis=0)).max())

    coarse, fine = roughest(0.01), roughest(0.005)
    assert fine < 0.65 * coarse and coarse < 5.0
    # The same seed gives the same bits in any order of asking; another seed another motion.
    a, b = Clip(name, 5), Clip(name, 5)
    times = (3.0, 0.2, 7.5, 3.0)
    assert_array_equal([a.angles(t) for t in times], [b.angles(t) for t in reversed(times)][::-1])
    others = [Clip(name, seed) for seed in range(8)]
    assert len({clip.duration for clip in others}) == len(others)


def test_names_seeds_and_refusals() -> None:
    raised = {int(np.argmax(Clip("wave", seed).angles(3.0)[:, 1])) for seed in range(10)}
    assert raised == {0, 1}
    medley, start = Clip("medley", 4), 0.0
    for name in CLIP_NAMES[:-1]:
        clip = Clip(name, 4)
        for part in (0.1, 0.45, 0.9):
            assert_allclose(medley.angles(start + part * clip.duration), clip.angles(part * clip.duration), atol=1e-9)
        start += clip.duration
    assert_allclose(medley.duration, start)
    with pytest.raises(BadSetting, match="choose from wave, clap, cross, reach, medley"):
        Clip("dance")  # type: ignore[arg-type]
    clip = Clip("clap", 1)
    clip.angles(0.0)[:] = 9.0
    clip.angles(clip.duration)[:] = 9.0
    assert_allclose(clip.angles(0.0), REST)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_person_does_what_the_name_says(seed: int) -> None:
    def wrists(clip: Clip) -> np.ndarray:
        times = np.arange(0.0, clip.duration, 0.02)
        return np.array([[arm_points(clip.angles(t)[i], s)[2] for i, s in enumerate(("left", "right"))] for t in times])

    wave, clap, cross, reach = (wrists(Clip(name, seed)) for name in CLIP_NAMES[:4])
    assert np.linalg.norm(clap[:, 0] - clap[:, 1], axis=1).min() < 0.12
    assert (cross[:, 0, 1] - cross[:, 1, 1]).min() < -0.02
    assert wave[:, :, 2].max() > 0.1
    assert reach[:, :, 0].max() > 0.5


TIMES = np.array([0.0, 1.0, 3.0, 4.0])
TABLE = np.arange(4.0)[:, None, None] * np.ones((4, 2, 4))


def value(source: PersonSource, time: float) -> float | None:
    angles = source.angles(time)
    return None if angles is None else float(angles[1, 2])


def test_sampled_angles() -> None:
    sampled = SampledAngles(TIMES, TABLE)
    assert sampled.duration == 4.0
    times = (-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 3.25, 4.0, 99.0)
    assert [value(sampled, t) for t in times] == [0.0, 0.0, 0.5, 1.0, 1.5, 2.0, 2.25, 3.0, 3.0]
    # No person at a sample with a NaN, nor on the way to or from it.
    table = TABLE.copy()
    table[2, 0, 0] = np.nan
    sampled = SampledAngles(TIMES, table)
    assert [value(sampled, t) for t in (1.0, 1.1, 3.0, 3.9, 4.0)] == [1.0, None, None, None, 3.0]
    sampled = SampledAngles(np.array([2.0]), TABLE[1:2])
    assert [value(sampled, t) for t in (0.0, 2.0, 5.0)] == [1.0, 1.0, 1.0]
    sampled = SampledAngles(TIMES, TABLE.copy())
    angles = sampled.angles(1.0)
    assert angles is not None and angles.shape == (2, 4)
    angles[:] = 7.0
    assert value(sampled, 1.0) == 1.0


def test_shapes_and_times_are_checked() -> None:
    misfits = [(TIMES[:3], TABLE), (TIMES[:0], TABLE[:0]), (TIMES, TABLE[:, 0]), (TIMES[::-1], TABLE)]
    misfits += [(np.array([0.0, 1.0, wrong, 2.0]), TABLE) for wrong in (1.0, np.nan)]
    for times, table in misfits:
        with pytest.raises(ValueError, match="times"):
            SampledAngles(times, table)


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
    # Tabs, blank lines, braces at the end of a line, lower case, a missing blank after Frames: are all in use.
    text = write_bvh(Clip("clap", 1), POSER, frames=4)
    loose = text.replace("\n{", " {").replace("OFFSET ", "\tOffset\t").replace("\n", "\n\n").replace("Frames: ", "Frames:")
    loose = loose.replace("Xrotation", "XROTATION").replace("HIERARCHY", "Hierarchy")
    assert_allclose(read_bvh(loose.encode()).table, read_bvh(text.encode()).table, atol=0.0)
    # A joint whose position channels move is where they say; one whose channels stay at zero is at its offset.
    text = write_bvh(Clip("wave", 1), MIXAMO, frames=3)
    spine = "JOINT mixamorig:Spine\n{\nOFFSET 0.000000 20.000000 0.000000\nCHANNELS 3 "
    assert spine in text
    head, rows = text.split("Frame Time: 0.05\n")
    head = head.replace(spine, spine.replace("20.000000", "77.000000").replace("3 ", "6 Xposition Yposition Zposition "))
    # The root has 6 channels, each thigh 3.
    at = 12
    moved = [" ".join([*row.split()[:at], "0 20 0", *row.split()[at:]]) for row in rows.splitlines()]
    text_of_moved = head + "Frame Time: 0.05\n" + "\n".join(moved)
    assert_allclose(read_bvh(text_of_moved.encode()).table, read_bvh(text.encode()).table, atol=1e-9)

    # Angles go on over ±180°, so that what lies between two frames is near both.
    class Windmill:
        def angles(self, time: float) -> np.ndarray:
            return np.array([[4.0 * time, 0.1, 0.0, 0.3]] * 2)

    motion = read_bvh(write_bvh(Windmill(), MIXAMO, frames=60).encode())
    assert np.abs(np.diff(motion.table, axis=0)).max() < 0.3
    for t in np.arange(0.0, 2.9, 0.025):
        found = motion.angles(float(t))
        assert found is not None
        for i, side in enumerate(SIDES):
            assert_allclose(arm_directions(found[i], side), arm_directions(Windmill().angles(t)[i], side), atol=0.01)


def test_sources_of_a_file(tmp_path: Path) -> None:
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


def test_no_person_in_it() -> None:
    assert len(read_bvh(GOOD.encode()).table) == 4
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
    refused(tmp_path, "cannot be read", "a folder")
    refused(Path("/dev/zero"), "cannot be read", "a device")
    picture = tmp_path / "a.bvh"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff" * 50)
    refused(picture, "not a BVH file")
    refused(Path("a\0b"), "no such file")
    refused(Path("a" * 5000), "cannot be read", "too long")


def test_too_large(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "big.bvh"
    path.write_text(GOOD)
    monkeypatch.setattr(bvh_file, "MOST_BYTES", 100)
    for source in (path, GOOD):
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
        read_bvh(("HIERARCHY\n" + "\n".join(found) + "\n").encode())


@given(st.integers(0, len(GOOD) - 1), st.integers(0, 60), st.text(max_size=6))
def test_any_damage(start: int, length: int, patch: str) -> None:
    try:
        motion = read_bvh((GOOD[:start] + patch + GOOD[start + length :]).encode())
    except BadInputFile as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(motion.table).all() and motion.table.shape[1:] == (2, 4)
