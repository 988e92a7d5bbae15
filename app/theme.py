"""Colours and sizes. A symbol has one colour in the text, in the scene and in the plots; the palette is safe for
colour-blind people (after Okabe & Ito 2008), and every colour has a second cue: a dash, a width or a word."""

from dataclasses import dataclass
from typing import Final

from app.settings import Profile, Theme

Rgb = tuple[int, int, int]


@dataclass(frozen=True)
class Palette:
    """Colours of one theme as CSS hex: by symbol, then of the room.

    Attributes:
        distance, critical, resting, activation, error, velocity, pull, approach: of d, d_m, d*, λ, e, v, u, w.
        joints: of q1 … q7.
        laws: of the laws, in the order of the picker.
        calm: of the line between the arms while λ = 0.
        background: of the room, top and bottom.
        cell, section: of the floor's lines.
    """

    distance: str
    critical: str
    resting: str
    activation: str
    error: str
    velocity: str
    pull: str
    approach: str
    joints: tuple[str, ...]
    laws: tuple[str, ...]
    calm: str
    background: tuple[Rgb, Rgb]
    cell: Rgb
    section: Rgb


PALETTES: Final[dict[Theme, Palette]] = {
    "light": Palette(
        distance="#0072b2",
        critical="#d55e00",
        resting="#2a93c9",
        activation="#7a3fc4",
        error="#a3195b",
        velocity="#00835e",
        pull="#9a6700",
        approach="#c1271b",
        joints=("#0072b2", "#d55e00", "#00835e", "#a3195b", "#7a3fc4", "#9a6700", "#57606a"),
        laws=(
            "#7a3fc4",
            "#57606a",
            "#d55e00",
            "#00835e",
            "#9a6700",
            "#0072b2",
            "#a3195b",
            "#00879a",
            "#5c7a00",
            "#24292f",
            "#8b949e",
        ),
        calm="#5d7387",
        background=((243, 245, 248), (214, 220, 227)),
        cell=(205, 211, 218),
        section=(176, 184, 194),
    ),
    "dark": Palette(
        distance="#5ab4f0",
        critical="#ff8f45",
        resting="#8fcdf5",
        activation="#bd9bff",
        error="#f58ab8",
        velocity="#3fd0a0",
        pull="#f0bd4a",
        approach="#ff7a6b",
        joints=("#5ab4f0", "#ff8f45", "#3fd0a0", "#f58ab8", "#bd9bff", "#f0bd4a", "#a9b4bf"),
        laws=(
            "#bd9bff",
            "#a9b4bf",
            "#ff8f45",
            "#3fd0a0",
            "#f0bd4a",
            "#5ab4f0",
            "#f58ab8",
            "#4fd6e0",
            "#b5d33d",
            "#e6edf3",
            "#7b8590",
        ),
        calm="#9fb3c6",
        background=((34, 38, 44), (19, 21, 25)),
        cell=(44, 48, 54),
        section=(62, 68, 76),
    ),
}

BRAND: Final[Rgb] = (242, 106, 10)


def rgb(css: str) -> Rgb:
    """Return "#rrggbb" as numbers."""
    return int(css[1:3], 16), int(css[3:5], 16), int(css[5:7], 16)


def blend(a: str, b: str, share: float) -> Rgb:
    """Return the colour `share` of the way from a to b."""
    x, y = rgb(a), rgb(b)
    return (
        round(x[0] + (y[0] - x[0]) * share),
        round(x[1] + (y[1] - x[1]) * share),
        round(x[2] + (y[2] - x[2]) * share),
    )


def scale(profile: Profile) -> float:
    """Return how much larger text and lines are drawn."""
    return 1.3 if profile == "projector" else 1.0


DOCK_WIDTH: Final = 344
"""Width of the controls [CSS px]."""


def plots_height(canvas_height: float, profile: Profile) -> int:
    """Return the height of one plot on a canvas of this height [CSS px]: a fifth, but neither unreadable nor a wall."""
    return round(min(max(0.2 * canvas_height, 112.0), 176.0) * (1.12 if profile == "projector" else 1.0))


NARROW: Final = 1180
"""On a window narrower than this the squared error makes room for a chart that needs more than a third of the panel [CSS px]."""

PLOTS_FRAME: Final = 96.0
"""Height of the panel of plots without the plots [CSS px]."""
