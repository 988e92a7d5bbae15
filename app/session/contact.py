"""What happens along the line of contact at this moment, for the numbers and plots that need more than the history holds."""

from typing import NamedTuple

from controllers.kinematics import Array
from scenes.history import Sample
from scenes.simulation import Simulation


class Contact(NamedTuple):
    """One moment of the arm that keeps clear, or of both arms if one row is shared by both.

    Attributes:
        row: J_d (n,) [m/rad].
        distance: that the law acts on [m].
        pull, approach: u and w along that row [m/s].
        square: |J_d|² [m²/rad²].
        second_square: that of the second arm, if it keeps clear by a row of its own; else 0.
        rate: J_d q̇, what the arm really does along the row [m/s].
        change: ḋ of the distance that the law acts on, of everything that moves [m/s].
    """

    row: Array
    distance: float
    pull: float
    approach: float
    square: float
    second_square: float
    rate: float
    change: float


def contact(simulation: Simulation, sample: Sample) -> Contact:
    """Return the contact in the simulation's newest step; `sample` is that step's. The positions are left as they are."""
    run = simulation.settings
    near = simulation.near or simulation.detector.detect(run.law.pairs, run.law.beta, run.law.convexity)
    own, *others = [mover.joints for mover in simulation.roles.avoiders(run.avoid)]
    second_square = 0.0
    if others and run.law.coupled:
        own = slice(min(own.start, others[0].start), max(own.stop, others[0].stop))
    elif others:
        second_row = near.row[others[0]]
        second_square = float(second_row.dot(second_row))
    row = near.row[own]
    return Contact(
        row,
        sample.law_distance,
        sample.pull,
        sample.law_approach,
        float(row.dot(row)),
        second_square,
        float(row.dot(sample.velocities[own])),
        float(near.row.dot(sample.velocities)),
    )
