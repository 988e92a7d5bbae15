"""Any URDF file gives an arm with solid shapes at its joints, in capsules, or an error of one sentence."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin
import pytest
import trimesh
import yourdfpy
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from app.features.robot_files.robot_file import robot_file
from app.features.robot_files.urdf_chain import frame_names
from app.features.robot_files.urdf_file import fit_capsules, load_arm, solids
from controllers.errors import DuetError
from controllers.kinematics import Array
from tests.app.features.robot_files.arm_urdf import arm_urdf
from tests.scenes.helpers import beyond

pytestmark = pytest.mark.slow

lengths = st.floats(0.02, 0.3).map(lambda x: round(x, 4))
angles = st.floats(-3.1, 3.1).map(lambda x: round(x, 4))
names = st.text(
    st.characters(blacklist_categories=("Cs", "Cc"), min_codepoint=33, max_codepoint=0x3FF),
    min_size=1,
    max_size=8,
)


@dataclass
class Place:
    """A pose, as the file writes it (`turn`) and in the form of URDF 1.0 that all readers know."""

    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    as_quaternion: bool

    def text(self, plain: bool) -> str:
        numbers = " ".join(map(repr, self.xyz))
        if plain or not self.as_quaternion:
            return f'<origin xyz="{numbers}" rpy="{" ".join(map(repr, self.rpy))}"/>'
        return f'<origin xyz="{numbers}" quat_xyzw="{" ".join(map(repr, Rotation.from_euler("xyz", self.rpy).as_quat().tolist()))}"/>'


places = st.builds(
    Place, st.tuples(lengths, lengths, lengths), st.tuples(angles, angles, angles), st.booleans()
)
mesh_scales = st.tuples(*[st.sampled_from([-1.0, -0.5, 0.5, 1.0, 1.5])] * 3)


@st.composite
def forms(draw: st.DrawFn) -> tuple[str, str]:
    """A shape, and its substitute for readers of URDF 1.0."""
    kind, a, b, c = (
        draw(st.sampled_from(["box", "flat", "cylinder", "sphere", "capsule", "mesh"])),
        *draw(st.tuples(*[lengths] * 3)),
    )
    if kind == "mesh":
        scale = " ".join(map(repr, draw(mesh_scales)))
        text = f'<mesh filename="wedge.stl" scale="{scale}"/>'
    else:
        text = {
            "box": f'<box size="{a} {b} {c}"/>',
            "flat": f'<box size="{a} {b} 0"/>',
            "cylinder": f'<cylinder radius="{a / 2}" length="{b}"/>',
            "sphere": f'<sphere radius="{a / 2}"/>',
            "capsule": f'<capsule radius="{a / 2}" length="{b}"/>',
        }[kind]
    return text, text.replace("capsule", "cylinder")


@st.composite
def arms(draw: st.DrawFn) -> tuple[str, str]:
    """A URDF, and the same one written for version 1.0."""
    count = draw(st.integers(5, 7))
    called = draw(st.lists(names, min_size=count + 2, max_size=count + 2, unique=True))
    parts: list[tuple[Place, tuple[str, str]] | None] = draw(
        st.lists(st.none() | st.tuples(places, forms()), min_size=count + 2, max_size=count + 2)
    )
    assume(any(parts[2:]))
    joints = draw(
        st.lists(st.tuples(places, st.tuples(*[st.integers(-3, 3)] * 3)), min_size=count, max_size=count)
    )
    assume(all(any(axis) for _, axis in joints))
    tool = draw(places)
    texts = []
    for plain in (False, True):
        text = "<robot name='any' version='1.0'>" if plain else "<robot name='any' version='1.2'>"
        for name, part in zip(called, parts, strict=True):
            inner = "" if part is None else f"{part[0].text(plain)}<geometry>{part[1][plain]}</geometry>"
            text += (
                f"<link name={quoteattr(name)}>"
                + (f"<visual>{inner}</visual><collision>{inner}</collision>" if inner else "")
                + "</link>"
            )
        for i, (place, axis) in enumerate(joints):
            text += (
                f'<joint name="j{i}" type="{"continuous" if i == 2 else "revolute"}"><parent link={quoteattr(called[i])}/>'
                f"<child link={quoteattr(called[i + 1])}/>{place.text(plain)}"
                f'<axis xyz="{axis[0]} {axis[1]} {axis[2]}"/><limit lower="-2" upper="1.5" velocity="1" effort="1"/></joint>'
            )
        text += (
            f'<joint name="tool" type="fixed"><parent link={quoteattr(called[count])}/><child link={quoteattr(called[count + 1])}/>'
            f"{tool.text(plain)}</joint></robot>"
        )
        texts.append(text)
    return texts[0], texts[1]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("any")
    corners = [[0, 0, 0], [0.1, 0, 0], [0, 0.15, 0], [0, 0, 0.2]]
    trimesh.Trimesh(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], process=False).export(
        made / "wedge.stl"
    )
    return made


@pytest.mark.thorough
@settings(
    max_examples=25,
    suppress_health_check=[
        HealthCheck.function_scoped_fixture,
        HealthCheck.too_slow,
        HealthCheck.filter_too_much,
    ],
)
@given(arms(), st.integers(0, 99))
def test_shapes_follow_their_joints_are_solid_and_inside_their_capsules(
    folder: Path, registry: None, texts: tuple[str, str], seed: int
) -> None:
    path = folder / "arm.urdf"
    path.write_text(texts[0], encoding="utf-8")
    try:
        arm = load_arm(robot_file(path))
    except DuetError as error:
        # Usually parallel axes.
        assert "\n" not in str(error)
        return
    q = np.random.default_rng(seed).uniform(-1.5, 1.5, arm.model.nq)
    data = arm.model.createData()
    pin.framesForwardKinematics(arm.model, data, q)
    lift = np.eye(4)
    lift[2, 3] = arm.column
    other = other_shapes(texts[1], q)
    found = list(solids(arm, "collisions"))
    assert len(found) == len(other)
    for solid in found:
        here = data.oMi[solid.joint].homogeneous @ solid.pose
        assert_allclose(here, lift @ other[solid.link], atol=1e-6)
        frame = arm.model.frames[arm.model.getFrameId(frame_names(arm.tree)[solid.link])]
        assert frame.parentJoint == solid.joint
        assert solid.mesh.is_watertight and solid.mesh.volume > 0
    try:
        capsules = fit_capsules(arm)
    except DuetError as error:
        assert re.search(r"m large, and its arm is|no link has a shape|away from its joint", str(error))
        return
    for capsule in capsules:
        for solid in found:
            if solid.joint == capsule.joint:
                assert (
                    beyond(np.asarray(solid.mesh.vertices), capsule.start, capsule.end, capsule.radius).max()
                    <= 1e-9
                )


def other_shapes(text: str, q: Array) -> dict[str, Array]:
    """Link → pose (4, 4) of its shape in the frame of the root, as read by yourdfpy."""
    bare: Any = dict.fromkeys(("load_meshes", "load_collision_meshes", "build_collision_scene_graph"), False)
    reader = yourdfpy.URDF.load(trimesh.util.wrap_as_stream(text.encode()), **bare)
    reader.update_cfg(q)
    return {
        link.name: reader.get_transform(link.name, reader.base_link) @ link.collisions[0].origin
        for link in reader.robot.links
        if link.collisions
    }


BAD_VALUES = (
    "",
    " ",
    "nan",
    "-inf",
    "1e999",
    "0",
    "-1",
    "0 0 0",
    "1,5",
    "0 0",
    "a b c",
    "1 2 3 4",
    "${x}",
    "é",
    "1e30",
    "base",
    "l3",
    "l9",
)


@settings(
    max_examples=150,
    suppress_health_check=[
        HealthCheck.function_scoped_fixture,
        HealthCheck.too_slow,
        HealthCheck.filter_too_much,
    ],
)
@given(data=st.data())
def test_any_attribute_gives_an_arm_or_an_error_of_one_sentence(
    data: st.DataObject, folder: Path, registry: None
) -> None:
    shape = data.draw(
        st.sampled_from(
            [
                '<box size="0.1 0.1 0.1"/>',
                '<sphere radius="0.05"/>',
                '<capsule radius="0.05" length="0.1"/>',
                '<mesh filename="wedge.stl" scale="1 1 1"/>',
                '<cylinder radius="0.05" length="0.1"/>',
            ]
        )
    )
    tree = ElementTree.fromstring(arm_urdf(shape=shape).replace("<robot ", '<robot version="1.1" '))
    parts = list(tree.iter())
    for _ in range(data.draw(st.integers(1, 2))):
        part = data.draw(st.sampled_from(parts))
        key = data.draw(st.sampled_from([*part.attrib, "rpy", "quat_xyzw", "extra"]))
        match data.draw(st.sampled_from(["value", "left out", "tag", "twice"])):
            case "value":
                part.set(key, data.draw(st.sampled_from(BAD_VALUES)))
            case "left out":
                part.attrib.pop(key, None)
            case "tag":
                part.tag = data.draw(
                    st.sampled_from(["origin", "link", "mesh", "capsule", "Axis", "geometry"])
                )
            case _:
                part.extend(list(part)[:1])
    path = folder / "arm.urdf"
    path.write_bytes(ElementTree.tostring(tree))
    try:
        file = robot_file(path)
        arm = load_arm(file)
        for solid in (*solids(arm, "collisions"), *solids(arm, "visuals")):
            assert np.isfinite(solid.mesh.vertices).all()
    except DuetError as error:
        assert "\n" not in str(error) and str(error).endswith(".")


@pytest.mark.parametrize("spread", [3, 2, 1, 0])
def test_points_on_a_plane_a_line_or_one_place_are_inside_a_capsule(spread: int) -> None:
    from scenes.robots.fitting import enclosing_capsule

    turn = Rotation.from_euler("xyz", (0.3, 0.4, 0.5)).as_matrix()
    points = np.random.default_rng(1).uniform(-0.1, 0.1, (60, 3))
    points[:, spread:] = 0.0
    points = points @ turn.T + 0.2
    start, end, radius = enclosing_capsule(points)
    assert beyond(points, start, end, radius).max() <= 1e-6 and radius < 0.2
