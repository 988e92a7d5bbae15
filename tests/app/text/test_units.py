"""A unit is never alone on a line: in texts built by code and in the lessons' prose, but not in code."""

import pytest

from app.text.lesson_text import inline_html, lesson_html
from app.text.templates import element, tr_html
from app.text.units import unbroken

NO_BREAK = "\u00a0"


@pytest.mark.parametrize(
    "text", ["d = 177 mm", "0.30 m/s", "5 ms", "at 3.1 s.", "−12 mm/s", "K = 2 1/s", "∞ mm", "12 %"]
)
def test_a_number_keeps_its_unit(text: str) -> None:
    assert unbroken(text).count(NO_BREAK) == 1
    assert unbroken(text).replace(NO_BREAK, " ") == text


@pytest.mark.parametrize("text", ["3 seconds", "5 more", "step 2 m3", "lesson 10 says", "2 ms_per", "s = 1"])
def test_other_words_may_break(text: str) -> None:
    assert unbroken(text) == text


def test_every_html_builder_keeps_units() -> None:
    assert f"100{NO_BREAK}mm" in tr_html("this curve promises d ≥ {kept} mm while w ≤ v", kept="100")
    assert f"12{NO_BREAK}mm" in element("p", "12 mm")
    assert f"8.7{NO_BREAK}mm" in lesson_html("It rests 8.7 mm away.\n\n| d |\n|---|\n| 8.7 mm |")
    assert f"5{NO_BREAK}ms" in inline_html("dt = 5 ms")


def test_code_and_formulas_stay_as_they_are() -> None:
    assert NO_BREAK not in lesson_html("```\nd = 5 m\n```\n\n`12 mm` and $12 m$")
