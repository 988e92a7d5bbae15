"""How every figure looks: one palette, one type size, and a dash for every colour, so that it also reads in black and white."""

from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from app.theme import PALETTES

COLOURS: Final = PALETTES["light"]
INK: Final = COLOURS.ink
FAINT: Final = COLOURS.line
PALE: Final = COLOURS.panel

WIDTH: Final = 5.2
"""Of a figure [inch]; at half the width of a page its type is as large as the paper's."""

DPI: Final = 200

DASHES: Final[tuple[Any, ...]] = (
    "solid",
    (0, (6, 2)),
    (0, (1.2, 1.4)),
    (0, (6, 1.6, 1.2, 1.6)),
    (0, (3, 1.2)),
    (0, (9, 2, 2.5, 2)),
    (0, (6, 1.5, 1.2, 1.5, 1.2, 1.5)),
    (0, (1.2, 3)),
    (0, (12, 2)),
    (0, (2.5, 2.5)),
    (0, (9, 1.5, 1.2, 1.5)),
    (0, (4, 1, 1, 1, 1, 1, 1, 1)),
)
"""Of the first line of a panel, the second, and so on."""

MARKERS: Final = ("o", "s", "^", "D", "v", "P", "p", "X", "*", "h", "<", ">")

SERIES: Final = (*COLOURS.joints, COLOURS.resting, COLOURS.approach, "#5c7a00", INK, "#00879a")
"""Colours of things that have no symbol of their own."""

STYLE: Final[dict[Any, Any]] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "mathtext.fontset": "stix",
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 10.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": COLOURS.faint,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": COLOURS.hair,
    "grid.linewidth": 0.8,
    "xtick.color": COLOURS.soft,
    "ytick.color": COLOURS.soft,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 9.5,
    "ytick.labelsize": 9.5,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "legend.handlelength": 2.6,
    "legend.columnspacing": 1.4,
    "lines.linewidth": 1.7,
    "lines.solid_capstyle": "round",
    "text.color": INK,
    "figure.facecolor": "white",
    "figure.constrained_layout.use": True,
    # The same ids in every SVG of the same figure.
    "svg.hashsalt": "lwr-duet",
    "svg.fonttype": "path",
    "path.simplify": True,
    "axes.unicode_minus": True,
}


def sheet(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure of a size [inch]; it belongs to no window."""
    return Figure(figsize=(width, height))


def stack(height: float, rows: int, ratios: tuple[float, ...] | None = None) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels one under the other that share their horizontal axis."""
    figure = sheet(height)
    grid = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=ratios)
    figure.align_ylabels()
    return figure, list(grid[:, 0])


def tag(axes: Axes, text: str, x: float, y: float, colour: str, size: float) -> None:
    """Write a line's name beside it, in its colour."""
    axes.text(x, y, text, color=colour, ha="left", va="center", fontsize=size)
