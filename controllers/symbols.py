"""The one table of symbols: the paper's letters, our names for them at a boundary, and their units."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Symbol:
    """One row of the table.

    Attributes:
        letter: as printed in the paper.
        tex: LaTeX of the letter.
        name: the name of the quantity at a boundary of the code.
        unit: SI unit, "" for a pure number.
        meaning: one line for a person.
    """

    letter: str
    tex: str
    name: str
    unit: str
    meaning: str


SYMBOLS: Final = (
    Symbol("q", "q", "positions", "rad", "joint angles of one arm (7,) or of both (14,), left first"),
    Symbol("q̇", r"\dot q", "velocities", "rad/s", "joint velocities"),
    Symbol("q̇ₙ", r"\dot q_n", "nominal", "rad/s", "joint velocities that the task alone asks for"),
    Symbol("d", "d", "distance", "m", "smallest distance between the arms' surfaces; negative when they overlap"),
    Symbol("d_m", "d_m", "critical_distance", "m", "critical distance: avoidance has full priority below it"),
    Symbol("d*", "d^*", "resting_distance", "m", "distance at which the law and the present pull are in balance"),
    Symbol("n₀", "n_0", "direction", "", "unit vector from the obstacle's closest point to the arm's"),
    Symbol("λ", r"\lambda", "activation", "", "how far avoidance has taken over, eq. (31)"),
    Symbol("n", "n", "order", "", "order of λ: a larger n takes over later and more steeply"),
    Symbol("v", "v", "nominal_velocity", "m/s", "speed of retreat at full activation, eq. (30)"),
    Symbol("u", "u", "pull", "m/s", "speed at which the task pulls the arm towards the obstacle, u = −J_d q̇ₙ"),
    Symbol("w", "w", "approach", "m/s", "speed at which the obstacle's closest point comes towards the arm"),
    Symbol("K", "K", "gain", "1/s", "gain of the tracking task, eqs (7), (8)"),
    Symbol("e", "e", "error", "m", "where the hand should be minus where it is, eq. (8)"),
    Symbol("J", "J", "jacobian", "", "Jacobian of the hand"),
    Symbol("J_d", "J_d", "row", "m/rad", "Jacobian of the distance, one row, eq. (26)"),
    Symbol("J^#", r"J^{\#}", "pseudo_inverse", "", "Moore–Penrose pseudo-inverse, eq. (5)"),
    Symbol("N′", "N'", "smooth_projector", "", "I − λ J_d^# J_d, eq. (33); no projector while 0 < λ < 1"),
    Symbol("β", r"\beta", "beta", "1/m", "sharpness of the smooth minimum over all pairs; ours, not the paper's"),
)
