"""Colours, and the one style sheet. A symbol has one colour in the text, in the scene and in the plots; the palette is safe for
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

PLOTS_HEIGHT: Final = 176
"""Height of a plot [CSS px]."""


def style_sheet(profile: Profile) -> str:
    """Return the style sheet as a <style> element."""
    k = scale(profile)
    symbols = {
        "d": "distance",
        "dm": "critical",
        "rest": "resting",
        "lam": "activation",
        "e": "error",
        "v": "velocity",
        "u": "pull",
        "w": "approach",
    }
    light, dark = PALETTES["light"], PALETTES["dark"]
    colours = "".join(
        f".duet .{name},.duet-legend .{name}{{color:light-dark({getattr(light, field)},{getattr(dark, field)})}}"
        for name, field in symbols.items()
    )
    return f"<style>{_RULES.replace('KPX', f'{k:g}').replace('DOCK', f'{DOCK_WIDTH * k:g}')}{colours}</style>"


_RULES: Final = """
[data-mantine-color-scheme=dark]{color-scheme:dark}[data-mantine-color-scheme=light]{color-scheme:light}
.duet{padding:0 12px;font-size:calc(14px*KPX);line-height:1.4;color:light-dark(#1f2328,#e3e8ee)}
.duet svg{max-width:100%}
.duet-tiles{display:grid;grid-template-columns:repeat(4,1fr);gap:6px;margin:2px 0 6px}
.duet-tiles>div{border:1px solid light-dark(#dfe4e9,#343a42);background:light-dark(#fbfcfd,#1c2024);border-radius:8px;padding:5px 7px 4px;min-width:0}
.duet-tiles b{display:block;font:600 calc(17px*KPX)/1.2 ui-monospace,"SF Mono","DejaVu Sans Mono",monospace;font-variant-numeric:tabular-nums;letter-spacing:-.6px;white-space:nowrap}
.duet-tiles span{display:block;font-size:calc(11px*KPX);color:light-dark(#57606a,#9aa6b2);white-space:nowrap;overflow:hidden;text-overflow:ellipsis}
.duet-tiles .bad{border-color:light-dark(#c1271b,#ff7a6b);background:light-dark(#fff1ef,#3a1b18)}
.duet-status{display:flex;flex-wrap:wrap;gap:5px;margin:0 0 6px;min-height:calc(23px*KPX);font-size:calc(12.5px*KPX)}
.duet-status span{border-radius:999px;padding:1px 9px;background:light-dark(#e9eef3,#2a3037);white-space:nowrap}
.duet-status .go{background:light-dark(#ddf2e9,#17392d);color:light-dark(#00583f,#7fe0bd)}
.duet-status .halt{background:light-dark(#fff1d6,#3d2f10);color:light-dark(#7a4d00,#f5c96a)}
.duet-status .alarm{background:light-dark(#fde4e1,#4a1d19);color:light-dark(#9c1a10,#ffaaa0);font-weight:600;white-space:normal}
.duet-status .alarm::before{content:"⚠ "}
.duet-eq{border:1px solid light-dark(#e0e5ea,#30363d);background:light-dark(#f5f7f9,#20242a);border-radius:8px;padding:7px 8px 5px;margin:0 0 6px;text-align:center;position:relative}
.duet-eq .no{position:absolute;right:7px;top:6px;font-size:calc(11px*KPX);opacity:.55}
.duet-live{font:calc(12.5px*KPX)/1.55 ui-monospace,"SF Mono","DejaVu Sans Mono",monospace;font-variant-numeric:tabular-nums;letter-spacing:-.4px;text-align:center;margin:2px 0 6px;white-space:nowrap;overflow:hidden}
.duet-live b{font-weight:650}
.duet table{border-collapse:collapse;width:100%}.duet td{padding:2px 4px;vertical-align:top}
.duet kbd{font:calc(11.5px*KPX) ui-monospace,monospace;border:1px solid light-dark(#c3cbd3,#4a525b);border-bottom-width:2px;border-radius:4px;padding:0 5px;background:light-dark(#fff,#24292f);white-space:nowrap}
.duet p{margin:6px 0}.duet h3{font-size:calc(13px*KPX);margin:10px 0 3px}
.uplot-container{border:0!important;background:transparent!important;margin:0!important}
.uplot .u-title{text-align:left!important;padding-left:10px!important;font-size:calc(12.5px*KPX)!important;font-weight:600!important;opacity:.85}
.duet-legend{display:flex;flex-wrap:wrap;gap:2px 16px;padding:2px 12px 0;font-size:calc(12.5px*KPX);color:light-dark(#414a54,#b4bfca)}
.duet-legend i{display:inline-block;width:22px;height:0;border-top:2.5px solid currentColor;margin-right:5px;vertical-align:middle}
.duet-legend i.dash{border-top-style:dashed}.duet-legend i.dot{border-top-style:dotted}
[data-floating-window]:has(.duet-plots){left:14px!important;top:auto!important;bottom:14px!important;width:calc(100% - DOCKpx - 28px)!important}
[data-floating-window]:has(.duet-plots) div:has(> div > .uplot-container){display:grid!important;grid-template-columns:repeat(2,minmax(0,1fr));padding-top:0!important;gap:0 6px}
[data-floating-window]:has(.duet-three) div:has(> div > .uplot-container){grid-template-columns:repeat(3,minmax(0,1fr))}
[data-floating-window]:has(.duet-plots) div:has(> .duet-plots){grid-row:1;grid-column:1/-1}
label{letter-spacing:-.1px!important}
@media (max-width:36em){
.mantine-Paper-root[style*="max-height: 60%"]{width:100vw!important;max-height:48%!important;border-radius:14px 14px 0 0!important}
.mantine-Paper-root[style*="max-height: 60%"] div[style*="width: 20em"]{width:100%!important}
}
"""
