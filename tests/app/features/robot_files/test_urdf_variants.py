"""Real-world URDF files: each gives an arm with capsules and meshes, or is refused in one sentence."""

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.exchange.dae import export_collada
from trimesh.exchange.stl import export_stl_ascii

from app.features.robot_files.file_robot import FileRobot, register
from controllers.errors import BadInputFile
from scenes import glb
from scenes.given_robots import GIVEN
from scenes.lwr.shells import PALETTES
from scenes.robots import robot
from scenes.robots.drawing import draw_given, robot_glbs, robot_link_meshes
from tests.app.features.robot_files.arm_urdf import arm_urdf
from tests.app.features.robot_files.refusals import refusal_lines, refusals
from tests.approved import Approve
from tests.scenes.helpers import beyond, own_cache

pytestmark = pytest.mark.slow

COLLADA = '<unit name="centimeter" meter="0.01"/>'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with good and bad meshes."""
    made = tmp_path_factory.mktemp("meshes")
    block = trimesh.creation.box((0.1, 0.1, 0.2))
    for name in ("box.stl", "box.obj", "box.glb", "box.ply"):
        block.export(made / name)
    (made / "arm_meshes").mkdir()
    block.export(made / "arm_meshes" / "box.stl")
    (made / "ascii.stl").write_text(export_stl_ascii(block), encoding="ascii")
    inside_out = block.copy()
    inside_out.invert()
    inside_out.export(made / "inside_out.stl")
    mixed = np.array(block.faces)
    mixed[::2] = mixed[::2, ::-1]
    trimesh.Trimesh(block.vertices, mixed, process=False).export(made / "mixed.stl")
    fin = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.1]], [[0, 1, 2]], process=False)
    fin.export(made / "triangle.stl")
    trimesh.util.concatenate([block, fin]).export(made / "open.stl")
    trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], [[0, 1, 2]], process=False).export(
        made / "line.stl"
    )
    content = bytearray((made / "box.stl").read_bytes())
    content[96:100] = struct.pack("<f", float("nan"))
    (made / "nan.stl").write_bytes(content)
    (made / "cut.stl").write_bytes(content[:200])
    (made / "empty.stl").write_bytes(b"")
    (made / "index.obj").write_text("v 0 0 0\nv 1 0 0\nf 1 2 9\n", encoding="ascii")
    large = trimesh.creation.box((10.0, 10.0, 20.0))
    text = export_collada(large).decode()
    asset = re.search(r"<asset>.*?</asset>", text, re.DOTALL)
    for name, unit in (("cm", COLLADA), ("zero", COLLADA.replace("0.01", "0")), ("metres", "")):
        head = f"<asset>{unit}<up_axis>Z_UP</up_axis></asset>"
        one = (
            text.replace(asset[0], head)
            if asset
            else re.sub(r"(<COLLADA[^>]*>)", rf"\1{head}", text, count=1)
        )
        (made / f"{name}.dae").write_text(one, encoding="utf-8")
    return made


def given(folder: Path, text: str | bytes) -> str:
    path = folder / "arm.urdf"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return register(path)


def mesh(name: str, more: str = "") -> str:
    return arm_urdf(shape=f'<mesh filename="{name}"{more}/>')


def shape(text: str) -> str:
    return arm_urdf(shape=text)


def joint(old: str, new: str, every: bool = False) -> str:
    text = arm_urdf()
    assert old in text
    return text.replace(old, new) if every else text.replace(old, new, 1)


def versioned(text: str, version: str = "1.1") -> str:
    return text.replace("<robot ", f'<robot version="{version}" ', 1)


PLACE = '<origin xyz="0 0 0.14"/>'
LIMIT = '<limit lower="-2.7" upper="2.7" velocity="2" effort="1"/>'
PLATE = (
    '<link name="ground"><collision><geometry><box size="{size}"/></geometry></collision></link>'
    '<joint name="to ground" type="fixed"><parent link="base"/><child link="ground"/></joint>'
)

ARMS: dict[str, str | bytes] = {
    "flat box": shape('<box size="0.1 0.1 0"/>'),
    "disc": shape('<cylinder radius="0.05" length="0"/>'),
    "balls": shape('<sphere radius="0.06"/>'),
    "capsules": shape('<capsule radius="0.05" length="{length}"/>'),
    "capsules that are balls": shape('<capsule radius="0.05" length="0"/>'),
    "a triangle": mesh("triangle.stl"),
    "an open mesh": mesh("open.stl"),
    "inside out": mesh("inside_out.stl"),
    "faces to both sides": mesh("mixed.stl"),
    "mirrored": mesh("box.stl", ' scale="-1 1 1"'),
    "mirrored thrice": mesh("box.stl", ' scale="-1 -1 -1"'),
    "flattened": mesh("box.stl", ' scale="1 1 0"'),
    "one scale": mesh("box.stl", ' scale="1"'),
    "ASCII": mesh("ascii.stl"),
    "OBJ": mesh("box.obj"),
    "GLB": mesh("box.glb"),
    "PLY": mesh("box.ply"),
    "COLLADA in centimetres": mesh("cm.dae"),
    "a package": mesh("package://arm_meshes/box.stl"),
    "few shapes": re.sub(r'(<link name="l[12356]">)<visual>.*?</collision>(</link>)', r"\1\2", arm_urdf()),
    "a mimic gripper": arm_urdf(
        more='<link name="f"/><joint name="f" type="prismatic"><parent link="l6"/><child link="f"/><mimic joint="l1"/></joint>'
    ),
    "no stops": arm_urdf(kind="continuous"),
    "letters": arm_urdf().replace('"l', '"ž λ '),
    "names of ours": arm_urdf().replace('"l', '"arm_joint_'),
    "universe": arm_urdf().replace('"base"', '"universe"'),
    "long axes": joint('xyz="0 1 0"', 'xyz="0 5 0"', every=True),
    "no effort": joint(' effort="1"', "", every=True),
    "no speed": joint(' velocity="2"', "", every=True),
    "byte order mark": b"\xef\xbb\xbf" + arm_urdf().encode(),
    "UTF-16": arm_urdf().encode("utf-16"),
    "an entity": '<!DOCTYPE robot [<!ENTITY h "0.14">]>' + joint("0 0 0.14", "0 0 &h;", every=True),
    "a namespace": joint("<robot ", '<robot xmlns="http://www.ros.org" '),
    "of other programs": arm_urdf(
        more='<gazebo reference="l1"><x/></gazebo><transmission name="t"/><ros2_control/>'
    ),
    "quaternions": versioned(joint(PLACE, '<origin xyz="0 0 0.14" quat_xyzw="0 0 2 2"/>', every=True)),
    "paint": joint(
        "</visual>", '<material name="p"><color rgba="1 0.5 0 1"/></material></visual>', every=True
    ),
}

REFUSED: dict[str, str | bytes] = {
    "a line for a box": shape('<box size="0.1 0 0"/>'),
    "a negative box": shape('<box size="0.1 0.1 -1"/>'),
    "a box of nan": shape('<box size="nan 1 1"/>'),
    "a box of two": shape('<box size="0.1 0.1"/>'),
    "commas": shape('<box size="0,1 0,1 0,1"/>'),
    "no ball": shape('<sphere radius="0"/>'),
    "tiny balls": shape('<sphere radius="0.0005"/>'),
    "a capsule without length": shape('<capsule radius="0.05"/>'),
    "a needle": shape('<cylinder radius="0" length="0.1"/>'),
    "a cone": shape('<cone radius="1" length="1"/>'),
    "a line for a mesh": mesh("line.stl"),
    "a corner of nan": mesh("nan.stl"),
    "cut off": mesh("cut.stl"),
    "empty": mesh("empty.stl"),
    "index": mesh("index.obj"),
    "no name": mesh(""),
    "a long name": mesh("x" * 5000),
    "scaled to a point": mesh("box.stl", ' scale="0 0 0"'),
    "two scales": mesh("box.stl", ' scale="1 1"'),
    "another attribute": mesh("box.stl", ' unit="mm"'),
    "millimetres": mesh("box.stl", ' scale="1000 1000 1000"'),
    "scaled twice": mesh("box.stl", ' scale="0.001 0.001 0.001"'),
    "COLLADA without unit": mesh("metres.dae"),
    "COLLADA of no size": mesh("zero.dae"),
    "ground": arm_urdf(more=PLATE.format(size="20 20 0.01")),
    "a stage": arm_urdf(more=PLATE.format(size="1.9 1.9 0.05")),
    "a shape far away": arm_urdf().replace('<origin xyz="0 0 0.07"/>', '<origin xyz="0 0 70"/>'),
    "planar": arm_urdf(kind="planar"),
    "a hinge": arm_urdf(kind="hinge"),
    "degrees": joint('lower="-2.7" upper="2.7"', 'lower="-170" upper="170"'),
    "huge stops": joint('upper="2.7"', 'upper="1e300"'),
    "a stop of nan": joint('lower="-2.7"', 'lower="nan"'),
    "a word for a stop": joint('lower="-2.7"', 'lower="left"'),
    "lower left out": joint('lower="-2.7" ', ""),
    "no limit": joint(LIMIT, ""),
    "no direction": joint('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>'),
    "half an axis": joint('<axis xyz="0 1 0"/>', '<axis xyz="0 1"/>'),
    "an axis without xyz": joint('<axis xyz="0 1 0"/>', "<axis/>"),
    "half an origin": joint(PLACE, '<origin xyz="0 0.14"/>'),
    "an origin with commas": joint(PLACE, '<origin xyz="0, 0, 0.14"/>'),
    "an empty origin": joint(PLACE, '<origin xyz=""/>'),
    "infinity": joint(PLACE, '<origin xyz="0 0 inf"/>'),
    "as Python writes numbers": joint(PLACE, '<origin xyz="0 0 1_0"/>'),
    "hexadecimal": joint(PLACE, '<origin xyz="0 0 0x1"/>'),
    "an overflow": joint(PLACE, '<origin xyz="0 0 1e308"/>'),
    "two origins": joint(PLACE, 2 * PLACE),
    "quaternions too early": joint(PLACE, '<origin quat_xyzw="0 0 0 1"/>'),
    "two turns": versioned(joint(PLACE, '<origin rpy="0 0 1" quat_xyzw="0 0 0 1"/>')),
    "no turn": versioned(joint(PLACE, '<origin quat_xyzw="0 0 0 0"/>')),
    "other quaternions": joint(PLACE, '<origin quat_wxyz="1 0 0 0"/>'),
    "the next version": versioned(arm_urdf(), "2.0"),
    "not a version": versioned(arm_urdf(), "abc"),
    "one name for joints": re.sub(r'<joint name="l."', '<joint name="j"', arm_urdf()),
    "one name for links": arm_urdf(more='<link name="l6"/>'),
    "one name for colours": arm_urdf(more=2 * '<material name="a"><color rgba="1 1 1 1"/></material>'),
    "no name for a link": arm_urdf(more="<link/>"),
    "no child": joint('<child link="l2"/>', ""),
    "no such link": joint('<parent link="l1"/>', '<parent link="x"/>'),
    "a circle": arm_urdf(
            more='<link name="a"/><link name="b"/><joint name="x" type="fixed"><parent link="a"/><child link="b"/></joint>'
            '<joint name="y" type="fixed"><parent link="b"/><child link="a"/></joint>'
        ),
    "two shapes in one": joint("<geometry>", '<geometry><sphere radius="0.1"/>'),
    "an empty geometry": shape(" "),
    "a word for a colour": joint("</visual>", '<material><color rgba="1 x 0 1"/></material></visual>'),
    "rest": arm_urdf() + "garbage",
    "left from xacro": joint("0.14", "${h}"),
    "an external entity": '<!DOCTYPE r [<!ENTITY h SYSTEM "file:///etc/passwd">]>' + joint("0.14", "&h;"),
    "an encoding": b'<?xml version="1.0" encoding="foo"?>' + arm_urdf().encode(),
    "multibyte": b'<?xml version="1.0" encoding="shift_jis"?>' + arm_urdf().encode(),
    "bytes": bytes(range(256)),
}  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize("case", ARMS)
def test_an_arm_has_capsules_and_is_drawn_solid(
    case: str, folder: Path, registry: None, capfd: pytest.CaptureFixture[str]
) -> None:
    made = robot(given(folder, ARMS[case]))
    assert made.model.nv == 6 and all(
        np.isfinite([*c.start, *c.end, c.radius]).all() and c.radius > 0.01 for c in made.capsules
    )
    links = robot_link_meshes(made.key, False)
    assert len(links) == 7 and all(links)
    for parts in links:
        for part in parts.values():
            normals = np.asarray(part.vertex_normals)[part.faces].mean(axis=1)
            outward = np.asarray(part.triangles_center) - np.asarray(part.vertices).mean(axis=0)
            shares = np.einsum("ij,ij->i", normals, outward)
            assert shares.sum() > -1e-9, "normals point inwards"
    assert capfd.readouterr() == ("", "")


def test_a_refusal_is_one_sentence(
    folder: Path, registry: None, capfd: pytest.CaptureFixture[str], approve: Approve
) -> None:
    said = refusals(REFUSED, lambda text: robot(given(folder, text)))
    assert capfd.readouterr() == ("", "")
    approve("refused variants.txt", refusal_lines(said, folder, "en"))


def test_a_capsule_is_used_unchanged(folder: Path, registry: None) -> None:
    capsules = robot(given(folder, shape('<capsule radius="0.0437" length="{length}"/>'))).capsules
    upper = next(capsule for capsule in capsules if capsule.name == "link 2")
    ends = sorted((upper.start.tolist(), upper.end.tolist()))
    assert upper.radius == 0.0437
    np.testing.assert_allclose(ends, ([0, 0, 0], [0, 0, 0.14]), atol=1e-12)


def test_rotations_as_quaternions_and_as_angles_give_the_same_arm(folder: Path, registry: None) -> None:
    place = '<origin xyz="0 0 0.14" {turn}/>'
    crooked = arm_urdf(shape='<box size="0.3 0.05 0.05"/>').replace(
        '<origin xyz="0 0 0.07"/>', '<origin xyz="0 0 0.07" {turn}/>'
    )
    angles, quaternions = (
        versioned(crooked.replace(PLACE, place)).replace("{turn}", turn)
        for turn in ('rpy="0 1.5707963267948966 0"', 'quat_xyzw="0 0.7071067811865476 0 0.7071067811865476"')
    )
    one, other = (robot(given(folder, text)) for text in (angles, quaternions))
    assert one.key != other.key
    for a, b in zip(one.capsules, other.capsules, strict=True):
        np.testing.assert_allclose([*a.start, *a.end, a.radius], [*b.start, *b.end, b.radius], atol=1e-9)
    for a, b in zip(one.model.jointPlacements, other.model.jointPlacements, strict=True):
        np.testing.assert_allclose(a.homogeneous, b.homogeneous, atol=1e-12)
    box = np.array([(x, 0.0, z) for x in (-0.025, 0.025) for z in (-0.08, 0.22)])
    upper = next(capsule for capsule in other.capsules if capsule.name == "link 2")
    assert beyond(box, upper.start, upper.end, upper.radius).max() <= 1e-9


def test_mirrored_and_centimetre_meshes_have_the_same_size_as_others(folder: Path, registry: None) -> None:
    usual = robot(given(folder, mesh("box.stl"))).capsules
    for text in (mesh("box.stl", ' scale="-1 1 1"'), mesh("cm.dae"), mesh("inside_out.stl")):
        for a, b in zip(usual, robot(given(folder, text)).capsules, strict=True):
            assert a.radius == b.radius


def test_meshes_of_a_file_are_stored_before_a_visitor_comes(
    folder: Path, registry: None, tmp_path: Path
) -> None:
    with own_cache(tmp_path, robot_glbs):
        key = given(folder, ARMS["few shapes"])
        draw_given(key)
        robot_glbs.cache_clear()
        with glb.stored_only():
            for palette in PALETTES:
                assert all(len(robot_glbs(key, palette, coarse)) == 7 for coarse in (False, True))


def test_an_undrawable_mesh_gives_one_sentence(folder: Path, registry: None, tmp_path: Path) -> None:
    with own_cache(tmp_path, robot_glbs):
        key = given(folder, mesh("ascii.stl"))
        robot(key)
        robot_link_meshes.cache_clear()
        known = GIVEN[key]
        assert isinstance(known, FileRobot)
        stl = known.file.meshes["ascii.stl"]
        kept = stl.read_bytes()
        try:
            stl.write_bytes(b"gone")
            with pytest.raises(BadInputFile, match=r"ascii\.stl: cannot"):
                draw_given(key)
        finally:
            stl.write_bytes(kept)
