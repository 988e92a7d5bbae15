"""Numbers of lessons as they are read: two significant digits, and a table where a quantity was measured in several runs."""

import pytest

from app.lessons.lesson import Measurement
from app.lessons.outcomes import reference
from app.lessons.step_view import fill
from app.text.lesson_text import lesson_html
from tests.lessons.helpers import our_book


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.000313, 3, "0.31 mm"),
        (0.001221, 3, "1.2 mm"),
        (0.0337, 1, "34 mm"),
        (0.424, 0, "424 mm"),
        (0.0, 1, "0.0 mm"),
        (-0.0546, 1, "−55 mm"),
    ],
)
def test_two_significant_digits_are_shown_and_no_whole_number_is_rounded(value: float, digits: int, text: str) -> None:
    assert Measurement("x", "hand_error_now", (), "mm", digits).text(value) == text


def test_what_counts_ways_or_ranks_stays_a_whole_number() -> None:
    assert Measurement("x", "null_dimension", (), "", 0).text(4.0) == "4"


def test_a_series_is_a_table_in_the_order_of_what_differs() -> None:
    step = our_book().lessons[3].steps[1]
    outcome = reference(step, step.setup)
    text = fill(step, "{table:bias,formula}", outcome, "en").strip().splitlines()
    assert [line.split(" | ")[0] for line in text] == ["| n", "| ---", "| 1", "| 2", "| 5", "| 10"]
    assert (
        step.measurements[0].text(outcome.values[0][2]) in text[4] and step.measurements[1].text(outcome.values[1][2]) in text[4]
    )
    assert lesson_html(fill(step, step.observe, outcome, "en")).count("<td") == 12
    assert "with n = 2" in outcome.lines(step, "en")[0] and "with n = 2" not in outcome.lines(step, "en", ["bias"])[0]


def test_runs_that_differ_in_more_than_a_number_are_named() -> None:
    step = our_book().lessons[4].steps[1]
    text = fill(step, "{table:step}", None, "en")
    assert "| this run |" in text and "| dt = 10 ms |" in text and "| law = Strict priority, switched at d_m |" in text
    tilted = our_book().lessons[9].steps[1]
    assert "| 1° |" in fill(tilted, "{table:textbook}", None, "en")
