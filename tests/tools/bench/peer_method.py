"""The hold experiment without its person: input of every method of `tests.tools.bench.peers`, the base class
of peers, and our model as URDF: the same joints, one link per capsule, the avoiding hand as link "hand".
"""

import xml.etree.ElementTree as ElementTree
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array
from scenes.headless import run
from scenes.room import Room
from scenes.settings import RunSettings

PEER_GAIN: Final = 10.0
"""Gain of the peers' distance constraint above d_m [1/s]."""

SOLVER: Final = "daqp"
"""Solver of the peers' quadratic programs."""

PairDistances = dict[tuple[str, str], float]
"""Pair of bodies, left first → distance [m]."""


@dataclass(frozen=True)
class Baked:
    """The hold experiment without its person: input of every compared method.

    Attributes:
        settings: of the run with the guided arm's motion.
        room: arms, capsules, pairs.
        guided, avoiding: columns of q.
        hand: frame id of the avoiding hand.
        guided_positions, guided_velocities: (steps, n), at the beginning of and during each step [rad,
        rad/s].
        place: of the avoiding hand (3,) [m].
        place_rotation: (3, 3).
    """

    settings: RunSettings
    room: Room
    guided: slice
    avoiding: slice
    hand: int
    guided_positions: Array
    guided_velocities: Array
    place: Array
    place_rotation: Array

    @property
    def steps(self) -> int:
        return len(self.guided_positions)

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Names of both bodies of each pair, in the detector's order."""
        bodies = self.room.geometry.geometryObjects
        return [
            (bodies[pair.first].name, bodies[pair.second].name) for pair in self.room.geometry.collisionPairs
        ]


def bake(settings: RunSettings, steps: int) -> Baked:
    """Recorded motion of the guided arm in one run of the hold experiment."""
    done = run(settings, steps * settings.dt)
    simulation, table = done.simulation, done.table
    guided, avoiding = simulation.guided, simulation.avoiding
    assert simulation.keeper is not None
    return Baked(
        settings,
        simulation.room,
        guided.joints,
        avoiding.joints,
        avoiding.hand,
        simulation.history.positions(table)[:, guided.joints],
        simulation.history.velocities(table)[:, guided.joints],
        simulation.keeper.place.copy(),
        simulation.keeper.place_rotation.copy(),
    )


class Method(ABC):
    """A method of the comparison: moves the avoiding arm; its distances and poses are compared with ours.

    Attributes:
        positions: q (nv,) [rad].
        unsolved: number of steps without a solution.
    """

    positions: Array
    unsolved = 0

    def prepare(self, step: int) -> None:  # noqa: B027 (most have nothing to prepare)
        """Work before a step that is not timed."""

    @abstractmethod
    def advance(self, step: int) -> Array:
        """Make one step. Returns its q̇ (nv,) [rad/s], which may be reused."""

    @abstractmethod
    def distances(self, positions: Array) -> PairDistances | bool:
        """Distance of every pair at q (nv,), or only True if any pair overlaps."""

    @abstractmethod
    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        """Place (3,) [m] and rotation (3, 3) of the avoiding hand at q (nv,)."""


class Peer(Method):
    """The avoiding arm moved by a peer. Without a solution the arm stops.

    Attributes:
        unsolvable: the peer's exception for no solution.
    """

    unsolvable: ClassVar[type[Exception]]

    def __init__(self, baked: Baked) -> None:
        self.baked, self.positions = baked, baked.room.start.copy()

    @abstractmethod
    def solve(self, step: int) -> Array:
        """q̇ (nv,) of a step from `positions` [rad/s]."""

    def prepare(self, step: int) -> None:
        """Copy the obstacle's position."""
        self.positions[self.baked.guided] = self.baked.guided_positions[step]

    def advance(self, step: int) -> Array:
        try:
            velocities = np.array(self.solve(step))
        except self.unsolvable:
            self.unsolved += 1
            velocities = np.zeros(len(self.positions))
        velocities[self.baked.guided] = self.baked.guided_velocities[step]
        self.positions = self.positions + self.baked.settings.dt * velocities
        return velocities


class GivenMotion:
    """A peer's task: joints with a given motion, Δq = q̇ dt, as a constraint. `options`: of its task."""

    def __init__(self, columns: slice, nv: int, **options: Any) -> None:
        self._jacobian = np.eye(nv)[columns]
        self._displacement: Array = np.zeros(len(self._jacobian))
        super().__init__(**options)

    def take(self, baked: Baked, step: int) -> None:
        """Copy the guided arm's motion of a step."""
        self._displacement = baked.guided_velocities[step] * baked.settings.dt

    def compute_error(self, configuration: Any) -> Array:
        """−Δq (n,), as the peers solve J Δq = −gain · error."""
        return -self._displacement

    def compute_jacobian(self, configuration: Any) -> Array:
        """Rows of the identity for the joints."""
        return self._jacobian


ENOUGH: Final = 100.0
"""Larger than any joint's speed or angle."""

HAND: Final = "hand"


def urdf_text(baked: Baked, ground: str = "universe") -> str:
    """URDF text. Every capsule is a cylinder with its own name; the guided arm has no bounds; there are no
    masses.

    Args:
        ground: name of the root link.
    """
    model, root = baked.room.model, ElementTree.Element("robot", name="duet")
    data = model.createData()
    pin.forwardKinematics(model, data, np.ones(model.nq))
    ElementTree.SubElement(root, "link", name=ground)
    for i in range(1, model.njoints):
        name, column = model.names[i], model.joints[i].idx_v
        joint, _ = _link(
            root,
            name,
            "revolute",
            _body(model, model.parents[i], ground),
            f"body {name}",
            model.jointPlacements[i],
        )
        # The axis in the joint's own frame, for any kind of revolute joint.
        axis = pin.log3(model.jointPlacements[i].actInv(data.liMi[i]).rotation)
        ElementTree.SubElement(joint, "axis", xyz=_text(axis / np.linalg.norm(axis)))
        low, high, speed = (
            model.lowerPositionLimit[column],
            model.upperPositionLimit[column],
            model.velocityLimit[column],
        )
        if baked.guided.start <= column < baked.guided.stop:
            low, high, speed = -ENOUGH, ENOUGH, ENOUGH
        bounds = {"lower": _text(low), "upper": _text(high), "velocity": _text(speed), "effort": "1000"}
        ElementTree.SubElement(joint, "limit", bounds)
    for capsule in baked.room.geometry.geometryObjects:
        parent, name, shape = _body(model, capsule.parentJoint, ground), capsule.name, capsule.geometry
        _, link = _link(root, f"at {name}", "fixed", parent, name, capsule.placement)
        geometry = ElementTree.SubElement(ElementTree.SubElement(link, "collision", name=name), "geometry")
        ElementTree.SubElement(
            geometry, "cylinder", radius=_text(shape.radius), length=_text(2.0 * shape.halfLength)
        )
        # Pinocchio reads a cylinder with this mark as a capsule.
        ElementTree.SubElement(ElementTree.SubElement(link, "collision_checking"), "capsule", name=name)
    frame = model.frames[baked.hand]
    _link(root, "at hand", "fixed", _body(model, frame.parentJoint, ground), HAND, frame.placement)
    return ElementTree.tostring(root, encoding="unicode")


def _body(model: pin.Model, joint: int, ground: str) -> str:
    return f"body {model.names[joint]}" if joint else ground


def _link(
    root: ElementTree.Element, name: str, kind: str, parent: str, child: str, placement: pin.SE3
) -> tuple[ElementTree.Element, ElementTree.Element]:
    """Add a link behind a new joint. Returns joint and link."""
    link = ElementTree.SubElement(root, "link", name=child)
    joint = ElementTree.SubElement(root, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(
        joint, "origin", xyz=_text(placement.translation), rpy=_text(pin.rpy.matrixToRpy(placement.rotation))
    )
    return joint, link


def _text(numbers: Array | float) -> str:
    return " ".join(repr(number) for number in np.atleast_1d(numbers).tolist())
