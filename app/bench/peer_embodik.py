"""The hold experiment in embodik (Pinocchio, coal and its own solver, all in C++): `FrameTask` and its collision constraint.

Settings: weight K of the task, which is its gain in 1/s there; full exact collision checks, a row a pair; all else embodik's defaults. Its
collision constraint has no gain of its own. With w the guided joints' velocities are equality rows (as a task of higher priority its solver
slows them down near the other arm); without, these joints have speed 0 for the solver.
"""

import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, Final

import embodik
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from app.bench.peer_hold import Baked
from controllers.kinematics import Array

ENOUGH: Final = 100.0
"""More than any joint's speed, or than any joint's angle."""

HAND: Final = "hand"


def urdf_text(baked: Baked) -> str:
    """Return our model as URDF: the same joints, one link a capsule under its own name, the avoiding hand as the link "hand"."""
    room = baked.room
    model = room.model
    root = ElementTree.Element("robot", name="duet")
    _link(root, "universe")
    data = model.createData()
    pin.forwardKinematics(model, data, np.ones(model.nq))
    for i in range(1, model.njoints):
        name, column = model.names[i], model.joints[i].idx_v
        _link(root, f"body {name}")
        joint = _joint(root, name, "revolute", _body(model, model.parents[i]), f"body {name}", model.jointPlacements[i])
        axis = pin.log3(model.jointPlacements[i].actInv(data.liMi[i]).rotation)
        ElementTree.SubElement(joint, "axis", xyz=_text(axis / np.linalg.norm(axis)))
        free = baked.guided.start <= column < baked.guided.stop
        low, high, speed = (
            (-ENOUGH, ENOUGH, ENOUGH)
            if free
            else (model.lowerPositionLimit[column], model.upperPositionLimit[column], model.velocityLimit[column])
        )
        ElementTree.SubElement(
            joint, "limit", lower=repr(float(low)), upper=repr(float(high)), velocity=repr(float(speed)), effort="1000"
        )
    for capsule in room.geometry.geometryObjects:
        link = _link(root, capsule.name)
        _joint(root, f"at {capsule.name}", "fixed", _body(model, capsule.parentJoint), capsule.name, capsule.placement)
        shape, collision = capsule.geometry, ElementTree.SubElement(link, "collision", name=capsule.name)
        ElementTree.SubElement(
            ElementTree.SubElement(collision, "geometry"),
            "cylinder",
            radius=repr(float(shape.radius)),
            length=repr(2.0 * float(shape.halfLength)),
        )
        # Pinocchio reads a cylinder with this mark as a capsule.
        ElementTree.SubElement(ElementTree.SubElement(link, "collision_checking"), "capsule", name=capsule.name)
    frame = model.frames[baked.hand]
    _link(root, HAND)
    _joint(root, "at hand", "fixed", _body(model, frame.parentJoint), HAND, frame.placement)
    return ElementTree.tostring(root, encoding="unicode")


def _link(root: ElementTree.Element, name: str) -> ElementTree.Element:
    return ElementTree.SubElement(root, "link", name=name)


def _body(model: pin.Model, joint: int) -> str:
    return f"body {model.names[joint]}" if joint else "universe"


def _joint(root: ElementTree.Element, name: str, kind: str, parent: str, child: str, placement: pin.SE3) -> ElementTree.Element:
    joint = ElementTree.SubElement(root, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=_text(placement.translation), rpy=_text(pin.rpy.matrixToRpy(placement.rotation)))
    return joint


def _text(numbers: Array) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def embodik_model(baked: Baked) -> Any:
    """Return our model as embodik's."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "duet.urdf"
        path.write_text(urdf_text(baked), encoding="utf-8")
        return embodik.RobotModel(str(path))


def _columns(robot: Any, baked: Baked) -> NDArray[np.intp]:
    """Return where each of our joints is in embodik's q."""
    return np.array([robot.get_joint_config_index(name) for name in list(baked.room.model.names)[1:]], dtype=np.intp)


def _pairs(robot: Any, baked: Baked) -> list[tuple[str, str]]:
    """Return our pairs of bodies under embodik's names."""
    bodies = baked.room.geometry.geometryObjects
    names = robot.get_collision_geometry_names()
    known = {body.name: next(name for name in names if name.rpartition("_")[0] == body.name) for body in bodies}
    return [(known[bodies[pair.first].name], known[bodies[pair.second].name]) for pair in baked.room.geometry.collisionPairs]


class EmbodikArm:
    """The avoiding arm moved by embodik.

    Args:
        pairs: how many of the closest pairs have a row.
        knows_speed: whether the solver knows the guided arm's velocity.
    """

    def __init__(self, baked: Baked, pairs: int, knows_speed: bool) -> None:
        settings = baked.settings
        self._baked, self._dt, self._knows_speed = baked, settings.dt, knows_speed
        self._robot = robot = embodik_model(baked)
        self._columns = _columns(robot, baked)
        self._guided = self._columns[baked.guided]
        self._solver = solver = embodik.KinematicsSolver(robot)
        solver.dt = settings.dt
        solver.set_collision_tuning_mode(embodik.CollisionTuningMode.PRECISE)
        solver.configure_collision_constraint(
            settings.law.critical_distance, include_pairs=_pairs(robot, baked), max_constraints=pairs
        )
        solver.enable_position_limits(True)
        solver.enable_velocity_limits(True)
        hand = solver.add_frame_task(HAND, HAND)
        hand.set_target_pose(baked.place, np.asfortranarray(baked.place_rotation))
        hand.weight = settings.gain
        self._rows = np.asfortranarray(np.eye(robot.nv)[self._guided])
        if not knows_speed:
            for column in self._guided.tolist():
                solver.set_joint_velocity_limit(column, 0.0)
        self.positions = baked.room.start.copy()
        self._q = np.zeros(robot.nq)
        self.unsolved = 0
        """Steps without a solution; the arm stands still in them."""

    def prepare(self, step: int) -> None:
        """Take over where the obstacle is."""
        self.positions[self._baked.guided] = self._baked.guided_positions[step]

    def advance(self, step: int) -> Array:
        """Make one step."""
        baked = self._baked
        self._q[self._columns] = self.positions
        if self._knows_speed:
            motion = baked.guided_velocities[step]
            self._solver.set_linear_velocity_constraints(self._rows, motion, motion)
        answer = self._solver.solve_velocity(self._q)
        velocities = np.asarray(answer.joint_velocities)[self._columns]
        if answer.status != embodik.SolverStatus.SUCCESS:
            self.unsolved += 1
        velocities[baked.guided] = baked.guided_velocities[step]
        self.positions = self.positions + self._dt * velocities
        return velocities


class EmbodikEngine:
    """Distances as embodik sees them."""

    def __init__(self, baked: Baked) -> None:
        self._robot = embodik_model(baked)
        self._columns = _columns(self._robot, baked)
        bodies = baked.room.geometry.geometryObjects
        order = [(bodies[pair.first].name, bodies[pair.second].name) for pair in baked.room.geometry.collisionPairs]
        self._ours = dict(zip(map(frozenset, _pairs(self._robot, baked)), order, strict=True))
        self._q = np.zeros(self._robot.nq)

    def _take(self, positions: Array) -> None:
        self._q[self._columns] = positions
        self._robot.update_configuration(self._q)

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        """Return every pair's distance [m]."""
        self._take(positions)
        names, found = self._robot.get_collision_pair_names(), self._robot.compute_collision_distances()
        return {
            self._ours[key]: distance
            for pair, distance in zip(names, found, strict=True)
            if (key := frozenset(pair)) in self._ours
        }

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        """Return place and rotation of the avoiding hand."""
        self._take(positions)
        pose = self._robot.get_frame_pose(HAND)
        return np.array(pose.translation), np.array(pose.rotation)
