"""Arms of the package example-robot-data, with what Duet adds."""

import importlib.metadata
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.errors import BadSetting, LazyText, first_line
from scenes.lwr.facts import JOINT_LABELS
from scenes.robots.description import Capsule, Robot
from scenes.settings import RobotName

PACKAGE: Final = "example-robot-data"

COLUMN_RADIUS: Final = 0.075
"""Radius of the foot of a column [m]."""


@dataclass(frozen=True)
class Segment:
    """Contents of one capsule.

    Attributes:
        joint: carries the capsule, which encloses its link.
        rolled: a neighbouring joint, enclosed at any angle; or None.
        ball: joint at rest in the capsule's frame, and radius of an enclosed ball about it [m].
        without: radius of a ball about the rolled joint that another capsule encloses [m].
    """

    name: str
    joint: int
    rolled: int | None = None
    ball: tuple[int, float] | None = None
    without: float = 0.0


@dataclass(frozen=True)
class Example:
    """Additions to a robot of the package.

    Attributes:
        urdf: in the package's folder of robots.
        locked: joints outside the arm → fixed position.
        shoulder, elbow, wrist: indices of joints.
        segments: base first.
        starts: rig → left and right posture (n,) [deg]: clear of the other arm, elbow bent, hand in front,
            away from its own base, which cannot give way; mirrored on a torso.
        views: rig → height of the view's middle, width and height [m].
        paints: colour in the package → nearest material.
        column: height of a column under its foot [m].
    """

    key: RobotName
    name: str
    urdf: str
    locked: dict[str, float]
    hand: str
    shoulder: int
    elbow: int
    wrist: int
    segments: tuple[Segment, ...]
    labels: tuple[str, ...]
    starts: dict[str, tuple[tuple[float, ...], tuple[float, ...]]]
    views: dict[str, tuple[float, float, float]]
    paints: dict[tuple[int, int, int], str]
    column: float = 0.0

    def robot(self, model: pin.Model, capsules: tuple[Capsule, ...]) -> Robot:
        return Robot(
            self.key,
            self.name,
            model,
            self.hand,
            self.shoulder,
            self.elbow,
            self.wrist,
            capsules,
            self.labels,
        )


SHOULDER: Final = 0.141
"""Radius of the ball of the Panda's shoulder [m]."""

PANDA: Final = Example(
    "panda",
    "Franka Emika Panda",
    # Not panda_collision.urdf beside it: the cylinders and spheres there are 30 mm thicker than the arm, as a margin.
    "panda_description/urdf/panda.urdf",
    {"panda_finger_joint1": 0.02, "panda_finger_joint2": 0.02},
    "panda_hand_tcp",
    2,
    4,
    6,
    (
        # Both halves of the shoulder, turned by joint 1, stay inside this ball; beyond it is the upper arm.
        Segment("pedestal", 0, rolled=1, ball=(2, SHOULDER)),
        Segment("upper arm", 3, rolled=2, without=SHOULDER),
        Segment("elbow", 4),
        Segment("forearm", 5),
        Segment("wrist", 6),
        Segment("hand", 7),
    ),
    JOINT_LABELS,
    # Mirrored, the odd joints change sign; its hand sits 45° off, so that joint 7 mirrors about that.
    {
        "torso": (
            (-44.0, -72.0, -85.0, -63.0, 25.0, 121.0, 48.0),
            (44.0, -72.0, 85.0, -63.0, -25.0, 121.0, 42.0),
        ),
        "table": ((0.0, -28.0, 0.0, -90.0, 0.0, 62.0, 45.0), (0.0, -28.0, 0.0, -90.0, 0.0, 62.0, 45.0)),
    },
    {"torso": (1.23, 1.60, 1.02), "table": (1.34, 1.85, 1.44)},
    {
        (255, 255, 255): "body",
        (230, 235, 237): "cover",
        (64, 64, 64): "dark",
        (10, 138, 199): "mark",
        (255, 0, 0): "mark",
        (0, 255, 0): "mark",
    },
)

UR5: Final = Example(
    "ur5",
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
    # Mirrored, an arm that runs beside its foot turns its base half round and folds the other way.
    {
        "torso": ((-162.0, -54.0, 74.0, -23.0, 56.0, 0.0), (-18.0, -126.0, -74.0, -157.0, -56.0, 0.0)),
        "table": ((-30.0, -115.0, 105.0, -80.0, -90.0, 0.0), (-30.0, -115.0, 105.0, -80.0, -90.0, 0.0)),
    },
    {"torso": (1.07, 1.90, 0.95), "table": (1.35, 1.85, 1.48)},
    {
        (36, 36, 36): "body",
        (64, 89, 104): "cover",
        (80, 111, 131): "cover",
        (13, 13, 13): "ring",
        (25, 26, 28): "ring",
        (55, 55, 55): "metal",
        (107, 107, 107): "metal",
        (134, 134, 134): "metal",
    },
    # Its shoulder is low and beside its foot: two of them would touch at the distance of the torso's plates.
    # On the column the shoulder is as high as the LWR's.
    column=0.221,
)

EXAMPLES: Final[dict[str, Example]] = {example.key: example for example in (PANDA, UR5)}


def load_example(
    example: Example, kind: pin.GeometryType | None = None
) -> tuple[pin.Model, pin.GeometryModel]:
    """Model without locked joints, and its collision or visual shapes, if any.

    Raises:
        BadSetting: the package is not installed, or not all of it.
    """
    folder = _robots_folder()
    file = str(folder / example.urdf)
    try:
        model = pin.buildModelFromUrdf(file)
        # Meshes are named package://example-robot-data/robots/…, so the package's own folder is two above.
        shapes = pin.GeometryModel()
        if kind is not None:
            shapes = pin.buildGeomFromUrdf(model, file, kind, package_dirs=[str(folder.parent.parent)])
    except (ValueError, RuntimeError) as error:
        raise BadSetting(
            "{robot}: {package} is damaged ({reason}). {remedy}",
            robot=example.name,
            package=PACKAGE,
            reason=first_line(error),
            remedy=_REMEDY,
        ) from error
    reference = pin.neutral(model)
    for joint, position in example.locked.items():
        reference[model.joints[model.getJointId(joint)].idx_q] = position
    locked = [model.getJointId(joint) for joint in example.locked]
    model, (shapes,) = pin.buildReducedModel(model, [shapes], locked, reference)
    lift = pin.SE3(np.eye(3), np.array([0.0, 0.0, example.column]))
    return (
        pin.appendModel(pin.Model(), model, pin.GeometryModel(), shapes, 0, lift)
        if example.column
        else (model, shapes)
    )


_REMEDY: Final = LazyText(
    "Install it with: pip install --force-reinstall {package}; or choose the robot lwr, which needs nothing.",
    package=PACKAGE,
)


def urdf_files() -> tuple[Path, ...]:
    """URDF files of the package, sorted.

    Raises:
        BadSetting: as `load_example`.
    """
    return tuple(sorted(_robots_folder().rglob("*.urdf")))


def _robots_folder() -> Path:
    try:
        files = importlib.metadata.files(PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        raise BadSetting(
            "This robot needs the package {package}. Install it with: pip install {package}; "
            "or choose the robot lwr, which needs nothing.",
            package=PACKAGE,
        ) from None
    for file in files:
        parts = file.parts
        if "robots" in parts and PACKAGE in parts:
            return Path(str(file.locate())).parents[len(parts) - 2 - parts.index("robots")]
    raise BadSetting("{package} is installed without its robots. {remedy}", package=PACKAGE, remedy=_REMEDY)
