"""Arms of the package example-robot-data: its URDF and collision meshes → a Robot whose capsules are computed from them."""

import importlib.metadata
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import coal
import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull

from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.robots.description import Capsule, Robot, RobotName
from scenes.robots.enclosing import enclosing_capsule

PACKAGE: Final = "example-robot-data"

TURNS: Final = 32
"""In how many steps a link is turned about its joint to find what it sweeps."""

COLUMN_RADIUS: Final = 0.075
"""Of the foot of a column [m]."""

BALL_POINTS: Final = 400
"""On a sphere that a capsule must contain."""

FINE: Final = 0.008
"""Longest edge of the triangles when a link is covered by two capsules [m]."""


@dataclass(frozen=True)
class Segment:
    """What one capsule encloses.

    Attributes:
        name: part of the arm, as a person calls it.
        joint: index of the joint that carries the capsule and whose link it encloses.
        rolled: index of a neighbouring joint whose link it encloses too, however the joint between the two is turned, or None.
        ball: joint and radius: it also encloses this ball about the origin of a joint that is at rest in its frame [m].
        without: radius: of the rolled link it need not enclose what is in a ball about that link's own joint, as another capsule
            does [m].
    """

    name: str
    joint: int
    rolled: int | None = None
    ball: tuple[int, float] | None = None
    without: float = 0.0


@dataclass(frozen=True)
class Example:
    """What Duet adds to a robot of the package.

    Attributes:
        name: of the make.
        urdf: in the package's folder of robots.
        locked: joints → the position in which they are held; they are not part of the arm.
        hand: name of the hand frame.
        shoulder, elbow, wrist: indices of the joints whose origins are these points.
        segments: of its collision model, base first.
        labels: what a person calls each joint.
        column: height of a column under its foot, which then counts as part of its base [m].
    """

    name: str
    urdf: str
    locked: dict[str, float]
    hand: str
    shoulder: int
    elbow: int
    wrist: int
    segments: tuple[Segment, ...]
    labels: tuple[str, ...]
    column: float = 0.0


SHOULDER: Final = 0.141
"""Radius of the ball in which the Panda's shoulder turns [m]."""

PANDA: Final = Example(
    "Franka Emika Panda",
    # Not panda_collision.urdf beside it: the cylinders and spheres there are 30 mm thicker than the arm, as a margin.
    "panda_description/urdf/panda.urdf",
    {"panda_finger_joint1": 0.02, "panda_finger_joint2": 0.02},
    "panda_hand_tcp",
    2,
    4,
    6,
    (
        # Both halves of the shoulder, whose axis turns with joint 1, stay inside this ball; beyond it there is the upper arm's tube.
        Segment("pedestal", 0, rolled=1, ball=(2, SHOULDER)),
        Segment("upper arm", 3, rolled=2, without=SHOULDER),
        Segment("elbow", 4),
        Segment("forearm", 5),
        Segment("wrist", 6),
        Segment("hand", 7),
    ),
    ("base turn", "shoulder", "upper-arm roll", "elbow", "forearm roll", "wrist", "flange roll"),
)

UR5: Final = Example(
    "Universal Robots UR5",
    "ur_description/urdf/ur5_robot.urdf",
    {},
    "tool0",
    2,
    3,
    4,
    (
        Segment("pedestal", 0, rolled=1),
        Segment("upper arm", 2),
        Segment("forearm", 3),
        Segment("wrist", 4),
        Segment("hand", 5, rolled=6),
    ),
    ("base turn", "shoulder", "elbow", "wrist bend", "wrist turn", "flange roll"),
    # Its shoulder is low and beside its foot: as close together as the torso's plates are, two of them could not help touching.
    # On the column the shoulder is as high as the LWR's.
    column=0.221,
)

EXAMPLES: Final[dict[RobotName, Example]] = {"panda": PANDA, "ur5": UR5}


def build_example(example: Example) -> Robot:
    """Return a robot of the package.

    Raises:
        BadSetting: the package is not installed, or not all of it.
    """
    model, collision = load_example(example, pin.GeometryType.COLLISION)
    shapes = [link_triangles(collision, joint) for joint in range(model.njoints)]
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    capsules = []
    for segment in example.segments:
        points = [shapes[segment.joint].reshape(-1, 3)]
        if segment.joint == 0 and example.column:
            points.append(_column(example.column))
        if segment.rolled is not None:
            rolled = shapes[segment.rolled]
            if segment.without:
                rolled = _beyond(_refined(rolled), segment.without)
            points.append(_swept(model, rolled.reshape(-1, 3), segment.rolled, segment.joint))
        if segment.ball is not None:
            joint, radius = segment.ball
            points.append(data.oMi[segment.joint].actInv(data.oMi[joint]).translation + _sphere(radius))
        capsules.append(Capsule(segment.name, segment.joint, *enclosing_capsule(np.vstack(points))))
    return Robot(
        example.name,
        model,
        example.hand,
        example.shoulder,
        example.elbow,
        example.wrist,
        tuple(capsules),
        example.labels,
    )


def load_example(example: Example, kind: pin.GeometryType) -> tuple[pin.Model, pin.GeometryModel]:
    """Return a robot's model without its locked joints, and its collision or visual shapes, whose meshes are read.

    Raises:
        BadSetting: the package is not installed, or not all of it.
    """
    folder = _robots_folder()
    file = str(folder / example.urdf)
    try:
        model = pin.buildModelFromUrdf(file)
        # Meshes are named package://example-robot-data/robots/…, so the package's own folder is two above.
        shapes = pin.buildGeomFromUrdf(model, file, kind, package_dirs=[str(folder.parent.parent)])
    except (ValueError, RuntimeError) as error:
        reason = str(error).splitlines()[0]
        raise BadSetting(f"{example.name}: {PACKAGE} is damaged ({reason}). {_REMEDY}") from error
    reference = pin.neutral(model)
    for joint, position in example.locked.items():
        reference[model.joints[model.getJointId(joint)].idx_q] = position
    locked = [model.getJointId(joint) for joint in example.locked]
    model, (shapes,) = pin.buildReducedModel(model, [shapes], locked, reference)
    lift = pin.SE3(np.eye(3), np.array([0.0, 0.0, example.column]))
    return pin.appendModel(pin.Model(), model, pin.GeometryModel(), shapes, 0, lift) if example.column else (model, shapes)


_REMEDY: Final = f"Install it with: pip install --force-reinstall {PACKAGE}; or choose the robot lwr, which needs nothing."


def _robots_folder() -> Path:
    try:
        files = importlib.metadata.files(PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        raise BadSetting(
            f"This robot needs the package {PACKAGE}. Install it with: pip install {PACKAGE}; or choose the robot lwr, which needs nothing."
        ) from None
    for file in files:
        parts = file.parts
        if "robots" in parts and PACKAGE in parts:
            return Path(str(file.locate())).parents[len(parts) - 2 - parts.index("robots")]
    raise BadSetting(f"{PACKAGE} is installed without its robots. {_REMEDY}")


def link_triangles(shapes: pin.GeometryModel, joint: int) -> Array:
    """Return the corners (k, 3, 3) of the triangles of all shapes that move with a joint, in its frame [m]."""
    found = [np.zeros((0, 3, 3))]
    for body in shapes.geometryObjects:
        if body.parentJoint == joint:
            corners = _triangles(body.geometry)
            found.append(corners @ body.placement.rotation.T + body.placement.translation)
    return np.concatenate(found)


def _triangles(shape: coal.CollisionGeometry) -> Array:
    if isinstance(shape, coal.Box):
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * shape.halfSide
        return corners[ConvexHull(corners).simplices]
    faces = [[triangle[0], triangle[1], triangle[2]] for triangle in map(shape.tri_indices, range(shape.num_tris))]
    return np.array(shape.vertices())[np.array(faces)]


def _refined(triangles: Array) -> Array:
    """Split triangles (k, 3, 3) in four until no edge is longer than FINE."""
    done = []
    while len(triangles):
        long = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1) > FINE
        done.append(triangles[~long])
        a, b, c = np.moveaxis(triangles[long], 1, 0)
        ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
        triangles = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return np.concatenate(done)


def _sphere(radius: float) -> Array:
    """Return points (k, 3) just outside a sphere about the origin, whose hull contains it, on a golden spiral."""
    k = np.arange(BALL_POINTS)
    z, turn = 1.0 - (2.0 * k + 1.0) / BALL_POINTS, k * np.pi * (3.0 - np.sqrt(5.0))
    points = np.column_stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    # The planes of the hull's faces lie nearer than its corners.
    return points * (radius / -float(ConvexHull(points).equations[:, 3].max()))


def _column(height: float) -> Array:
    """Return points (k, 3) around the foot of a column under a base, whose hull contains its lower rim."""
    angle = 2.0 * np.pi * np.arange(TURNS) / TURNS
    r = COLUMN_RADIUS / np.cos(np.pi / TURNS)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), np.zeros(TURNS)])


def _beyond(triangles: Array, radius: float) -> Array:
    """Return the triangles that are not wholly inside a ball about the origin."""
    return triangles[np.linalg.norm(triangles, axis=2).max(axis=1) > radius]


def _swept(model: pin.Model, points: Array, joint: int, carrier: int) -> Array:
    """Return points of a joint's link, at all angles of the joint between it and a neighbouring carrier, in the carrier's frame.

    The turns stand a little farther out, so that their hull contains all that is swept between them.
    """
    points = points[ConvexHull(points).vertices]
    turning = max(joint, carrier)
    placement = model.jointPlacements[turning]
    axis = joint_axis(model, turning)
    angles = 2.0 * np.pi * np.arange(TURNS) / TURNS
    if carrier == turning:
        points = (points - placement.translation) @ placement.rotation
    along = np.outer(points @ axis, axis)
    points = along + (points - along) / np.cos(np.pi / TURNS)
    turned = np.concatenate([points @ pin.exp3(axis * angle).T for angle in angles])
    return turned if carrier == turning else turned @ placement.rotation.T + placement.translation


def joint_axis(model: pin.Model, joint: int) -> Array:
    """Return the unit axis (3,) of a revolute joint, in its frame."""
    data = model.joints[joint].createData()
    model.joints[joint].calc(data, np.zeros(1))
    return np.array(data.S).reshape(-1)[3:]
