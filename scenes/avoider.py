"""Whoever keeps clear by one row of J_d: an arm, or both arms together."""

import numpy as np

from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from controllers.limits import Bounded, bounded_row
from controllers.proximity import Proximity
from scenes.movers.mover import Mover
from scenes.world import World


class Avoider:
    """One or more movers that keep clear together.

    Args:
        world: where.
        movers: whose columns of q lie side by side.
        others: everybody else who moves.

    Attributes:
        joints: columns of q.
        nominal: q̇_n (n,), to be filled before `situation` [rad/s].
        velocities: q̇ (n,), a view of the world's.
        box: bounds of q̇.
    """

    def __init__(self, world: World, movers: tuple[Mover, ...], others: tuple[Mover, ...]) -> None:
        self.movers = movers
        self.joints = slice(min(m.joints.start for m in movers), max(m.joints.stop for m in movers))
        self.velocities = world.velocities[self.joints]
        self.box = world.bounds.part(self.joints)
        self._positions = world.positions[self.joints]
        self._others = [(other.joints, world.velocities[other.joints]) for other in others]
        self.nominal = np.zeros(self.joints.stop - self.joints.start)
        self._detector = world.detector

    def part(self, mover: Mover) -> Array:
        """Return where q̇_n of one of the movers belongs (n,), a view."""
        first = self.joints.start
        return self.nominal[mover.joints.start - first : mover.joints.stop - first]

    @property
    def squared_error(self) -> float:
        """Of the first mover's task."""
        return self.movers[0].squared_error

    def approach(self, row: Array) -> float:
        """Return w along a row (nv,): the speed at which the others come closer [m/s]."""
        w = 0.0
        for columns, velocities in self._others:
            w -= float(row[columns].dot(velocities))
        return w

    def situation(self, law: Law, near: Proximity) -> Situation:
        """Return what a law sees of the world now.

        Args:
            law: what it wants to see.
            near: at the present positions.
        """
        situation = Situation(self._positions, self.nominal, near.row[self.joints], near.law_distance, self.approach(near.row))
        return situation

    def bounded(self, row: Array, wanted: Array) -> Bounded:
        """Return the velocity inside the bounds that keeps the distance rate which the law wanted, see `controllers.limits`."""
        # Nothing is lost by beginning at the clipped velocity: along the row, both ways meet the same bounds in the same order.
        return bounded_row(self.box.clip(wanted), row, float(row.dot(wanted)), self.box)


def form_avoiders(world: World, movers: tuple[Mover, ...], avoiding: tuple[Mover, ...], coupled: bool) -> tuple[Avoider, ...]:
    """Return who keeps clear: each mover by a row of its own, or all by one row if they are coupled."""
    groups = (avoiding,) if coupled else tuple((mover,) for mover in avoiding)
    return tuple(Avoider(world, group, tuple(m for m in movers if m not in group)) for group in groups)
