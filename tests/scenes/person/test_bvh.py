"""BVH files of several programs give back the person they were written from."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from scenes.person.angles import arm_directions
from scenes.person.bvh import joint_part, read_bvh
from scenes.person.clips import Clip
from tests.scenes.person.bvh_text import BLENDER, MIXAMO, POSER, STYLES, write_bvh
from tests.scenes.person.strategies import SIDES


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("clip", ["wave", "cross"])
def test_round_trip(style: str, clip: str) -> None:
    source = Clip(clip, 2)  # type: ignore[arg-type]
    motion = read_bvh(write_bvh(source, STYLES[style], frames=120))
    assert motion.duration == pytest.approx(119 * 0.05)
    for t in np.arange(120) * 0.05:
        found = motion.angles(float(t))
        assert found is not None
        assert_allclose(found, source.angles(t), atol=1e-5)


def test_frames_layout_and_offsets() -> None:
    motion = read_bvh(write_bvh(Clip("wave", 1), MIXAMO, frames=60))
    a, b, half = (motion.angles(t) for t in (1.0, 1.05, 1.025))
    assert a is not None and b is not None and half is not None
    assert_allclose(half, (a + b) / 2.0, atol=1e-9)
    for beyond, edge in ((-3.0, 0.0), (1e6, motion.duration)):
        assert_allclose(motion.angles(beyond), motion.angles(edge))  # type: ignore[arg-type]
    # Tabs, blank lines, braces at the end of a line, lower case, a missing blank after Frames: are all in use.
    text = write_bvh(Clip("clap", 1), POSER, frames=4)
    loose = text.replace("\n{", " {").replace("OFFSET ", "\tOffset\t").replace("\n", "\n\n").replace("Frames: ", "Frames:")
    loose = loose.replace("Xrotation", "XROTATION").replace("HIERARCHY", "Hierarchy")
    assert_allclose(read_bvh(loose).table, read_bvh(text).table, atol=0.0)
    # A joint whose position channels move is where they say; one whose channels stay at zero is at its offset.
    text = write_bvh(Clip("wave", 1), MIXAMO, frames=3)
    spine = "JOINT mixamorig:Spine\n{\nOFFSET 0.000000 20.000000 0.000000\nCHANNELS 3 "
    assert spine in text
    head, rows = text.split("Frame Time: 0.05\n")
    head = head.replace(spine, spine.replace("20.000000", "77.000000").replace("3 ", "6 Xposition Yposition Zposition "))
    # The root has 6 channels, each thigh 3.
    at = 12
    moved = [" ".join([*row.split()[:at], "0 20 0", *row.split()[at:]]) for row in rows.splitlines()]
    assert_allclose(read_bvh(head + "Frame Time: 0.05\n" + "\n".join(moved)).table, read_bvh(text).table, atol=1e-9)

    # Angles go on over ±180°, so that what lies between two frames is near both.
    class Windmill:
        def angles(self, time: float) -> np.ndarray:
            return np.array([[4.0 * time, 0.1, 0.0, 0.3]] * 2)

    motion = read_bvh(write_bvh(Windmill(), MIXAMO, frames=60))
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
    wanted = read_bvh(text)
    other_ends = text.replace("\n", "\r\n"), text.replace("\n", "\r")
    for source in (path, str(path), text.encode(), *other_ends, b"\xef\xbb\xbf" + text.encode()):
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
