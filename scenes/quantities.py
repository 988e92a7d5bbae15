"""What a law keeps at or above a threshold, as it is written: symbol, unit, names. Nothing here loads a library.

The distance of the arms is one. A law computes in the unit of its first task: d_m and v of the settings are then h_m and v in it.
"""

from dataclasses import dataclass, replace
from typing import Final

BETWEEN: Final = ", "
"""Stands between the units of a value that is now a length, now an angle."""


@dataclass(frozen=True)
class KeptQuantity:
    """A first task as it is written.

    Attributes:
        name: in links and in files.
        label: what a person reads in the chooser.
        short: what it is a value of, as in "distance".
        symbol: of the value.
        unit: SI unit of it; of several first tasks at once, their units.
        against: what is kept clear of, in plain words; "" if the arm keeps clear of nothing outside it.
    """

    name: str
    label: str
    short: str
    symbol: str
    unit: str
    against: str = ""

    @property
    def page_unit(self) -> str:
        """Unit on the page, a thousandth of the SI unit."""
        return self._each("m{}")

    @property
    def rate_unit(self) -> str:
        return self._each("{}/s")

    @property
    def row_unit(self) -> str:
        """Unit of |J_a|; "" if it has none."""
        return {"rad": "", "m/rad": "m/rad²", "m, rad": "m/rad"}.get(self.unit, f"{self.unit}/rad")

    def _each(self, form: str) -> str:
        return BETWEEN.join(form.format(unit) for unit in self.unit.split(BETWEEN))

    @property
    def critical(self) -> str:
        """Symbol of the threshold in plain text, as d_m."""
        return f"{self.symbol}_m"

    @property
    def seen(self) -> str:
        """Symbol of what the law acts on in plain text, as d_law."""
        return f"{self.symbol}_law"


DISTANCE: Final = KeptQuantity("distance", "Distance of the arms", "distance", "d", "m", "arm")
"""The paper's."""

WALL: Final = "wall"
STOPS: Final = "stops"
SINGULAR: Final = "singular"
TIP: Final = "tip"
ALL: Final = "all"

FIRST_TASKS: Final[dict[str, KeptQuantity]] = {
    quantity.name: quantity
    for quantity in (
        KeptQuantity(WALL, "A wall", "distance from the wall", "d", "m", "wall"),
        KeptQuantity(STOPS, "Joint stops", "way to the joint stops", "h", "rad"),
        KeptQuantity(SINGULAR, "Out of singularity", "smallest singular value", "σ", "m/rad"),
        KeptQuantity(TIP, "Not to tip", "centre of mass inside the foot", "h", "m"),
        KeptQuantity(ALL, "All at once", "least of all margins", "h", f"m{BETWEEN}rad"),
    )
}
"""Name → first task, in the order of the chooser."""

PARTS: Final[dict[str, tuple[str, ...]]] = {ALL: (WALL, SINGULAR, STOPS, TIP)}
"""Choice → the first tasks of which it consists, if it is not one itself; of stages the last one wins."""


def part_of_pair(quantity: KeptQuantity, pair: int) -> KeptQuantity:
    """The first task that is the least now; the same if it is not made of several. `pair`: its number, -1 if unknown."""
    parts = PARTS.get(quantity.name, ())
    return FIRST_TASKS[parts[pair]] if 0 <= pair < len(parts) else quantity


def quantity_of_pair(quantity: KeptQuantity, pair: int) -> KeptQuantity:
    """A first task in the unit of its part that is the least now, see `part_of_pair`."""
    part = part_of_pair(quantity, pair)
    return quantity if part is quantity else replace(quantity, unit=part.unit)
