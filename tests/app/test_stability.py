"""The section on stability: what it says in every case."""

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.plots.stability_text import condition_text, error_text, ranks_text, stability_html
from controllers.kinematics import Array
from controllers.stability import Analysis, analyse, barrier
from tests.app.html_reader import HtmlReader

HAND = np.eye(4)[:3]
"""J_b of a task that uses the first three of four joints."""

FREE, ALONG, BETWEEN = np.array([0.0, 0.0, 0.0, 0.5]), np.array([0.5, 0.0, 0.0, 0.0]), np.array([0.5, 0.0, 0.0, 0.1])
"""J_d orthogonal to it, inside it, and in between."""


def at(row: Array, lam: float = 0.7, J_b: Array | None = HAND) -> Analysis:
    return analyse(row, J_b, lam, 2.0, 2.0)


@pytest.mark.parametrize(
    ("analysis", "holds", "why"),
    [
        (at(FREE), True, "avoidance and task are orthogonal."),
        (at(np.array([0.5, 0.0, 0.0, 0.5])), True, "every error makes V fall."),
        (at(ALONG), False, "not every error makes V fall."),
        (at(BETWEEN), False, "not every error makes V fall."),
        (at(ALONG, lam=0.0), True, "nothing disturbs the task."),
        (analyse(ALONG, HAND, 0.0, 2.0, 0.0), False, "not every error makes V fall."),
        (at(np.zeros(4)), False, "no joint can move this point away."),
        (at(0.01 * ALONG), False, "no joint can move this point away."),
        (at(ALONG, J_b=None), False, "not every error makes V fall."),
    ],
)
def test_the_condition_in_words(analysis: Analysis, holds: bool, why: str) -> None:
    text = condition_text(analysis)
    assert text.startswith(f"<b>The paper’s condition {'holds' if holds else 'does not hold'}:</b>") and text.endswith(why)
    assert analysis.condition_holds is holds


@pytest.mark.parametrize(
    ("analysis", "norm", "rate", "says"),
    [
        (at(BETWEEN), 0.042, -0.013, "The error shrinks all the same: |e| = 42 mm, −13 mm/s."),
        (at(FREE), 0.042, -0.013, "The error shrinks: |e| = 42 mm, −13 mm/s."),
        (at(BETWEEN), 0.042, 0.013, "The error grows: |e| = 42 mm, +13 mm/s."),
        (at(FREE), 0.042, 0.013, "The error grows even so: |e| = 42 mm, +13 mm/s."),
        (at(ALONG), 0.042, 0.0002, "The error stays as it is: |e| = 42 mm, for avoidance and task are dependent."),
        (at(FREE), 0.042, 0.0, "The error stays as it is: |e| = 42 mm."),
        (at(FREE), 0.0018, -0.0009, "The error has died out: |e| = 2 mm."),
        (at(BETWEEN), 0.0022, 0.0011, "The error has died out: |e| = 2 mm."),
        (at(BETWEEN), 0.0022, 0.0111, "The error grows: |e| = 2 mm, +11 mm/s."),
        (at(ALONG), 0.0012, 0.0002, "The error stays as it is: |e| = 1 mm, for avoidance and task are dependent."),
        (at(ALONG), 0.0001, -0.0001, "There is no error to bring down."),
        (at(ALONG), 0.0001, 0.1, "The error grows: |e| = 0 mm, +100 mm/s."),
        (at(ALONG, J_b=None), 0.1, -0.2, "The error shrinks all the same: |e| = 5.7°, −11.5°/s."),
        (at(ALONG), math.nan, 0.0, "The error is not known."),
    ],
)
def test_the_error_in_words(analysis: Analysis, norm: float, rate: float, says: str) -> None:
    assert HtmlReader(error_text(analysis, norm, rate)).text == says


@pytest.mark.parametrize(
    ("analysis", "says"),
    [
        (at(FREE), "4 = 1 + 3, independent by 90.0°"),
        (at(BETWEEN), "4 = 1 + 3, independent by 11.3°"),
        (at(ALONG), "3 < 1 + 3, dependent"),
        (at(ALONG, J_b=None), "4 < 1 + 4, dependent"),
        (at(np.zeros(4)), "3 = 0 + 3, for Ja = 0"),
    ],
)
def test_the_ranks(analysis: Analysis, says: str) -> None:
    assert HtmlReader(ranks_text(analysis)).text == says


def test_every_number_of_section_three_stands_in_the_panel() -> None:
    a = at(BETWEEN, lam=0.5)
    html = stability_html(a, 0.1, -0.02, 0.0123, -0.0045, None)
    text = HtmlReader(html).text.replace("−", "-")
    assert f"sym(M) {a.smallest_eigenvalue:+.2f}, M {a.slowest_mode:+.3f} 1/s" in text
    assert "4 = 1 + 3" in text and "‖JaJb#‖ (16)0.50: not orthogonal" in text
    assert f"1 - λρ²{a.survival:.3f} of the task is left" in text
    assert "V, V̇ (20)0.01230, -0.00450: falls" in text and "W" not in text
    assert html.count("<tr>") == 5


@pytest.mark.parametrize(
    ("rate", "says"), [(0.01, "+0.01000: rises"), (1e-9, "0.00000"), (-1e-9, "0.00000"), (-0.01, "−0.01000: falls")]
)
def test_the_rate_of_v_in_words_without_a_sign_of_a_rounded_zero(rate: float, says: str) -> None:
    """A number that trembles around zero must not make the panel flicker."""
    text = HtmlReader(stability_html(at(BETWEEN), 0.1, 0.0, 0.01, rate, rate)).text
    assert says in text and "−0.00000" not in text and "+0.00000" not in text
    assert ("rises" in text, "falls" in text) == ("rises" in says, "falls" in says)


@pytest.mark.parametrize(
    ("distance", "row", "says"), [(0.2, ALONG, "W0."), (0.15, ALONG, "W∞: d ≤ dm"), (0.2, 0.1 * ALONG, "Wnot defined: no lever")]
)
def test_the_barrier_function(distance: float, row: Array, says: str) -> None:
    W = barrier(np.full(4, 0.1), 2.0, row, distance, 0.15, 2.0, 0.3)
    html = stability_html(at(ALONG, J_b=None), 0.1, 0.0, 0.01, 0.0, W)
    assert says in HtmlReader(html).text
    assert html.count("<tr>") == 6


NUMBERS = st.tuples(*4 * [st.floats()], st.none() | st.floats())


@given(st.integers(0, 1000), st.floats(0.0, 1.0), st.booleans(), NUMBERS)
def test_any_numbers_make_sound_html(seed: int, lam: float, posture: bool, numbers: Any) -> None:
    random = np.random.default_rng(seed)
    J_b = None if posture else random.normal(size=(3, 7))
    html = stability_html(at(random.normal(size=7) * 0.3, lam, J_b), *numbers)
    reader = HtmlReader(html)
    assert reader.tags <= {"div", "p", "b", "br", "table", "tr", "td", "sub", "sup"}
    assert not re.search(r"\b(nan|inf)\b", reader.text)
    assert set(re.findall(r'class="([^"]*)"', html)) <= {"duet duet-stability", "lam", "e"}
