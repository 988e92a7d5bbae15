"""The class report: a page and a table with every count; a student's typed text has no effect in them."""

import csv
import io
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.__main__ import run_command as main
from app.features.classroom.class_report import (
    COLUMNS,
    class_report_bytes,
    class_table_bytes,
    class_zip_bytes,
    report_names,
)
from app.features.classroom.class_summary import ClassSummary, HandIn
from app.features.classroom.classroom import Classroom
from app.features.classroom.student_work import clean_name
from app.features.lab_report.report_html import LOCKED
from app.features.lessons.lesson import LessonBook
from app.features.lessons.library import Library
from app.features.lessons.progress import from_json
from app.features.lessons.walkthrough import Walkthrough
from app.features.store.record_bytes import record_from_bytes, record_to_bytes
from app.i18n.catalogue import words_of
from app.plots.curve_chart import COLUMNS as CURVE
from app.settings import Language
from scenes.files import csv_cell
from tests.app.features.lessons.helpers import our_book
from tests.app.html_reader import HtmlReader
from tests.approved import Approve, shown_text
from tests.browser import PageAt, screenshot

BOOK = our_book()
NASTY = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&"


def class_of(name: str = "Ann", words: str = "I see.") -> ClassSummary:
    """A class of three students with answers to two questions, one of them asked twice, and one hand-in."""
    room, walk = Classroom(8), Walkthrough(BOOK)
    first = (walk.lesson.id, walk.step.id)
    for student, choice in (("ann", 0), ("bo", 1), ("cy", 1)):
        assert room.answer(walk, student, choice)
    room.ballots.ask_again(first)
    for student in ("ann", "bo"):
        assert room.answer(walk, student, 2)
    walk.go("lambda", 1)
    assert room.draw(walk, "cy", ("lambda", walk.step.id), (0.5,) * CURVE)
    assert room.answer(walk, "cy", 1)
    own = Walkthrough(BOOK)
    own.choose(0)
    own.write(words)
    (drift,) = (lesson for lesson in BOOK.lessons if lesson.id == "drift")
    own.go("drift", next(i for i, step in enumerate(drift.steps) if step.challenge is not None))
    own.done.attempts, own.done.passed = 2, True
    assert room.hand_in(walk, "ann", name, own.to_json())
    return room.summary(BOOK, 1_800_000_000.0)


def page_of(summary: ClassSummary, language: Language = "en") -> str:
    return class_report_bytes(summary, BOOK.in_language(language).lessons, language).decode()


def rows_of(summary: ClassSummary, book: LessonBook = BOOK) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(class_table_bytes(summary, book.lessons).decode("utf-8-sig"))))


def counts_of(page: str) -> str:
    """Text of a class report before the students' reports, without lesson texts and version."""
    body = page[page.index("<h1") : page.index('<h2 class="reports"')]
    for lessons_own in (
        r"<svg\b.*?</svg>",
        r"<ol\b.*?</ol>",
        r"<dl\b.*?</dl>",
        r'<div class="question.*?</div>',
    ):
        body = re.sub(lessons_own, "", body, flags=re.DOTALL)
    return re.sub(r"Duet \d[\w.]*", "Duet", shown_text(body))


def test_the_page_has_every_round_and_the_reports(approve: Approve) -> None:
    page = page_of(class_of())
    approve("class report.txt", counts_of(page))
    text = HtmlReader(page).text
    assert [part for part in ("I see.", "✓ passed", "attempts: 2") if part not in text] == []
    assert "bo" not in re.findall(r"\w+", text) and LOCKED in page


def test_hand_ins_are_graded_from_one_zip_file(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], approve: Approve
) -> None:
    summary = class_of("../Ann\\")
    (ann,) = summary.hand_ins
    summary = replace(summary, hand_ins=(ann, replace(ann, name="Š: Žan"), replace(ann, name="")))
    archive, table = tmp_path / "class.zip", tmp_path / "marks.csv"
    archive.write_bytes(class_zip_bytes(summary, BOOK.in_language("de").lessons, "de"))
    assert main(["grade", str(archive), "--csv", str(table)]) == 0
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["001 ___Ann_.html", "002 Š_ Žan.html", "003 ohne Namen 1.html"]
    assert {
        (row["kind"], row["steps"], row["attempts"], row["passed"], row["reason"][:11]) for row in rows
    } == {("report", "2", "2", "1", "redundancy/")}
    with zipfile.ZipFile(archive) as parts:
        assert "I see." in HtmlReader(parts.read("001 ___Ann_.html").decode()).text
    for content in (b"no archive", archive.read_bytes()[:-200]):
        archive.write_bytes(content)
        assert main(["grade", str(archive), "--csv", str(table)]) == 2
    approve("refused archive.txt", capfd.readouterr().err.replace(str(tmp_path), "…"))


def test_the_table_has_a_row_per_round_of_a_question_and_per_challenge() -> None:
    summary = class_of()
    rows = rows_of(summary)
    place = {"lesson": "redundancy", "step": BOOK.lessons[0].steps[0].id}
    first, second = (row for row in rows if row["lesson"] == "redundancy")
    answers = [f"answer_{i}" for i in range(1, 5)]
    assert place.items() <= first.items() and [first[key] for key in answers] == ["1", "2", "0", "0"]
    assert [second[key] for key in ("kind", "round", "students", *answers)] == [
        "question",
        "2",
        "2",
        "0",
        "0",
        "2",
        "0",
    ]
    question = BOOK.lessons[0].steps[0].question
    assert question is not None and second["right_answer"] == str(question.right + 1)
    assert second["right"] == second[f"answer_{question.right + 1}"] and (first["Ann"], second["Ann"]) == (
        "1",
        "3",
    )
    (challenge,) = (row for row in rows if row["kind"] == "challenge")
    assert (challenge["lesson"], challenge["passed"], challenge["Ann"]) == ("drift", "1", "1")
    (drawn,) = (row for row in rows if row["lesson"] == "lambda")
    assert (drawn["students"], drawn["drawn"], drawn["Ann"]) == ("1", "1", "")
    for row in rows:
        counts = [int(row[f"answer_{i}"]) for i in range(1, 7) if row[f"answer_{i}"]]
        assert row["kind"] == "challenge" or sum(counts) <= int(row["students"])


BEFORE_AND_AFTER = (("beliefs", 0), ("beliefs_last", 1))


def answered(book: LessonBook, *answers: tuple[str, int]) -> str:
    """Progress of a breakout session with an answer to a test question in each of these lessons."""
    own = Walkthrough(book)
    for lesson, choice in answers:
        own.go(lesson, 1)
        own.choose(choice)
    return own.to_json()


@pytest.fixture
def book() -> LessonBook:
    return Library().book


@pytest.fixture
def tested(book: LessonBook) -> ClassSummary:
    """Answers before and after: four students, and three in breakout sessions (one of them both times)."""
    room, walk = Classroom(8), Walkthrough(book)
    for lesson, answers in (("beliefs", "0012"), ("beliefs_last", "2012")):
        walk.go(lesson, 1)
        for student, choice in zip(("ann", "bo", "cy", "di"), answers, strict=True):
            assert room.answer(walk, student, int(choice))
    # A second answer after a discussion: the first answer counts.
    room.ballots.ask_again(("beliefs_last", "closed_path"))
    assert room.answer(walk, "bo", 1)
    room.work.note("ed", answered(book, BEFORE_AND_AFTER[0]))
    room.work.note("flo", answered(book, BEFORE_AND_AFTER[1]))
    room.work.note("gus", answered(book, *BEFORE_AND_AFTER))
    return room.summary(book, 0.0)


def test_the_gain_counts_shared_and_breakout_answers_anonymously(
    tested: ClassSummary, book: LessonBook
) -> None:
    assert tested.paired == {("beliefs", "closed_path"): ((0, 0), (0, 1), (0, 2), (1, 1), (2, 2))}
    assert record_from_bytes(record_to_bytes(tested), ClassSummary) == tested
    rows = rows_of(tested, book)
    gains = [
        (row["students"], row["before"], row["after"], row["gain"]) for row in rows if row["kind"] == "gain"
    ]
    assert gains == [("5", "1", "2", "0.25")] * 2
    moved = [
        [row["round"], *(row[f"answer_{i}"] for i in range(1, 4))] for row in rows if row["kind"] == "moved"
    ]
    assert moved == [["1", "1", "1", "1"], ["2", "0", "1", "0"], ["3", "0", "0", "1"]]


@pytest.mark.parametrize(
    ("language", "gain", "validated"), [("de", "0,25", "validi"), ("en", "0.25", "validated")]
)
def test_a_report_has_the_gain_in_the_language_of_the_class(
    tested: ClassSummary, book: LessonBook, language: Language, gain: str, validated: str
) -> None:
    page = class_report_bytes(tested, book.in_language(language).lessons, language).decode()
    text = HtmlReader(page).text
    missing = [part for part in ("⟨g⟩", gain, "20 %", "40 %", validated) if part not in text]
    assert not missing


def test_a_loss_of_right_answers_is_a_negative_gain(book: LessonBook) -> None:
    lost = replace(ClassSummary(0.0, 3, ()), paired={("beliefs", "closed_path"): ((1, 0), (0, 0), (0, 0))})
    assert {row["gain"] for row in rows_of(lost, book) if row["kind"] == "gain"} == {"-0.5"}
    assert "−0.50" in HtmlReader(class_report_bytes(lost, book.lessons, "en").decode()).text


def test_a_class_without_an_answer_is_empty() -> None:
    assert ClassSummary(0.0, 0, ()).empty


@given(st.text(max_size=80))
def test_no_cell_is_a_formula(name: str) -> None:
    cell = csv_cell(clean_name(name))
    assert not cell.lstrip().startswith(("=", "+", "-", "@", "＝", "＋", "－", "＠")) and cell.lstrip(
        "'"
    ) == clean_name(name).lstrip("'")


def test_formula_like_and_duplicate_names_are_made_safe_and_unique() -> None:
    evil = ("=1+1", "+1", "-1", "@SUM(A1)", '=HYPERLINK("http://x","y")')
    reports = tuple(HandIn(name, "") for name in (*evil, "Ann", "Ann", "", ""))
    names = report_names(reports)
    assert names[-4:] == ["Ann", "Ann (2)", "without a name 1", "without a name 2"] and len({*names}) == len(
        reports
    )
    table = class_table_bytes(ClassSummary(0.0, 0, (), {}, reports), BOOK.lessons).decode("utf-8-sig")
    (head,) = csv.reader(io.StringIO(table))
    assert head[len(COLUMNS) :] == [*(f"'{name}" for name in evil), *names[-4:]]


def test_a_hostile_name_is_shown_as_typed_in_every_language() -> None:
    for language in ("de", "sl"):
        page = page_of(class_of(NASTY, NASTY), language)
        assert HtmlReader(page).text.count(NASTY[:60]) == 3 and f'lang="{language}"' in page
        assert words_of(language)("Reports handed in") in page and "Reports handed in" not in page


def test_a_report_that_does_not_fit_the_lessons_is_left_out() -> None:
    steps = '{"lesson": "redundancy", "step": "freedom", "choice": 77}, {"lesson": "x", "step": "y"}'
    strange = HandIn("Ann", f'{{"version": 1, "steps": [{steps}]}}')
    assert from_json(strange.progress).steps
    page = page_of(ClassSummary(0.0, 0, (), {}, (strange, HandIn("Bo", "no JSON"))))
    assert "Ann" in page and "Bo" in page


def test_the_page_begins_with_the_students_and_prints_two_reports_a_sheet(
    page_at: PageAt, tmp_path: Path
) -> None:
    (ann,) = class_of(NASTY).hand_ins
    summary = replace(class_of(), hand_ins=(ann, *(replace(ann, name=f"Student {i}") for i in range(6))))
    made, path = page_of(summary), tmp_path / "class.html"
    assert (
        made.index('<table class="grid">')
        < made.index('<table class="overview')
        < made.index("Reports handed in")
    )
    row = re.findall(r"<tr><th>Student 3</th>(.*?)</tr>", made)
    assert row == ["<td>✗</td><td>★</td>" if "✗" in row[0] else row[0]] and "★" in row[0]
    path.write_text(made, encoding="utf-8")
    page = page_at(820, 1000, fresh=True)
    page.goto(path.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    bars = page.locator(".duet-poll .round div > div")
    # Two rounds of four answers: the second below the first, on the same scale.
    assert bars.count() == 8
    boxes = [bars.nth(i).locator("xpath=..").bounding_box() for i in range(8)]
    assert len({box["width"] for box in boxes if box}) == 1 and all(boxes)
    screenshot(page, "class-report")
    page.emulate_media(media="print")
    sheets = [len(re.findall(rb"/Type /Page\b", page.pdf(prefer_css_page_size=True)))]
    page.evaluate("for (const one of [...document.body.children]) if (!one.matches('main')) one.remove()")
    sheets.append(len(re.findall(rb"/Type /Page\b", page.pdf(prefer_css_page_size=True))))
    assert sheets[1] == 4, "seven reports need four sheets"
    assert 1 <= sheets[0] - sheets[1] <= 3
