"""Quantities that a law keeps at or above a threshold. Loads no library.

d_m and v of the settings are h_m and v in the unit of the first task.
"""

from dataclasses import dataclass, replace
from typing import Final

BETWEEN: Final = ", "
"""Separator of several units."""


@dataclass(frozen=True)
class KeptQuantity:
    """A first task as it is written.

    Attributes:
        name: in links and files.
        label: in the chooser.
        short: such as "distance".
        unit: SI unit, or several separated by `BETWEEN`.
        against: what is kept clear of, in plain words; "" if it is nothing outside the arm.
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

    @property
    def sharpness_unit(self) -> str:
        """Unit of β: one over the value's unit."""
        return BETWEEN.join({"m/rad": "rad/m"}.get(unit, f"1/{unit}") for unit in self._units)

    @property
    def field_unit(self) -> str:
        """Unit of η: the value's unit squared, times rad²/s."""
        squares = {"rad": "rad⁴/s", "m/rad": "m²/s"}
        return BETWEEN.join(squares.get(unit, f"{unit}² rad²/s") for unit in self._units)

    @property
    def _units(self) -> list[str]:
        return self.unit.split(BETWEEN)

    def _each(self, form: str) -> str:
        return BETWEEN.join(form.format(unit) for unit in self._units)

    @property
    def critical(self) -> str:
        """Symbol of the threshold, such as d_m."""
        return f"{self.symbol}_m"

    @property
    def seen(self) -> str:
        """Symbol of the value that the law acts on, such as d_law."""
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
"""Choice → its first tasks; with stages the last one wins."""


def part_of_pair(quantity: KeptQuantity, pair: int) -> KeptQuantity:
    """Part with the least value; `quantity` if it has no parts. `pair`: its index, -1 if unknown."""
    parts = PARTS.get(quantity.name, ())
    return FIRST_TASKS[parts[pair]] if 0 <= pair < len(parts) else quantity


def quantity_of_pair(quantity: KeptQuantity, pair: int) -> KeptQuantity:
    """The quantity in the unit of its least part, see `part_of_pair`."""
    part = part_of_pair(quantity, pair)
    return quantity if part is quantity else replace(quantity, unit=part.unit)
