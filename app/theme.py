"""Colours and sizes. A symbol has one colour everywhere; colours are safe for colour-blind people (after
Okabe & Ito 2008) and have a second cue: a dash, a width or a word.
"""

from dataclasses import dataclass, field, fields
from typing import Final, NamedTuple, TypeVar

from app.settings import Profile, Theme

Rgb = tuple[int, int, int]
Colours = TypeVar("Colours")

THEMES: Final[tuple[Theme, Theme]] = ("light", "dark")


def _of_themes(light: Colours, dark: Colours) -> Colours:
    return field(metadata=dict(zip(THEMES, (light, dark), strict=True)))


@dataclass(frozen=True)
class Palette:
    """One theme's colours as CSS hex; in style sheets `var(--brand-ink)`. See `SYMBOLS` for those of symbols.

    Attributes:
        laws: in the order of the picker.
        calm: line between the arms while λ = 0.
        background: the room's top and bottom.
        cell, section: the floor's lines.
        ink, dim, soft: text, from strong to weak; faint: only lines.
        paper, card, panel, well, veil: page, cards, panels, grooves, cover of the 3-D view.
        line, edge, hair, bar: borders, buttons, rules in tables, bars.
        brand, on_brand, brand_ink, brand_tint, flash: buttons, with text, surface and flash.
    """

    distance: str = _of_themes("#006fae", "#5ab4f0")
    critical: str = _of_themes("#b04d00", "#ff8f45")
    resting: str = _of_themes("#00718a", "#8fcdf5")
    activation: str = _of_themes("#7a3fc4", "#bd9bff")
    error: str = _of_themes("#a3195b", "#f58ab8")
    velocity: str = _of_themes("#007a57", "#3fd0a0")
    pull: str = _of_themes("#8c5d00", "#f0bd4a")
    approach: str = _of_themes("#c1271b", "#ff7a6b")
    joints: tuple[str, ...] = _of_themes(
        ("#006fae", "#b04d00", "#007a57", "#a3195b", "#7a3fc4", "#8c5d00", "#57606a"),
        ("#5ab4f0", "#ff8f45", "#3fd0a0", "#f58ab8", "#bd9bff", "#f0bd4a", "#a9b4bf"),
    )
    laws: tuple[str, ...] = _of_themes(
        (
            "#7a3fc4",
            "#57606a",
            "#b04d00",
            "#007a57",
            "#8c5d00",
            "#006fae",
            "#a3195b",
            "#007281",
            "#567200",
            "#24292f",
            "#8a5a44",
        ),
        (
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
            "#d8a78f",
        ),
    )
    calm: str = _of_themes("#566b7e", "#9fb3c6")
    background: tuple[Rgb, Rgb] = _of_themes(((243, 245, 248), (214, 220, 227)), ((34, 38, 44), (19, 21, 25)))
    cell: tuple[int, int, int] = _of_themes((205, 211, 218), (44, 48, 54))
    section: tuple[int, int, int] = _of_themes((176, 184, 194), (62, 68, 76))
    ink: str = _of_themes("#1f2328", "#e3e8ee")
    dim: str = _of_themes("#414a54", "#b4bfca")
    soft: str = _of_themes("#57606a", "#9aa6b2")
    faint: str = _of_themes("#7f8994", "#7d8792")
    paper: str = _of_themes("#ffffff", "#16181c")
    card: str = _of_themes("#ffffff", "#1c2024")
    panel: str = _of_themes("#f5f7f9", "#20242a")
    well: str = _of_themes("#e9eef3", "#2a3037")
    veil: str = _of_themes("#f3f5f8ee", "#101316ee")
    line: str = _of_themes("#d3d9df", "#3a414a")
    edge: str = _of_themes("#c3cbd3", "#4a525b")
    hair: str = _of_themes("#e3e7eb", "#2f353b")
    bar: str = _of_themes("#7d8a97", "#8795a3")
    brand: str = _of_themes("#e25c00", "#ff8f45")
    on_brand: str = _of_themes("#1d1105", "#1d1105")
    brand_ink: str = _of_themes("#b34700", "#ff9a4d")
    brand_tint: str = _of_themes("#fff1e6", "#2d2118")
    flash: str = _of_themes("#ffd9b3", "#7a3c00")
    good_ink: str = _of_themes("#00583f", "#7fe0bd")
    good_tint: str = _of_themes("#ddf2e9", "#17392d")
    warning: str = _of_themes("#9c6600", "#f5c96a")
    warning_ink: str = _of_themes("#6b4300", "#ffdb94")
    warning_tint: str = _of_themes("#fff1d6", "#3d2f10")
    warning_flash: str = _of_themes("#ffdf9e", "#6b4708")
    alarm_ink: str = _of_themes("#9c1a10", "#ffaaa0")
    alarm_tint: str = _of_themes("#fde4e1", "#4a1d19")


PALETTES: Final[dict[Theme, Palette]] = {
    theme: Palette(**{colour.name: colour.metadata[theme] for colour in fields(Palette)}) for theme in THEMES
}


class Symbol(NamedTuple):
    """A symbol of the page.

    Attributes:
        field: its colour in `Palette`; "" for none.
        sentence: its English meaning, at most 20 words. {arm} gives way, {other} comes near: both are
            subjects, so that a translation needs one case of each.
    """

    field: str
    sentence: str


SYMBOLS: Final = {
    "d": Symbol("distance", "d: the shortest distance between the two, along the line of contact."),
    "dm": Symbol("critical", "d_m: the distance to keep. The bubble around the obstacle is d_m thick."),
    "rest": Symbol(
        "resting", "d*: at this distance {arm} comes to rest, because retreat and task are in balance."
    ),
    "lam": Symbol("activation", "λ: how much {arm} gives way. 0: only its task. 1: only the retreat."),
    "e": Symbol("error", "e: how far the hand is from where its task wants it."),
    "v": Symbol("velocity", "v: how fast {arm} retreats when λ is 1."),
    "u": Symbol("pull", "u: how fast the task alone would close the gap."),
    "w": Symbol("approach", "w: how fast {other} comes nearer."),
    "law": Symbol("", "d_law: the distance that the law sees. It also counts other pairs that are near."),
    "lost": Symbol("", "Not achieved: what the law asks for and the joints do not do."),
}

SYMBOL_COLOURS: Final = {name: symbol.field for name, symbol in SYMBOLS.items() if symbol.field}


def css_variables() -> str:
    """CSS rule with all colours."""
    light, dark = PALETTES["light"], PALETTES["dark"]
    pairs = [
        (f.name.replace("_", "-"), getattr(light, f.name), getattr(dark, f.name)) for f in fields(Palette)
    ]
    pairs += [
        (f"room-{end}", *(f"rgb{p.background[i]}" for p in (light, dark)))
        for i, end in enumerate(("top", "bottom"))
    ]
    return (
        f":root{{{''.join(f'--{name}:light-dark({a},{b});' for name, a, b in pairs if isinstance(a, str))}}}"
    )


def symbol_rules(*scopes: str) -> str:
    """CSS rules that colour symbols inside elements. `scopes`: selectors."""
    return "".join(
        f"{','.join(f'{scope} .{name}' for scope in scopes)}{{color:var(--{field})}}"
        for name, field in SYMBOL_COLOURS.items()
    )


def rgb(css: str) -> Rgb:
    return int(css[1:3], 16), int(css[3:5], 16), int(css[5:7], 16)


BRAND: Final = rgb(PALETTES["light"].brand)


def blend(a: str, b: str, share: float) -> Rgb:
    red, green, blue = (round(x + (y - x) * share) for x, y in zip(rgb(a), rgb(b), strict=True))
    return red, green, blue


def scale(profile: Profile) -> float:
    return 1.3 if profile == "projector" else 1.0


DOCK_WIDTH: Final = 344
"""Width of the controls [CSS px]."""


def plots_height(canvas_height: float, profile: Profile) -> int:
    """Height of one plot [CSS px]."""
    return round(min(max(0.2 * canvas_height, 112.0), 176.0) * (1.12 if profile == "projector" else 1.0))


NARROW: Final = 1180
"""Window width below which the squared error makes room for a wide chart [CSS px]."""

PLOTS_FRAME: Final = 96.0
"""Height of the plots' panel without plots [CSS px]."""

PLOT_HEADROOM: Final = 17
"""Height above a plot's frame for a moment's name [CSS px]."""
