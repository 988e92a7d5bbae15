"""Handouts: only the teacher's copy has the outcomes, and both print without a cut element. Moodle XML of all
questions, read back by a parser, in three languages."""

import re
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import pytest

from app.__main__ import run_command as main
from app.features.handout.handout_html import handout_html
from app.features.handout.moodle_xml import moodle_xml
from app.features.lab_report.report_html import LOCKED
from app.features.lessons.lesson import Lesson, Step
from app.features.lessons.library import Library, notes_of
from app.features.lessons.loading import read_notes
from app.features.lessons.outcomes import reference
from app.features.lessons.texts import fill, without_outcome
from app.i18n.speaking import set_language
from app.settings import TRANSLATIONS, Language
from app.text.lesson_text import lesson_html
from tests.app.features.lessons.helpers import our_book
from tests.app.html_reader import HtmlReader
from tests.approved import Approve
from tests.browser import PageAt

BOOK = Library().book
NOTES = notes_of(BOOK)

PAPERS = {"A4": (210, 297), "Letter": (216, 279)}
"""Width and height [mm]."""
MARGINS = 2 * 12, 2 * 11
"""Sums of both margins, horizontal and vertical [mm], as in handout.css."""

UNFIT = """([width, height]) => [...document.body.querySelectorAll(':not(svg *)')].flatMap((element) => {
  const box = element.getBoundingClientRect();
  const name = `${element.tagName} ${element.className.baseVal ?? element.className}: ${element.textContent.slice(0, 40)}`;
  const whole = getComputedStyle(element).breakInside === 'avoid' || element.tagName === 'svg';
  return [
    ...(box.left < -1 || box.right > width + 1 || element.scrollWidth > element.clientWidth + 1 && element.clientWidth
      ? [`wide: ${name}`] : []),
    ...(whole && box.height > height ? [`tall: ${name}`] : []),
  ];
})"""
"""Elements that are too large for a sheet."""


WHOLE = "[...new Set([...document.querySelectorAll('.block')].map((one) => getComputedStyle(one).breakInside === 'avoid'))]"
"""[true] if no block may be divided between two sheets."""


def words(page: str) -> str:
    return " ".join(HtmlReader(re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)).text.split())


def outcome_texts(lesson: Lesson, step: Step) -> list[str]:
    """Texts for the teacher's copy only: a step's replies, and its first measurement with the value."""
    outcome = reference(step, step.setup)
    replies = [
        fill(step, choice.reply, outcome, lesson.language)
        for choice in (step.question.choices if step.question else ())
    ]
    texts = [words(lesson_html(reply, step.setup.folder)) for reply in replies]
    first = outcome.lines(step, lesson.language)[0].split(";")[0].rstrip(".") if step.measurements else ""
    return [text for text in (*texts, first.replace("_", "")) if text]


@pytest.mark.parametrize("lesson", BOOK.lessons, ids=lambda lesson: lesson.id)
def test_only_the_teachers_copy_has_the_outcomes(lesson: Lesson) -> None:
    student, teacher = words(handout_html(lesson)), words(handout_html(lesson, NOTES[lesson.id]))
    texts = [text for step in lesson.steps for text in outcome_texts(lesson, step)]
    assert len(texts) >= len(lesson.steps)
    assert [text for text in texts if text in student] == []
    assert [text for text in texts if text not in teacher] == []
    noted = "think aloud" if lesson.asked else "Usually believed"
    assert noted in teacher and noted not in student


def test_texts_after_a_question_are_in_a_separate_section() -> None:
    lesson = BOOK.lessons[BOOK.index("redundancy")]
    first = lesson.steps[0]
    assert first.question is not None and first.challenge is not None
    before, _, after = handout_html(lesson).partition('<section class="afterwards">')
    challenge = lesson_html(first.challenge.text)
    assert challenge in after and "Challenge 1.1" in after and challenge not in before
    assert '<svg class="picture"' in after and '<svg class="picture"' not in before


def test_picture_captions_are_printed_with_subscripts(approve: Approve) -> None:
    page = handout_html(BOOK.lessons[BOOK.index("strict-priority")])
    captions = re.findall(r"<figcaption.*?</figcaption>", page, flags=re.DOTALL)
    assert "d<sub>m</sub>" in "".join(captions)
    approve("captions.txt", "".join(f"{' '.join(one.split())}\n" for one in captions))


def test_a_measured_number_of_the_answer_becomes_a_blank() -> None:
    hold = BOOK.lessons[BOOK.index("hold")]
    step = next(step for step in hold.steps if step.id == "push")
    text = without_outcome("{measured:margin}, {measured:margin:1}, {setting:v}", step)
    assert text.endswith("\\_, {measured:margin:1}, {setting:v}") and "{measured:margin}" not in text
    alone = next(step for step in hold.steps if step.id == "break")
    assert "measured" not in without_outcome("{measured:margin}", alone)


@pytest.mark.parametrize("language", ["de", "sl"])
def test_both_copies_in_other_languages(language: Language) -> None:
    set_language(language)
    lesson = next(lesson for lesson in BOOK.in_language(language).lessons if lesson.id == "hold")
    student, teacher = handout_html(lesson), handout_html(lesson, NOTES[lesson.id])
    for page in (student, teacher):
        assert f'<html lang="{language}">' in page and LOCKED in page
        assert not {"script", "iframe", "link"} & HtmlReader(page).tags
    for word in ("Question", "My reason", "Measured", "What I set"):
        assert word not in words(student)
    assert student.count('<figure class="axes') == 1 and 'class="d"' in student
    # Only the teacher's axes have the curve of the run.
    curves = [re.findall(r'<path[^>]* d="M0\.5[^"]{200,}"', page) for page in (student, teacher)]
    assert [len(found) for found in curves] == [0, 1]
    assert student.count('<li class="block') == 7 and teacher.count("✓") == 4


@pytest.mark.thorough
def test_every_copy_prints_on_both_papers_without_a_cut(page_at: PageAt, tmp_path: Path) -> None:
    assert main(["handout", "--out", str(tmp_path)]) == 0
    assert main(["handout", "--out", str(tmp_path), "--teacher"]) == 0
    # The longest lesson, in languages with longer texts.
    for language in TRANSLATIONS:
        assert main(["handout", "--out", str(tmp_path), "--lesson", "limits", "--lang", language]) == 0
    files = sorted(tmp_path.glob("*.html"))
    assert len(files) == 2 * len(BOOK.lessons) + len(TRANSLATIONS)
    page = page_at(fresh=True)
    page.emulate_media(media="print")
    for path in files:
        page.goto(path.as_uri())
        # The print medium reaches a page of another process a moment after its load.
        page.wait_for_function(f"() => String({WHOLE}) === 'true'")
        for paper, (width, height) in PAPERS.items():
            across, down = (
                round((size - margin) / 25.4 * 96)
                for size, margin in zip((width, height), MARGINS, strict=True)
            )
            page.set_viewport_size({"width": across, "height": down})
            page.wait_for_function("across => innerWidth === across", arg=across)
            assert page.evaluate(UNFIT, [across, down]) == [], (path.name, paper)
            if paper == "A4" and "limits" not in path.name:
                # Letter has less room; only the longest lesson is printed on both papers.
                continue
            printed = page.pdf(format=paper, prefer_css_page_size=True)
            sheets = len(re.findall(rb"/Type /Page\b", printed))
            assert sheets <= 2 or "-teacher" in path.name, (path.name, paper, sheets)
            assert sheets >= 2 or page.locator(".afterwards").count() == 0, (
                "texts for later have a separate sheet"
            )
            # A student's copy has its columns only on paper.
            assert (
                "-teacher" not in path.name
                or page.evaluate("document.documentElement.scrollHeight") / down <= sheets
            )
            boxes = {
                tuple(round(float(x) / 72 * 25.4) for x in box.split()[2:])
                for box in re.findall(rb"MediaBox \[([^]]*)\]", printed)
            }
            assert boxes == {(width, height)}


def test_one_lesson_is_written_and_an_unknown_one_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    assert main(["handout", "--lesson", "6", "--lang", "sl", "--out", str(tmp_path / "new")]) == 0
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["lesson-06-hold-sl.html"]
    assert main(["handout", "--lesson", "99", "--out", str(tmp_path)]) == 2
    approve("unknown.txt", capsys.readouterr().err)


def test_without_any_lesson_only_the_cause_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    folder, playlist = tmp_path / "nope", tmp_path / "bad.toml"
    playlist.write_text("lessons = [", encoding="utf-8")
    assert main(["handout", "--folder", str(folder), "--lesson", "3"]) == 1
    said = capsys.readouterr().err
    assert main(["handout", "--playlist", str(playlist)]) == 1
    # The rest is Python's own message.
    said += capsys.readouterr().err.partition(" here: ")[0]
    approve("faults.txt", said.replace(str(folder), "…") + "\n")
    assert main(["lessons", "--folder", str(folder), "--only", "3"]) == 1
    assert "There is no lesson" not in capsys.readouterr().err


LESSONS = [
    *(("en", number) for number in range(11)),
    # A lesson with forecasts, one with pictures, and one with a curve to draw.
    *((language, number) for language in ("de", "sl") for number in (2, 3, 9)),
]


def text(of: Element, path: str) -> str:
    found = of.find(f"{path}/text")
    assert found is not None
    return found.text or ""


def lesson_of(language: Language, number: int) -> Lesson:
    set_language(language)
    return our_book(language).lessons[number]


@pytest.mark.parametrize(("language", "number"), LESSONS)
def test_every_question_has_its_answers_and_their_replies(language: Language, number: int) -> None:
    lesson = lesson_of(language, number)
    quiz = fromstring(moodle_xml(lesson))
    category, *questions = quiz.findall("question")
    assert category.get("type") == "category" and text(category, "category").startswith(
        f"$course$/top/Duet/{number + 1:02d} "
    )
    asked = [step for step in lesson.steps if step.question is not None and step.question.choices]
    chosen = [one for one in questions if one.get("type") == "multichoice"]
    assert len(chosen) == len(asked) > 0
    for step, made in zip(asked, chosen, strict=True):
        assert step.question is not None
        answers = made.findall("answer")
        assert [answer.get("fraction") for answer in answers] == [
            "100" if place == step.question.right else "0" for place in range(len(step.question.choices))
        ]
        assert all(text(answer, "feedback") for answer in answers) and len(made.findall("hint")) == len(
            step.hints
        )
        assert [one.text for one in made.findall("single")] == ["true"]
    forecasts = [
        forecast
        for step in lesson.steps
        if step.challenge is not None
        for forecast in step.challenge.forecasts
    ]
    numerical = [one for one in questions if one.get("type") == "numerical"]
    assert len(numerical) == len(forecasts) and len(chosen) + len(numerical) == len(questions)
    for forecast, made in zip(forecasts, numerical, strict=True):
        (answer,) = made.findall("answer")
        value, tolerance = float(answer.findtext("text", "")), float(answer.findtext("tolerance", ""))
        assert tolerance == pytest.approx(abs(value) * forecast.within, rel=0.02) and value
    names = [text(one, "name") for one in questions]
    assert len(set(names)) == len(names)
    said = [one.text or "" for one in quiz.iter("text")]
    # Every number is filled in, no Markdown and no dollar sign is left, and the text is HTML.
    assert not [one for one in said[1:] if re.search(r"\{(measured|set|table)|\$|\*\*|!\[", one)]
    for one in said[1:]:
        HtmlReader(one)


def test_formulas_stay_latex_and_pictures_become_words() -> None:
    everything = "".join(fromstring(moodle_xml(lesson_of("en", 2))).itertext())
    assert (
        r"\(J_d" in everything
        and r"\tag{11}" in everything
        and "<svg" not in everything
        and "<img" not in everything
    )
    assert len(re.findall(r"\\\(", everything)) == len(re.findall(r"\\\)", everything)) > 10


def test_the_command_writes_one_file_per_lesson(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["handout", "--moodle", "--lesson", "3", "--lang", "sl", "--out", str(tmp_path)]) == 0
    (path,) = tmp_path.iterdir()
    assert path.name == "lesson-03-strict-priority-sl.xml" and fromstring(path.read_bytes()).tag == "quiz"
    assert main(["handout", "--moodle", "--teacher", "--out", str(tmp_path)]) != 0
    assert "leave --teacher out" in capsys.readouterr().err


ILLEGAL = "\x00\x01\x08\x0b\x0c\x0e\x1f\ud800\udfff\ufffe\uffff"
"""Characters that XML forbids; tab, line break and \x7f are allowed and stay."""


@pytest.mark.parametrize("escaped", [False, True])
def test_characters_that_xml_does_not_allow_are_left_out(escaped: bool) -> None:
    """Both literally and as HTML references, which Markdown resolves."""
    lesson = lesson_of("en", 3)
    odd = "".join(f"&#{ord(one)};" for one in ILLEGAL) if escaped else ILLEGAL
    steps = [
        replace(
            step,
            title=f"ti{odd}tle",
            question=step.question
            and replace(step.question, text=f"wh{odd}at? \x7f😀", choices=(*step.question.choices,)),
        )
        for step in lesson.steps
    ]
    quiz = fromstring(moodle_xml(replace(lesson, title=f"na{odd}me", steps=tuple(steps))))
    questions = quiz.findall("question")
    assert len(questions) > 2
    asked = [text(one, "questiontext") for one in questions if one.get("type") == "multichoice"]
    assert asked and all("\x7f😀" in one for one in asked)
    if not escaped:
        # Markdown replaces some of them with U+FFFD.
        assert all(re.search("wh[\ufffd\\s]*at\\?", one) for one in asked)
        assert re.search("na[\ufffd\\s]*me$", text(questions[0], "category"))


def test_a_playlist_has_only_the_notes_to_its_steps(tmp_path: Path) -> None:
    playlist = tmp_path / "week.toml"
    playlist.write_text('lessons = ["lambda#tail"]', encoding="utf-8")
    library = Library(None, playlist, with_notes=True)
    paper = words(handout_html(library.book.lessons[0], library.notes["lambda"]))
    steps = {step.number: words(lesson_html(step.text)) for step in read_notes(NOTES["lambda"]).steps}
    assert len(steps) > 3 and [number for number, text in steps.items() if text in paper] == [3]
