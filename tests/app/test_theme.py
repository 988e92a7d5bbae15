"""Every colour is in the theme: style sheets use its name, and few files have their own colours."""

import re
from pathlib import Path

import pytest

from app.settings import Theme
from app.text.documents import document_page
from app.theme import PALETTES, SYMBOL_COLOURS, css_variables, rgb
from tests.test_imports import ROOT

HEX = re.compile(r"(?<![&\w])#(?:[0-9a-fA-F]{8}|[0-9a-fA-F]{6}|[0-9a-fA-F]{3,4})\b")

OWN = {
    "app/web/static/mark.svg": 2,
    "app/features/figures/drawn_figure.py": 2,
    "scenes/glb.py": 1,
    "scenes/lwr/shells.py": 10,
    "scenes/person/body.py": 1,
    "scenes/room_shells.py": 4,
}
"""File → number of its own colours: mark, figure lines without a symbol, materials of robots and cell."""

SHADOWS = re.compile(r"#000[0-9a-f]?\b")
"""Black for shadows and covers, the same in every theme."""

FILES = [
    path
    for floor in ("app", "scenes", "controllers")
    for path in sorted((ROOT / floor).rglob("*"))
    if path.suffix in (".py", ".css", ".js", ".svg", ".html")
]
SHEETS = [path for path in FILES if path.suffix in (".css", ".html")]


def own_colours(text: str) -> list[str]:
    return [found for found in HEX.findall(text) if not SHADOWS.fullmatch(found)]


def test_only_the_listed_files_have_colours_outside_the_theme() -> None:
    found = {
        name: len(colours)
        for path in FILES
        if (name := path.relative_to(ROOT).as_posix()) != "app/theme.py"
        and (colours := own_colours(path.read_text(encoding="utf-8")))
    }
    # A feature may be missing.
    assert found == {name: count for name, count in OWN.items() if (ROOT / name).exists()}
    assert sum(OWN.values()) < 60


def test_positive_control_a_colour_is_found() -> None:
    found = own_colours("a{color:#fff}b{color:light-dark(#1f2328,#e3e8eeaa)}c{box-shadow:0 0 2px #0002}")
    assert found == ["#fff", "#1f2328", "#e3e8eeaa"]


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda path: path.name)
def test_a_style_sheet_uses_only_colours_of_the_theme(sheet: Path) -> None:
    text = sheet.read_text(encoding="utf-8")
    known = set(re.findall(r"--[\w-]+(?=:)", css_variables()))
    asked = {name for name in re.findall(r"var\((--[\w-]+)", text) if not name.startswith("--duet-")}
    assert asked - set(re.findall(r"(--[\w-]+):", text)) <= known


def test_documents_show_symbols_in_the_colours_of_the_theme() -> None:
    page = document_page("model").decode()
    for name, field in SYMBOL_COLOURS.items():
        light, dark = (getattr(palette, field) for palette in PALETTES.values())
        assert f"main .{name}{{color:var(--{field})}}" in page
        assert f"--{field}:light-dark({light},{dark});" in page
    assert len(re.findall('class="lam"', page)) > 3


SURFACES = ("paper", "card", "panel", "well", "brand_tint")
"""Backgrounds for text of every colour."""

TEXT = (
    "ink",
    "dim",
    "soft",
    "brand_ink",
    "good_ink",
    "warning_ink",
    "alarm_ink",
    "calm",
    *SYMBOL_COLOURS.values(),
)

GRAPHICS = ("faint", "bar", "brand", "warning")
"""Meaningful lines and borders, without text."""

BESIDE_A_SURFACE = (
    *(
        ("on_brand", "brand"),
        ("ink", "flash"),
        ("ink", "warning_flash"),
        ("card", "ink"),
        ("card", "velocity"),
    ),
    *(
        ("good_ink", "good_tint"),
        ("warning_ink", "warning_tint"),
        ("warning_ink", "warning_flash"),
        ("alarm_ink", "alarm_tint"),
    ),
    *((text, "alarm_tint") for text in ("ink", "soft")),
)
"""Text → further background."""


def contrast(a: str, b: str) -> float:
    """Contrast ratio of two colours by WCAG 2.2."""

    def luminance(css: str) -> float:
        parts = [value / 255.0 for value in rgb(css)]
        red, green, blue = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts)
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", PALETTES)
def test_text_and_graphics_have_contrast_on_every_surface(theme: Theme) -> None:
    palette = PALETTES[theme]
    surfaces = {name: getattr(palette, name) for name in SURFACES}
    texts = {name: getattr(palette, name) for name in TEXT}
    texts |= {
        f"{kind} {i}": one for kind in ("joints", "laws") for i, one in enumerate(getattr(palette, kind))
    }
    pairs = [(4.5, name, one, on, surface) for name, one in texts.items() for on, surface in surfaces.items()]
    pairs += [
        (3.0, name, getattr(palette, name), on, surface)
        for name in GRAPHICS
        for on, surface in surfaces.items()
    ]
    pairs += [(4.5, name, getattr(palette, name), on, getattr(palette, on)) for name, on in BESIDE_A_SURFACE]
    low = {
        f"{name} on {on}": round(ratio, 2)
        for least, name, one, on, under in pairs
        if (ratio := contrast(one, under)) < least
    }
    assert not low


def test_positive_control_the_contrast_of_known_colours() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)
