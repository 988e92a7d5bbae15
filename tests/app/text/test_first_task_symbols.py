"""A text about the paper's d, rewritten for another first task."""

import pytest
from markupsafe import Markup

from app.text.first_task_texts import in_symbols
from scenes.quantities import ALL, DISTANCE, FIRST_TASKS, PARTS, SINGULAR, STOPS, WALL, quantity_of_pair


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("d_law falls 3 mm below d_m, J_d is regular", "h_law falls 3 mrad below h_m, J_a is regular"),
        ('<b class="d">d</b> [m], d<sub>min</sub>', '<b class="d">h</b> [rad], h<sub>min</sub>'),
        ("J<sub>d</sub>q̇ [m/s] or J$_d$q̇ at dₘ", "J<sub>a</sub>q̇ [rad/s] or J$_a$q̇ at hₘ"),
        ("ḋ = 0.1 m/s, and d* is in a dead end", "ḣ = 0.1 rad/s, and h* is in a dead end"),
    ],
)
def test_a_text_gets_symbols_row_and_units_of_the_first_task(text: str, said: str) -> None:
    stops = FIRST_TASKS[STOPS]
    assert in_symbols(text, stops).replace("h\N{COMBINING DOT ABOVE}", "ḣ") == said
    html = in_symbols(Markup(text), stops)
    assert isinstance(html, Markup)
    assert in_symbols(text, DISTANCE) == text


def test_only_the_row_of_a_wall_has_another_symbol() -> None:
    text = "d ≥ d_m [m], 3 mm, 1 m/s, "
    assert in_symbols(f"{text}J_d", FIRST_TASKS[WALL]) == f"{text}J_a"


def test_the_least_of_all_margins_has_the_unit_of_its_quantity() -> None:
    every = FIRST_TASKS[ALL]
    assert [quantity_of_pair(every, i).unit for i in range(len(PARTS[ALL]))] == ["m", "m/rad", "rad", "m"]
    assert quantity_of_pair(every, -1) is every
    assert every.page_unit == "mm, mrad"
    assert quantity_of_pair(FIRST_TASKS[SINGULAR], 0).page_unit == "mm/rad"


@pytest.mark.parametrize(("name", "unit"), [(WALL, "m/rad"), (STOPS, ""), (SINGULAR, "m/rad²")])
def test_a_row_has_the_unit_of_its_value_over_an_angle(name: str, unit: str) -> None:
    assert FIRST_TASKS[name].row_unit == unit
