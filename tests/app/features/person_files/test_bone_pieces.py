"""Skeletons of many programs: all naming conventions, and bones in several twisting pieces."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from app.features.person_files.bvh import read_bvh
from app.features.person_files.bvh_file import CHANNELS, BvhJoint, load_bvh
from controllers.errors import BadInputFile
from scenes.person.clips import Clip
from tests.app.features.person_files.bvh_text import (
    BLENDER,
    MIXAMO,
    POSER,
    SNAKE,
    UNDERSCORE,
    Style,
    write_bvh,
)
from tests.approved import Approve

CLIP = Clip("cross", 2)
LEFT_RIGHT, LR, LOWER = ("Left", "Right"), ("L", "R"), ("l", "r")


def style(names: str, sides: tuple[str, str]) -> Style:
    """A style from the names of hips, spine, collar, shoulder, elbow, wrist and thigh; ~ is a blank."""
    found = dict(zip(FIELDS, (name.replace("~", " ") for name in names.split()), strict=True))
    return replace(MIXAMO, **found, sides=sides)


FIELDS = ("hips", "spine", "collar", "shoulder", "elbow", "wrist", "thigh")

PROGRAMS = {
    "Mixamo": MIXAMO,
    "Mixamo, second skeleton": style(
        "mixamorig1:Hips mixamorig1:Spine mixamorig1:{}Shoulder mixamorig1:{}Arm mixamorig1:{}ForeArm mixamorig1:{}Hand "
        "mixamorig1:{}UpLeg",
        LEFT_RIGHT,
    ),
    "MotionBuilder": style("Character1_Hips Character1_Spine Character1_{}Shoulder Character1_{}Arm Character1_{}ForeArm "
                           "Character1_{}Hand Character1_{}UpLeg", LEFT_RIGHT),
    "Rokoko, Perception Neuron": style("Hips Spine {}Shoulder {}Arm {}ForeArm {}Hand {}UpLeg", LEFT_RIGHT),
    "Xsens MVN": style("Pelvis L5 {}Shoulder {}UpperArm {}ForeArm {}Hand {}UpperLeg", LEFT_RIGHT),
    "Xsens MVN BVH": style("Hips Chest {}Collar {}Shoulder {}Elbow {}Wrist {}Hip", LEFT_RIGHT),
    "OptiTrack Motive": style("Hip Chest {}Shoulder {}UArm {}FArm {}Hand {}Thigh", LR),
    "OptiTrack Motive with a skeleton's name": style("Bob:Hip Bob:Chest Bob:{}Shoulder Bob:{}UArm Bob:{}FArm Bob:{}Hand "
                                                     "Bob:{}Thigh", LR),
    "OptiTrack Motive, underlined": style("Bob_Hip Bob_Chest Bob_{}Shoulder Bob_{}UArm Bob_{}FArm Bob_{}Hand Bob_{}Thigh", LR),
    "Daz Genesis 3 and 8": style("hip abdomenLower {}Collar {}ShldrBend {}ForearmBend {}Hand {}ThighBend", LOWER),
    "Daz Genesis 9": style("hip spine1 {}_shoulder {}_upperarm {}_forearm {}_hand {}_thigh", LOWER),
    "Poser": POSER,
    "Second Life Bento": style("mPelvis mTorso mCollar{} mShoulder{} mElbow{} mWrist{} mHip{}", LEFT_RIGHT),
    "CMU, Acclaim": style("root lowerback {}clavicle {}humerus {}radius {}wrist {}femur", LOWER),
    "CMU in MotionBuilder": style("Hips LowerBack {}Shoulder {}Arm {}ForeArm {}Hand {}HipJoint", LEFT_RIGHT),
    "SMPL": style("Pelvis Spine1 {}_Collar {}_Shoulder {}_Elbow {}_Wrist {}_Hip", LR),
    "Rigify": style("spine spine.001 shoulder.{} upper_arm.{} forearm.{} hand.{} thigh.{}", LR),
    "Rigify, deforming bones": style("DEF-spine DEF-spine.001 DEF-shoulder.{} DEF-upper_arm.{} DEF-forearm.{} "
                                   "DEF-hand.{} DEF-thigh.{}", LR),
    "MakeHuman": style("root spine05 clavicle.{} upperarm01.{} lowerarm01.{} wrist.{} upperleg01.{}", LR),
    "Unreal": style("pelvis spine_01 clavicle_{} upperarm_{} lowerarm_{} hand_{} thigh_{}", LOWER),
    "VRM": style("J_Bip_C_Hips J_Bip_C_Spine J_Bip_{}_Shoulder J_Bip_{}_UpperArm J_Bip_{}_LowerArm J_Bip_{}_Hand J_Bip_{}_UpperLeg", LR),
    "Reallusion": style("CC_Base_Hip CC_Base_Waist CC_Base_{}_Clavicle CC_Base_{}_Upperarm CC_Base_{}_Forearm CC_Base_{}_Hand "
                        "CC_Base_{}_Thigh", LR),
    "3ds Max Biped": style("Bip01~Pelvis Bip01~Spine Bip01~{}~Clavicle Bip01~{}~UpperArm Bip01~{}~Forearm Bip01~{}~Hand "
                           "Bip01~{}~Thigh", LR),
    "3ds Max Biped, underlined": style("Bip001_Pelvis Bip001_Spine Bip001_{}_Clavicle Bip001_{}_UpperArm Bip001_{}_Forearm "
                                       "Bip001_{}_Hand Bip001_{}_Thigh", LR),
    "Character Studio": style("Hips Chest {}Collar {}UpArm {}LowArm {}Hand {}Hip", LEFT_RIGHT),
    "Advanced Skeleton": style("Root Spine1 Scapula_{} Shoulder_{} Elbow_{} Wrist_{} Hip_{}", LR),
    "Bandai Namco": style("Hips Spine Shoulder_{} UpperArm_{} LowerArm_{} Hand_{} UpperLeg_{}", LR),
    "Blender": BLENDER,
    "End Site at the wrist": SNAKE,
    "End Site at the wrist, Mixamo": replace(MIXAMO, wrist=""),
    "underlined": UNDERSCORE,
}  # fmt: skip


@pytest.mark.parametrize("program", PROGRAMS)
def test_names_of_every_program_are_read(program: str) -> None:
    motion = read_bvh(write_bvh(CLIP, PROGRAMS[program], frames=10, frame_time=0.5).encode())
    for t in 0.5 * np.arange(10):
        assert_allclose(motion.angles(float(t)), CLIP.angles(float(t)), atol=1e-5)  # type: ignore[arg-type]


PIECE_NAMES = {
    "numbers": "{name}.00{n}", "twist": "{name}Twist{n}", "roll": "{name}Roll{n}", "underlined": "{name}_twist_0{n}",
    "part": "{name}Part{n}", "segment": "{name}_seg{n}", "letters": "{name}_{letter}", "same": "{name}",
}  # fmt: skip


def with_pieces(text: str, bones: set[tuple[str, str]], rule: str, seed: int, crooked: float) -> str:
    """The same motion with bones in pieces that each turn about their own axis.

    Args:
        bones: names of the joints at their ends; "" for an End Site.
        rule: key of `PIECE_NAMES`.
        crooked: distance of the pieces' joints from the bone [share of its length].
    """
    random, file = np.random.default_rng(seed), load_bvh(text.encode())
    count = len(file.frames)
    names = [joint.name for joint in file.joints]
    children = [
        [i for i, joint in enumerate(file.joints) if joint.parent == k] for k in range(len(file.joints))
    ]
    lines, columns = ["HIERARCHY"], list[np.ndarray]()

    def rotations(joint: BvhJoint) -> Rotation:
        order = "".join(CHANNELS[c][0].upper() for c in joint.channels if c >= 3)
        first = joint.column + sum(c < 3 for c in joint.channels)
        return Rotation.from_euler(order, file.frames[:, first : first + 3], degrees=True)

    def begin(kind: str, name: str, offset: np.ndarray) -> None:
        lines.extend(
            (f"{kind} {name}" if name else "End Site", "{", "OFFSET " + " ".join(f"{v:.9f}" for v in offset))
        )

    def write(i: int, offset: np.ndarray, undone: Rotation) -> None:
        joint = file.joints[i]
        begin("ROOT" if joint.parent < 0 else "JOINT", joint.name, offset)
        if joint.name:
            moved = [joint.column + k for k, c in enumerate(joint.channels) if c < 3]
            lines.append(
                f"CHANNELS {len(moved) + 3} "
                + "Xposition Yposition Zposition " * bool(moved)
                + "Zrotation Xrotation Yrotation"
            )
            columns.extend(file.frames[:, k] for k in moved)
            columns.extend((undone.inv() * rotations(joint)).as_euler("ZXY", degrees=True).T)
        for child in children[i]:
            cut = (names[i], names[child]) in bones
            pieces(joint.name, child) if cut else write(
                child, file.joints[child].offset, Rotation.identity(count)
            )
        lines.append("}")

    def pieces(name: str, child: int) -> None:
        way = file.joints[child].offset
        size = int(random.integers(1, 4))
        shares = np.sort(random.uniform(0.1, 0.9, size))
        off = crooked * np.linalg.norm(way) * random.uniform(-1.0, 1.0, (size, 3))
        points = np.vstack([np.zeros(3), shares[:, None] * way + off, way])
        turned = Rotation.identity(count)
        for n in range(1, size + 1):
            begin(
                "JOINT",
                PIECE_NAMES[rule].format(name=name, n=n, letter="abc"[n - 1]),
                points[n] - points[n - 1],
            )
            lines.append("CHANNELS 3 Zrotation Xrotation Yrotation")
            axis = (points[n + 1] - points[n]) / np.linalg.norm(points[n + 1] - points[n])
            twist = Rotation.from_rotvec(
                np.outer(random.uniform(-1.5, 1.5) * np.sin(np.linspace(0.0, 5.0, count)), axis)
            )
            # In the bone's frame each piece turns its children; the next piece first reverses that turn.
            columns.extend((turned.inv() * twist).as_euler("ZXY", degrees=True).T)
            turned = twist
        write(child, way - points[size], turned)
        lines.extend("}" for _ in range(size))

    write(0, file.joints[0].offset, Rotation.identity(count))
    rows = [" ".join(f"{v:.8f}" for v in row) for row in np.column_stack(columns)]
    return "\n".join([*lines, "MOTION", f"Frames: {count}", f"Frame Time: {file.frame_time}", *rows]) + "\n"


@cache
def short_motion(program: str) -> str:
    return write_bvh(CLIP, PROGRAMS[program], frames=4, frame_time=1.1)


def bones_of(style: Style) -> list[tuple[str, str]]:
    """Bones of both arms as names of the joints at their ends."""
    ends = ((style.shoulder, style.elbow), (style.elbow, style.wrist), (style.collar, style.shoulder))
    return [(a.format(side), b.format(side)) for side in style.sides for a, b in ends if a]


@given(
    st.sampled_from(sorted(PROGRAMS)), st.sampled_from(sorted(PIECE_NAMES)), st.integers(0, 10_000), st.data()
)
def test_bones_in_pieces_equal_bones_in_one(program: str, rule: str, seed: int, data: st.DataObject) -> None:
    made = PROGRAMS[program]
    text = short_motion(program)
    bones = data.draw(st.sets(st.sampled_from(bones_of(made)), min_size=1))
    cut = with_pieces(text, bones, rule, seed, data.draw(st.sampled_from((0.0, 0.15))))
    assert cut.count("JOINT") > text.count("JOINT")
    assert_allclose(read_bvh(cut.encode()).table, read_bvh(text.encode()).table, atol=1e-5)


def test_two_people_are_refused_in_one_sentence(approve: Approve) -> None:
    # A second root without arms is a prop, not a second person.
    text = write_bvh(CLIP, MIXAMO, frames=4)
    head, motion = text.split("MOTION\n")
    count = len(load_bvh(text.encode()).frames[0])
    rows = motion.splitlines()
    second = head.removeprefix("HIERARCHY\n").replace("mixamorig:", "mixamorig2:")
    twice = [*rows[:2], *(f"{row} {row}" for row in rows[2:])]
    assert len(twice[2].split()) == 2 * count
    with pytest.raises(BadInputFile) as caught:
        read_bvh("\n".join([head + second + "MOTION", *twice, ""]).encode())
    approve("two people.txt", f"{caught.value}\n")
    prop = "ROOT prop\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
    beside = "\n".join([head + prop + "MOTION", *rows[:2], *(f"{row} 0 0 0" for row in rows[2:]), ""])
    assert_allclose(read_bvh(beside.encode()).table, read_bvh(text.encode()).table)


def test_the_unit_of_length_makes_no_difference() -> None:
    tables = [
        read_bvh(write_bvh(CLIP, replace(MIXAMO, unit=unit), frames=6).encode()).table
        for unit in (1.0, 39.37, 1000.0)
    ]
    for table in tables[1:]:
        assert_allclose(table, tables[0], atol=1e-4)


def test_an_elbow_control_is_not_taken_for_the_elbow() -> None:
    text = write_bvh(CLIP, MIXAMO, frames=4)
    control = "JOINT {}\n{{\nOFFSET 1 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{{\nOFFSET 0 1 0\n}}\n}}\n"
    head, motion = text.split("MOTION\n")
    # The controls are the first children of the hips.
    at = head.index("JOINT mixamorig:LeftUpLeg")
    controls = "".join(
        control.format(name) for name in ("target_elbow.L", "ik_hand.L", "target_elbow.R", "ik_hand.R")
    )
    rows = motion.splitlines()
    rows[2:] = [" ".join([*row.split()[:6], *["30"] * 12, *row.split()[6:]]) for row in rows[2:]]
    found = read_bvh("\n".join([head[:at] + controls + head[at:] + "MOTION", *rows, ""]).encode())
    assert_allclose(found.table, read_bvh(text.encode()).table)


def test_twist_joints_beside_the_arm_are_ignored() -> None:
    # As in skeletons of Unreal: twist joints are children of the bone and have no children.
    made = PROGRAMS["Unreal"]
    text = write_bvh(CLIP, made, frames=4)
    leaf = "JOINT {}\n{{\nOFFSET 1 3 0\nCHANNELS 1 Xrotation\nEnd Site\n{{\nOFFSET 5 5 0\n}}\n}}\n"
    head, motion = text.split("MOTION\n")
    names = [joint.name for joint in load_bvh(text.encode()).joints]
    columns = [joint.column for joint in load_bvh(text.encode()).joints]
    rows = [row.split() for row in motion.splitlines()[2:]]
    # From the last name to the first, so that the columns before it keep their places.
    for name in ("hand_r", "lowerarm_r", "hand_l", "lowerarm_l"):
        twist = name.replace("hand", "lowerarm_twist_01").replace("lowerarm_r", "upperarm_twist_01_r")
        twist = twist.replace("lowerarm_l", "upperarm_twist_01_l")
        at = head.index(f"JOINT {name}\n")
        head = head[:at] + leaf.format(twist) + head[at:]
        for row in rows:
            row.insert(columns[names.index(name)], "40")
    found = read_bvh(
        "\n".join([head + "MOTION", *motion.splitlines()[:2], *map(" ".join, rows), ""]).encode()
    )
    assert_allclose(found.table, read_bvh(text.encode()).table)
