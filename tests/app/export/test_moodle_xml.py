"""Every question of the lessons as Moodle XML, read back by a parser, in three languages."""

import re
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import pytest

from app.cli.main import main
from app.export.moodle_xml import moodle_xml
from app.i18n.speaking import set_language
from app.lessons.lesson import Lesson
from app.lessons.loading import load_lessons
from app.settings import Language
from tests.app.html_reader import HtmlReader

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
    return load_lessons(language=language).lessons[number]


@pytest.mark.parametrize(("language", "number"), LESSONS)
def test_every_question_has_its_answers_and_their_replies(language: Language, number: int) -> None:
    lesson = lesson_of(language, number)
    quiz = fromstring(moodle_xml(lesson))
    category, *questions = quiz.findall("question")
    assert category.get("type") == "category" and text(category, "category").startswith(f"$course$/top/Duet/{number + 1:02d} ")
    asked = [step for step in lesson.steps if step.question is not None and step.question.choices]
    chosen = [one for one in questions if one.get("type") == "multichoice"]
    assert len(chosen) == len(asked) > 0
    for step, made in zip(asked, chosen, strict=True):
        assert step.question is not None
        answers = made.findall("answer")
        assert [answer.get("fraction") for answer in answers] == [
            "100" if place == step.question.right else "0" for place in range(len(step.question.choices))
        ]
        assert all(text(answer, "feedback") for answer in answers) and len(made.findall("hint")) == len(step.hints)
        assert [one.text for one in made.findall("single")] == ["true"]
    forecasts = [forecast for step in lesson.steps if step.challenge is not None for forecast in step.challenge.forecasts]
    numerical = [one for one in questions if one.get("type") == "numerical"]
    assert len(numerical) == len(forecasts) and len(chosen) + len(numerical) == len(questions)
    for forecast, made in zip(forecasts, numerical, strict=True):
        (answer,) = made.findall("answer")
        value, tolerance = float(answer.findtext("text", "")), float(answer.findtext("tolerance", ""))
        assert tolerance == pytest.approx(abs(value) * forecast.within, rel=0.02) and value
    names = [text(one, "name") for one in questions]
    assert len(set(names)) == len(names)
    said = [one.text or "" for one in quiz.iter("text")]
    # Every number is filled in, no Markdown and no dollar is left, and what is written is HTML.
    assert not [one for one in said[1:] if re.search(r"\{(measured|set|table)|\$|\*\*|!\[", one)]
    for one in said[1:]:
        HtmlReader(one)


def test_formulas_stay_latex_and_pictures_become_words() -> None:
    everything = "".join(fromstring(moodle_xml(lesson_of("en", 2))).itertext())
    assert r"\(J_d" in everything and r"\tag{11}" in everything and "<svg" not in everything and "<img" not in everything
    assert len(re.findall(r"\\\(", everything)) == len(re.findall(r"\\\)", everything)) > 10


def test_the_command_writes_a_file_a_lesson(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["handout", "--moodle", "--lesson", "3", "--lang", "sl", "--out", str(tmp_path)]) == 0
    (path,) = tmp_path.iterdir()
    assert path.name == "lesson-03-strict-priority-sl.xml" and fromstring(path.read_bytes()).tag == "quiz"
    assert main(["handout", "--moodle", "--teacher", "--out", str(tmp_path)]) != 0
    assert "leave --teacher out" in capsys.readouterr().err
