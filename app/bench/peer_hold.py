"""The hold experiment without its person: what every method of `app.bench.peers` gets, and our own methods."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import numpy as np

from controllers.kinematics import Array
from scenes.arm_tasks.arm_task import Memory
from scenes.headless import run
from scenes.room import Room
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from scenes.targets import Target
from scenes.world import World

PEER_GAIN: Final = 10.0
"""How fast the peers let the distance above d_m be used up [1/s]."""


@dataclass(frozen=True)
class Baked:
    """The hold experiment without its person: what every compared method gets.

    Attributes:
        settings: of the run that the guided arm's motion is from.
        room: arms, capsules, pairs.
        guided, avoiding: columns of q.
        hand: frame id of the avoiding hand.
        guided_positions, guided_velocities: (steps, n), at the beginning of and during each step [rad, rad/s].
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
        """Number of recorded steps."""
        return len(self.guided_positions)


class Method(Protocol):
    """A method that moves the avoiding arm."""

    unsolved: int
    """Steps in which it found no solution."""

    def prepare(self, step: int) -> None:
        """Do what is not to be timed."""

    def advance(self, step: int) -> Array:
        """Make one step and return q̇ (nv,) of it [rad/s], which may be reused."""
        ...

    @property
    def positions(self) -> Array:
        """q (nv,) [rad]."""
        ...


class Engine(Protocol):
    """An engine that computes distances and the hand's pose."""

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        """Return the distance of every pair of bodies, left body first, at q (nv,) [m]."""
        ...

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        """Return place (3,) [m] and rotation (3, 3) of the avoiding hand at q (nv,)."""
        ...


def bake(settings: RunSettings, steps: int) -> Baked:
    """Run the hold experiment once, and record the guided arm."""
    done = run(settings, steps * settings.dt)
    simulation, table = done.simulation, done.table
    guided, avoiding = simulation.guided, simulation.avoiding
    assert simulation.place is not None and simulation.place_rotation is not None
    return Baked(
        settings,
        simulation.room,
        guided.joints,
        avoiding.joints,
        avoiding.hand,
        simulation.history.positions(table)[:, guided.joints],
        simulation.history.velocities(table)[:, guided.joints],
        simulation.place.copy(),
        simulation.place_rotation.copy(),
    )


class GivenMotion:
    """A task of a peer: joints with a given motion, Δq = q̇ dt, for the constraints of its `solve_ik`. `options`: of the peer's task."""

    def __init__(self, columns: slice, nv: int, **options: Any) -> None:
        self._jacobian = np.eye(nv)[columns]
        self.displacement: Array = np.zeros(len(self._jacobian))
        super().__init__(**options)

    def compute_error(self, configuration: Any) -> Array:
        """Return −Δq (n,), as the peers solve J Δq = −gain · error."""
        return -self.displacement

    def compute_jacobian(self, configuration: Any) -> Array:
        """Return the rows of the identity that belong to the joints."""
        return self._jacobian


class PeerArm(ABC):
    """The avoiding arm moved by a peer.

    Args:
        motion: of the guided arm.
        unsolvable: raised where there is no solution.
    """

    def __init__(self, baked: Baked, configuration: Any, motion: GivenMotion, unsolvable: type[Exception]) -> None:
        self._baked, self._dt, self._configuration = baked, baked.settings.dt, configuration
        self._motion, self._unsolvable = motion, unsolvable
        self.constraints: list[Any] = [motion]
        self.positions = baked.room.start.copy()
        self.unsolved = 0
        """Steps without a solution; the arm stands still in them."""

    @abstractmethod
    def solve(self) -> Array:
        """Return q̇ (nv,) of the next step [rad/s]."""

    def prepare(self, step: int) -> None:
        """Take over where the obstacle is and how it moves."""
        baked = self._baked
        self.positions[baked.guided] = baked.guided_positions[step]
        self._motion.displacement = baked.guided_velocities[step] * self._dt

    def advance(self, step: int) -> Array:
        self._configuration.update(self.positions)
        try:
            velocities = self.solve()
        except self._unsolvable:
            self.unsolved += 1
            velocities = np.zeros(len(self.positions))
            velocities[self._baked.guided] = self._baked.guided_velocities[step]
        self.positions = self._configuration.integrate(velocities, self._dt)
        return velocities


class BakedArm:
    """The guided arm, moving as it did: an `ArmTask` for `Simulation` instead of the arm that follows a person's hand."""

    def __init__(self, baked: Baked) -> None:
        self.joints = baked.guided
        self.squared_error = 0.0
        self.desired: Array | None = None
        self.task_jacobian: Array | None = None
        self._way = list(baked.guided_velocities)
        self._step = 0

    def begin(self) -> None:
        self._step = 0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        del target, settings, time
        self._step += 1
        return self._way[self._step - 1]

    def memory(self) -> Memory:
        return (np.array([self._step]),)

    def remember(self, memory: Memory) -> None:
        self._step = int(memory[0][0])


class Ours:
    """Our own simulation with a law of ours; a `Method`."""

    def __init__(self, baked: Baked, law: LawSettings) -> None:
        self._simulation = simulation = Simulation(replace(baked.settings, law=law), baked.steps)
        obstacle = BakedArm(baked)
        simulation.roles = replace(simulation.roles, tasks=(obstacle, simulation.roles.task), held=obstacle)
        simulation.reset()
        self.unsolved = 0

    @property
    def positions(self) -> Array:
        return self._simulation.positions

    def prepare(self, step: int) -> None:
        """Do nothing."""

    def advance(self, step: int) -> Array:
        del step
        self._simulation.step(None)
        return self._simulation.velocities


def our_laws(base: LawSettings) -> dict[str, LawSettings]:
    """Return name → law of our measured methods."""
    return {
        "ours, single pair (paper)": replace(base, law="smooth_priority", pairs="single"),
        "ours, soft minimum": replace(base, law="smooth_priority", pairs="soft"),
        "ours, smooth everywhere": replace(base, law="smooth_priority", pairs="smooth"),
        "ours, barrier QP, all pairs +w": replace(
            base, law="barrier_qp", pairs="single", feed_forward=True, barrier_gain=PEER_GAIN
        ),
    }


class OurEngine:
    """Our own detector; an `Engine`."""

    def __init__(self, baked: Baked) -> None:
        self._world = World(baked.room, 1.0)
        self._hand = baked.hand

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        self._world.kinematics.update(positions)
        self._world.detector.detect()
        return dict(zip(self._world.detector.pair_names, self._world.detector.distances().tolist(), strict=True))

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._world.kinematics.update(positions)
        pose = self._world.kinematics.data.oMf[self._hand]
        return pose.translation.copy(), pose.rotation.copy()

    def nearest(self, positions: Array) -> float:
        """Return the smallest distance [m]."""
        self._world.kinematics.update(positions)
        return self._world.detector.detect().distance
