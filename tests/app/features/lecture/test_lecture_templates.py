"""Texts of a class's members are harmless on the lecture's pages."""

from collections.abc import Iterator
from itertools import product

import pytest

from app.features.classroom.student_work import BoardRow, Cell
from app.features.lecture.overlays import screen_html
from app.features.lecture.page_lines import join_html, overlay_html
from app.features.lecture.presenter import Station
from app.web.address import Address
from tests.app.features.classroom.nasty_poll import poll
from tests.app.features.test_templates import (
    ALL_TEMPLATES,
    NASTY,
    Macros,
    Surfaces,
    assert_harmless,
    filled,
    views,
)


def screens() -> Iterator[str]:
    for station, panels in product(Station, (True, False)):
        yield from (
            screen_html(station, view, one, 7, panels, (NASTY,), -0.001)
            for view in views()
            for one in (poll(), None)
        )


MACROS: Macros = {
    "features/lecture/board.html": [
        ("board", ([BoardRow(NASTY, (Cell(True, 2), Cell(here=True, minutes=3)), 2)], 2)),
        ("run", (NASTY, NASTY)),
        ("work", (NASTY, NASTY, NASTY, [NASTY], 0, "", [NASTY])),
    ],
}

SURFACES: Surfaces = {
    **filled(MACROS),
    "features/lecture/invitation.html": lambda: iter(
        (join_html(Address(NASTY, False)), overlay_html(Address(NASTY, True)))
    ),
    "features/lecture/screen.html": screens,
}
"""Template → pages and fragments made from it with hostile names and lesson texts."""


def test_every_template_of_the_lecture_is_listed() -> None:
    assert sorted(SURFACES) == [name for name in ALL_TEMPLATES if name.startswith("features/lecture/")]


@pytest.mark.parametrize("name", SURFACES)
def test_nothing_that_a_person_wrote_acts_on_a_page(name: str) -> None:
    assert_harmless(SURFACES[name])
