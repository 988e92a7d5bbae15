"""Answers of an untrusted law and the data of a report are checked before use or writing to a table."""

import json
from contextlib import suppress

import pytest

from app.features.custom_law.arena import PIECES
from app.features.lab_report.report_html import StepRecord, read_records, records_html
from app.features.marks.marked import LawMarks, take
from app.plots.curve_chart import COLUMNS
from scenes.files import csv_cell


def test_a_forged_curve_is_omitted() -> None:
    assert PIECES == COLUMNS
    good = {"quantity": "d", "seconds": 8.0, "limit": 0.15, "lines": {"": [0.1] * PIECES}}
    of_lines = ({"lines": {"": [1.0]}}, {"lines": {"": ["<b>"] * PIECES}})
    for change in ({}, {"quantity": "x"}, {"seconds": float("nan")}, {"limit": "a"}, *of_lines):
        marks = LawMarks()
        said = {
            "name": "smooth",
            "passed": False,
            "reason": "no",
            "as_template": True,
            "curve": good | change,
        }
        with suppress(ValueError):
            take(marks, said)
        (verdict,) = marks.verdicts.values()
        assert (verdict.name, verdict.passed, verdict.reason) == ("smooth", False, "no") and marks.as_template
        assert (verdict.curve is not None) is (change == {})


def test_a_cell_is_never_a_formula() -> None:
    starts = ("=1", "+1", "-1", "@a", "\t=1", " =1", "\n@", "＝1", "＋1", "－1", "＠a")
    assert all(csv_cell(text).startswith("'") for text in starts)
    assert (
        csv_cell("a\nb\x1b[2J\u202e") == "a b [2J"
        and csv_cell(5) == "5"
        and len(csv_cell("x" * 9999)) == 2000
    )


RECORDS = [StepRecord("hold", "push", 2, True, None, 0), StepRecord("hold", "break", None, None, False, 3)]


def test_a_record_is_restored_and_shows_nothing() -> None:
    page = f"<p>{records_html(RECORDS)}</p>".encode()
    assert list(read_records(page)) == RECORDS
    assert records_html([]) == ""


@pytest.mark.parametrize(
    "steps",
    [
        *(
            [["hold", "push", True, None, None, 0]],
            [["hold", "push", 1, 1, None, 0]],
            [["hold", "push", 1, True, None, -1]],
        ),
        *(
            [["=1", "push", 1, True, None, 0]],
            [["hold", "push"]],
            "steps",
            [["hold", "push", 1, True, None, 0]] * 2,
            [[]] * 501,
        ),
        json.loads("[" * 500 + "]" * 500),
    ],
)
def test_a_damaged_record_is_refused(steps: object) -> None:
    page = str(records_html(RECORDS))
    good = json.dumps(
        [[r.lesson, r.step, r.prediction, r.right, r.passed, r.attempts] for r in RECORDS]
    ).replace('"', "&#34;")
    assert good in page
    with pytest.raises(ValueError, match="its record"):
        read_records(page.replace(good, json.dumps(steps).replace('"', "&#34;")).encode())
