"""What a law keeps at or above a threshold, as it is written: symbol, unit, names. Nothing here loads a library.

The distance of the arms is one. A law computes in the unit of its first task: d_m and v of the settings are then h_m and v in it.
"""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class KeptQuantity:
    """A first task as it is written.

    Attributes:
        name: in links and in files.
        label: what a person reads in the chooser.
        short: what it is a value of, as in "distance".
        symbol: of the value.
        unit: SI unit of it.
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
        return f"m{self.unit}"

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
        KeptQuantity(ALL, "All at once", "least of all margins", "h", "m"),
    )
}
"""Name → first task, in the order of the chooser."""
