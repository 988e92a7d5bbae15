"""A robot with capsules around its shapes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import pinocchio as pin

from app.features.robot_files.plausible_sizes import ShapeKind, Solid, check_sizes
from app.features.robot_files.robot_file import RobotFile
from app.features.robot_files.urdf_chain import chain_model, frame_names, hand_frame, landmarks
from app.features.robot_files.urdf_shapes import form_meshes
from app.features.robot_files.urdf_tree import Pill, UrdfTree, read_urdf
from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.robots.description import Capsule, Robot

MOST_TRIANGLES: Final = 1_500_000
"""Of all meshes together."""


@dataclass(frozen=True)
class FileArm:
    """The arm without its slow parts, on its column of height `column` [m]."""

    file: RobotFile
    tree: UrdfTree
    model: pin.Model
    column: float

    def robot(self, capsules: tuple[Capsule, ...]) -> Robot:
        labels = tuple(f"joint {i}" for i in range(1, self.model.njoints))
        name = self.file.key.rpartition("-")[0]
        named = self.file.chain.hand
        hand = frame_names(self.tree)[named] if named else hand_frame(self.model)[0]
        return Robot(self.file.key, name, self.model, hand, *landmarks(self.model), capsules, labels)


def load_arm(file: RobotFile) -> FileArm:
    """Raises `BadInputFile` as `chain_model`."""
    tree = read_urdf(file.text, str(file.path))
    model, column = chain_model(tree, file.chain.joints, str(file.path))
    return FileArm(file, tree, model, column)


def solids(arm: FileArm, kind: ShapeKind) -> Iterator[Solid]:
    """Every shape, as one or more meshes.

    Raises:
        BadInputFile: unreadable mesh, or too many triangles.
    """
    frames = frame_names(arm.tree)
    left = MOST_TRIANGLES
    for link in arm.tree.links:
        frame = arm.model.frames[arm.model.getFrameId(frames[link.name], pin.FrameType.BODY)]
        for shape in link.visuals if kind == "visuals" else link.collisions:
            pose = frame.placement.homogeneous @ shape.pose
            for mesh, own in form_meshes(shape.form, arm.file.meshes):
                left -= len(mesh.faces)
                if left < 0:
                    raise BadInputFile(
                        "{name}: its shapes have more than {count} triangles; give a robot with simpler meshes.",
                        name=arm.file.path,
                        count=MOST_TRIANGLES,
                    )
                mesh.apply_transform(pose)
                colour = (
                    own if kind == "collisions" or shape.colour is None else 255.0 * np.array(shape.colour)
                )
                yield Solid(link.name, frame.parentJoint, shape.form, mesh, colour, pose)


def fit_capsules(arm: FileArm) -> tuple[Capsule, ...]:
    """A capsule around each link's collision shapes, or else its visible ones. The first link and its base
    share one.

    Raises:
        BadInputFile: as `solids`; or nothing has a shape.
    """
    from scenes.robots.fitting import column_rim, enclosing_capsule, swept

    model, name = arm.model, str(arm.file.path)
    shapes: list[list[Solid]] = [[] for _ in range(model.njoints)]
    collisions, visuals = list(solids(arm, "collisions")), list(solids(arm, "visuals"))
    check_sizes(collisions, model, "collisions", name)
    check_sizes(visuals, model, "visuals", name)
    for solid in collisions:
        shapes[solid.joint].append(solid)
    bare = {joint for joint, found in enumerate(shapes) if not found}
    for solid in visuals:
        if solid.joint in bare:
            shapes[solid.joint].append(solid)
    points = [np.vstack([s.mesh.vertices for s in found]) if found else np.zeros((0, 3)) for found in shapes]
    if sum(map(len, points[1:])) == 0:
        raise BadInputFile(
            "{name}: no link has a shape; capsules are fitted around them.", name=arm.file.path
        )
    base = [points[0]]
    if arm.column:
        base.append(column_rim(arm.column))
    if len(points[1]):
        base.append(swept(model, points[1], 1, 0))
    found: list[Capsule] = []
    if len(foot := np.vstack(base)):
        found.append(Capsule("pedestal", 0, *enclosing_capsule(foot)))
    last = max(j for j in range(model.njoints) if j == 0 or len(points[j]))
    for joint in range(2, model.njoints):
        if len(points[joint]):
            called = "hand" if joint == last else f"link {joint}"
            found.append(
                Capsule(called, joint, *(_own_capsule(shapes[joint]) or enclosing_capsule(points[joint])))
            )
    return tuple(found)


def _own_capsule(shapes: list[Solid]) -> tuple[Array, Array, float] | None:
    """Capsule (centres (3,), radius [m]) that is a joint's only shape, or None."""
    from scenes.robots.fitting import SHORTEST

    (first, *more) = shapes
    if more or not isinstance(first.form, Pill) or first.form.length < SHORTEST:
        return None
    half = first.pose[:3, :3] @ np.array([0.0, 0.0, first.form.length / 2.0])
    return first.pose[:3, 3] - half, first.pose[:3, 3] + half, first.form.radius
