"""The drawn person: the human model of example-robot-data, in five parts of which four turn.

Its URDF follows the International Society of Biomechanics: x forward, y up, z right, shoulder about Z
(flexion), X (abduction), Y (rotation), elbow about Z. It is turned into the torso frame, cut at shoulders and
elbows, and gets a yoke.
"""

import importlib.metadata
import math
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array
from scenes import glb, surfaces
from scenes.person.angles import SHOULDER_WIDTH, SIGN, UPPER_ARM, arm_rotation
from scenes.person.source import MissingPackage

if TYPE_CHECKING:
    import trimesh

PACKAGE: Final = "example-robot-data"

MATERIAL: Final = glb.Material("#8394a6", 0.7)

SHARE: Final = 0.16

SHOULDER_HEIGHT: Final = 1.380
"""Shoulders above the model's soles [m]."""

TORSO_FROM_MODEL: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

PALM_TURN: Final = math.pi / 2.0
"""Pronation from the model's zero to palms at the thighs [rad]."""

YOKE: Final = ((0.0, -0.225), (0.030, -0.222), (0.040, -0.19), (0.050, -0.10), (0.052, 0.0))
"""Half of the yoke's profile: radius, and place from shoulder (−) to chest (0) [m]."""

Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""


class BodyPart(NamedTuple):
    """A node of the drawing.

    Attributes:
        parent: "" for the body.
        glb: mesh in the node's frame.
        pose: in the parent's frame at zero angles; that of the body puts its soles on the floor z = 0.
    """

    name: str
    parent: str
    glb: bytes
    pose: pin.SE3


_CUTS: Final = {
    f"{side}_{part}": f"{side}_{link}"
    for side in SIGN
    for part, link in (("upper_arm", "upperarm"), ("forearm", "lowerarm"))
}
"""Node → URDF link at whose joint it begins."""


@cache
def body_parts() -> tuple[BodyPart, ...]:
    """Nodes, parents first, about 330 kB.

    Raises:
        MissingPackage: example-robot-data is not installed, or without its human model.
    """
    try:
        release = version(PACKAGE)
    except importlib.metadata.PackageNotFoundError:
        raise _missing("is not installed") from None
    key = glb.source_key([__file__, glb.__file__, surfaces.__file__], release)
    blobs = glb.cached("person", key, _build)
    nodes = {"body": ("", (0.0, 0.0, SHOULDER_HEIGHT))}
    for side, sign in SIGN.items():
        nodes[f"{side}_upper_arm"] = "body", (0.0, sign * SHOULDER_WIDTH / 2.0, 0.0)
        nodes[f"{side}_forearm"] = f"{side}_upper_arm", (0.0, 0.0, -UPPER_ARM)
    return tuple(
        BodyPart(name, parent, blob, pin.SE3(np.eye(3), np.array(place)))
        for (name, (parent, place)), blob in zip(nodes.items(), blobs, strict=True)
    )


def body_poses(angles: Array) -> dict[str, Quaternion]:
    """Node → rotation in its parent's frame. `angles`: (2, 4) [rad], left arm first."""
    poses: dict[str, Quaternion] = {}
    for i, side in enumerate(SIGN):
        turn = pin.Quaternion(arm_rotation(angles[i], side))
        half = 0.5 * float(angles[i, 3])
        poses[f"{side}_upper_arm"] = (turn.w, turn.x, turn.y, turn.z)
        # A bent elbow brings the hand forward: a turn about −y.
        poses[f"{side}_forearm"] = (math.cos(half), 0.0, -math.sin(half), 0.0)
    return poses


def _missing(what: str) -> MissingPackage:
    return MissingPackage(
        f"The drawing of a person needs the package {PACKAGE}, which {what}. Install it with: pip install {PACKAGE}"
    )


def human_urdf() -> Path:
    for file in importlib.metadata.files(PACKAGE) or []:
        if file.name == "human.urdf":
            path = Path(str(file.locate()))
            if path.is_file():
                return path
    raise _missing("is here without its human model")


def _build() -> tuple[bytes, ...]:
    meshes = person_meshes()
    return tuple(
        glb.glb({name: surfaces.thinned_mesh(meshes[name], SHARE)}, {name: MATERIAL})
        for name in ("body", *_CUTS)
    )


def person_meshes() -> dict[str, "trimesh.Trimesh"]:
    """Node → mesh in its frame [m].

    Raises:
        MissingPackage: the human model is missing.
    """
    import trimesh

    path = human_urdf()
    # Meshes are named package://example-robot-data/robots/…, and the file lies in robots/human_description/robots.
    share = path.parents[4]
    model = pin.buildModelFromUrdf(str(path))
    shapes = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.VISUAL, package_dirs=[str(share)])
    data, shapes_data = model.createData(), shapes.createData()
    q = pin.neutral(model)
    for side in SIGN:
        q[model.joints[model.getJointId(f"{side}_elbow_Y")].idx_q] = PALM_TURN
    pin.updateGeometryPlacements(model, data, shapes, shapes_data, q)
    pin.updateFramePlacements(model, data)
    starts = {name: data.oMf[model.getFrameId(link)].translation.copy() for name, link in _CUTS.items()}
    joints = {name: model.frames[model.getFrameId(link)].parentJoint for name, link in _CUTS.items()}
    starts["body"] = (starts["left_upper_arm"] + starts["right_upper_arm"]) / 2.0
    pieces: dict[str, list[trimesh.Trimesh]] = {name: [] for name in starts}
    for i, shape in enumerate(shapes.geometryObjects):
        supports = model.supports[shape.parentJoint].tolist()
        carried = [name for name, joint in joints.items() if joint in supports]
        # Both joints carry a forearm: the last one along the chain counts.
        name = max(carried, key=lambda n: supports.index(joints[n]), default="body")
        piece = trimesh.load(shape.meshPath, force="mesh")
        assert isinstance(piece, trimesh.Trimesh)
        placement = shapes_data.oMg[i]
        vertices = np.asarray(piece.vertices) * shape.meshScale @ placement.rotation.T + placement.translation
        faces = np.asarray(piece.faces)
        pieces[name].append(
            trimesh.Trimesh((vertices - starts[name]) @ TORSO_FROM_MODEL.T, faces, process=False)
        )
    pieces["body"].append(_yoke())
    return {name: surfaces.join(parts) for name, parts in pieces.items()}


def _yoke() -> "trimesh.Trimesh":
    half = np.array(YOKE)
    profile = np.concatenate([half, half[-2::-1] * (1.0, -1.0)])
    yoke = surfaces.revolve(surfaces.rounded(profile, 0.02), sections=48)
    # Its axis, made along z, goes from shoulder to shoulder.
    yoke.apply_transform(np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]]))
    return yoke
