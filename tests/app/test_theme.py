"""Every colour stands in the theme: style sheets name it, and few files have colours of their own."""

import re
from pathlib import Path

import pytest

from app.text.documents import document_page
from app.theme import PALETTES, SYMBOL_COLOURS, css_variables
from tests.test_imports import ROOT

HEX = re.compile(r"(?<![&\w])#(?:[0-9a-fA-F]{8}|[0-9a-fA-F]{6}|[0-9a-fA-F]{3,4})\b")

OWN = {
    "app/web/static/mark.svg": 2,
    "app/figures/figure_style.py": 2,
    "scenes/glb.py": 1,
    "scenes/lwr/shells.py": 10,
    "scenes/person/body.py": 1,
    "scenes/room_shells.py": 4,
}
"""File → colours that it has beside the theme: the mark, lines of figures that are no symbols, and materials of the robots and the cell."""

SHADOWS = re.compile(r"#000[0-9a-f]?\b")
"""Black that shades or covers is the same in every theme."""

FILES = [
    path
    for floor in ("app", "scenes", "controllers")
    for path in sorted((ROOT / floor).rglob("*"))
    if path.suffix in (".py", ".css", ".js", ".svg", ".html")
]
SHEETS = [path for path in FILES if path.suffix in (".css", ".html")]


def own_colours(text: str) -> list[str]:
    return [found for found in HEX.findall(text) if not SHADOWS.fullmatch(found)]


def test_no_colour_stands_outside_the_theme_but_in_a_short_list() -> None:
    found = {
        name: len(colours)
        for path in FILES
        if (name := path.relative_to(ROOT).as_posix()) != "app/theme.py"
        and (colours := own_colours(path.read_text(encoding="utf-8")))
    }
    assert found == OWN
    assert sum(OWN.values()) < 60


def test_positive_control_a_colour_is_found() -> None:
    found = own_colours("a{color:#fff}b{color:light-dark(#1f2328,#e3e8eeaa)}c{box-shadow:0 0 2px #0002}")
    assert found == ["#fff", "#1f2328", "#e3e8eeaa"]


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda path: path.name)
def test_a_style_sheet_names_only_colours_that_the_theme_has(sheet: Path) -> None:
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
