"""Floor and supports of the arms. World frame: z up, floor at z = 0, metres."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.rigs import TABLE_HEIGHT, Rig

PLATE: Final = 0.012
"""Thickness of the plate under a base [m]."""

BENCH_TOP: Final = TABLE_HEIGHT - PLATE
"""Height [m]."""

BENCH_HALF_DEPTH: Final = 0.30
"""Half size along y [m]."""

BENCH_OVERHANG: Final = 0.22
"""Bench beyond the middle of a base, along x [m]."""

TORSO_BLOCK: Final = (-0.028, 0.0, 0.875)
"""Middle of the block behind both flanges, world [m]."""

TORSO_COLUMN: Final = 0.058
"""Radius with the collar [m]."""

TORSO_STUB: Final = 0.0725
"""Radius between block and flanges [m]."""

POST: Final = 0.05
"""Radius of the column under a single base [m]."""

CART_HALF: Final = (0.32, 0.22)
"""Half sizes along x and y, about the base [m]."""

FLOOR: Final = (0.0, 0.0, -5.0, 20.0, 20.0, 5.0)
"""Centre and half size of a box [m]."""


FLOOR_BOX: Final = 0
"""Row of the floor in `Furniture.boxes`."""


def bench_half_length(separation: float) -> float:
    """Half size along x, for bases at x = ± separation / 2 [m]."""
    return separation / 2 + BENCH_OVERHANG


@dataclass(frozen=True, eq=False)
class Column:
    """A fixed capsule: ends (3,), world, and radius [m]."""

    start: Array
    end: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Furniture:
    """What arms of a rig can meet, apart from each other.

    `boxes`: centres and half sizes (k, 6), including the floor, parallel to the world's axes [m].
    """

    boxes: Array
    columns: tuple[Column, ...]


def furniture_of(rig: Rig) -> Furniture:
    """The bench is solid down to the floor: arms cannot reach between its legs."""
    if rig.name == "table":
        half = bench_half_length(-2.0 * float(rig.bases[0].translation[0]))
        bench = (0.0, 0.0, BENCH_TOP / 2, half, BENCH_HALF_DEPTH, BENCH_TOP / 2)
        return Furniture(np.array([FLOOR, bench]), ())
    if rig.name == "cart":
        x, y, _ = rig.bases[0].translation.tolist()
        return Furniture(
            np.array([FLOOR, (x, y, BENCH_TOP / 2, CART_HALF[0], CART_HALF[1], BENCH_TOP / 2)]), ()
        )
    if rig.name == "torso":
        block = np.array(TORSO_BLOCK)
        foot = block * np.array([1.0, 1.0, 0.0])
        stubs = (Column(block, base.translation.copy(), TORSO_STUB) for base in rig.bases)
        return Furniture(np.array([FLOOR]), (Column(foot, block, TORSO_COLUMN), *stubs))
    feet = ((base.translation * np.array([1.0, 1.0, 0.0]), base.translation.copy()) for base in rig.bases)
    return Furniture(
        np.array([FLOOR]), tuple(Column(low, high, POST) for low, high in feet if high[2] > POST)
    )
