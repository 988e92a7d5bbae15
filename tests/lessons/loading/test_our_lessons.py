"""Our own lessons: complete in every language, with notes, pictures and documents that name what exists."""

from __future__ import annotations

import dataclasses
import math
import re
from xml.etree import ElementTree

import pytest

from app.lessons import FOLDER
from app.lessons.labels import label_of
from app.lessons.lesson import HINTS, MOST_NUMBERS, MOST_PLOTS
from app.lessons.loading import LANGUAGES, load_notes
from app.text.equations import ALONE
from controllers.activation import activation
from scenes.lwr.facts import JOINTS
from tests.lessons.helpers import our_book


@pytest.mark.parametrize("language", LANGUAGES)
def test_all_ten_lessons_load_in_every_language(language: str) -> None:
    book = our_book(language)
    assert [str(problem) for problem in book.problems] == []
    assert [lesson.number for lesson in book.lessons] == list(range(1, 12))
    for lesson in book.lessons:
        translated = (FOLDER / lesson.file.replace(".md", f".{language}.md")).exists()
        assert lesson.language == (language if translated else "en")


def test_every_lesson_is_complete() -> None:
    for lesson in our_book().lessons:
        assert lesson.goal and lesson.equations and 5 <= lesson.minutes <= 25
        assert any(step.question for step in lesson.steps)
        assert any(step.challenge for step in lesson.steps)
        for step in lesson.steps:
            assert len(step.plots) <= MOST_PLOTS and 1 <= len(step.numbers) <= MOST_NUMBERS
            assert len(step.hints) == (HINTS if step.challenge else 0)
            assert step.measurements
            if step.question:
                wrong = [choice for i, choice in enumerate(step.question.choices) if i != step.question.right]
                assert all(choice.why for choice in wrong), (lesson.id, step.id)
                assert step.explain and "measured:" in "".join(choice.reply for choice in step.question.choices)


def test_every_equation_can_be_drawn() -> None:
    zmath = pytest.importorskip("ziamath").zmath
    found = 0
    for path in sorted(FOLDER.glob("*.md")):
        text = re.sub(r"`[^`]*`", "", re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL))
        assert text.replace("$$", "").count("$") % 2 == 0
        for display, inline in re.findall(r"\$\$(.+?)\$\$|\$(.+?)\$", text, flags=re.DOTALL):
            tex = re.sub(r"\\tag\{[^}]*\}", "", display or inline).strip()
            assert "<svg" in zmath.Latex(tex).svg()
            found += 1
    assert found > 150


def test_translations_keep_the_numbers_and_the_equations() -> None:
    english = our_book()
    for language in LANGUAGES[1:]:
        translated = [lesson for lesson in our_book(language).lessons if lesson.language == language]
        assert len(translated) >= 3
        for lesson in translated:
            original = english.lessons[english.index(lesson.id)]
            for step, before in zip(lesson.steps, original.steps, strict=True):
                for pattern in (r"\{(?:measured|setting):[^}]*\}", r"\\tag\{[^}]*\}"):
                    assert sorted(set(re.findall(pattern, words_of(step)))) == sorted(set(re.findall(pattern, words_of(before))))
                assert words_of(step) != words_of(before)


def words_of(step: object) -> str:
    """All texts of a step."""
    return repr(dataclasses.astuple(step))  # pyright: ignore[reportArgumentType]


def test_every_lesson_has_notes_that_no_lesson_contains() -> None:
    notes = load_notes()
    for lesson in our_book().lessons:
        note = notes.pop(lesson.id)
        assert "**Answers.**" in note
        everything = repr(lesson)
        assert not any(line in everything for line in note.splitlines() if len(line) > 20)
    assert not notes


def test_our_pictures_are_svg_with_a_title() -> None:
    texts = "".join(path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md"))
    pictures = sorted(FOLDER.glob("pictures/*"))
    assert len(pictures) >= 5
    for path in pictures:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
        assert root.tag.endswith("svg") and (root[0].text or "").strip()
        assert f"(pictures/{path.name})" in texts


def test_what_translated_lessons_measure_is_named_in_their_language() -> None:
    """Of lessons 1 to 3, but for symbols, which are the same everywhere."""
    for language in LANGUAGES[1:]:
        for lesson in our_book(language).lessons[:3]:
            for step in lesson.steps:
                measured = [*step.measurements, *step.numbers]
                if step.challenge:
                    measured += [c.measurement for c in step.challenge.criteria]
                for m in measured:
                    name = label_of(m, language)
                    assert name and "{" not in name
                    assert name != label_of(m) or m.name in ("gain_step", "first_jump_formula", "setting")


def test_the_documents_for_teachers_name_what_exists() -> None:
    plan = (FOLDER / "lecture-plan.md").read_text(encoding="utf-8")
    assert set(re.findall(r"--([a-z][a-z-]+)", plan)) <= {"lecture", "key", "profile", "sessions", "host"}
    minutes = [int(row.split("|")[2]) for row in plan.splitlines() if re.match(r"\| \d:\d\d ", row)]
    assert sum(minutes) == 90
    model = (FOLDER / "model.md").read_text(encoding="utf-8")
    assert all(word in model for word in ("Simplified", "leaves open", "Euler", "out of authority"))


def test_what_pulls_at_the_elbow_is_called_as_on_the_panel_beside_it() -> None:
    """In lessons 1 and 2 the panel shows N q̇₀; q̇_n is what the whole task asks for."""
    assert r"N\,\dot q_0" in ALONE.lines[0]
    for path in [path for number in ("01", "02") for path in FOLDER.glob(f"{number}-*.md")]:
        text = path.read_text(encoding="utf-8")
        assert r"\dot q_n" not in text and (r"N\,\dot q_0" in text or path.name.endswith(".notes.md"))
    for path in FOLDER.glob("03-*.md"):
        assert not re.search(r"\bjerk|\bRuck\b|\bsunek\b", path.read_text(encoding="utf-8")), path.name


def test_the_model_says_what_the_program_and_the_paper_do() -> None:
    """Top speeds of the arm, λ in overlap, and who avoids."""
    model = (FOLDER / "model.md").read_text(encoding="utf-8")
    speeds = [round(math.degrees(joint.velocity_limit)) for joint in JOINTS]
    assert f"({min(speeds)}° to {max(speeds)}° a second)" in model
    for text in (model, (FOLDER.parents[1] / "README.md").read_text(encoding="utf-8")):
        assert "min(1" not in text and r"\min\left(1" not in text and re.search(r"d \\?(leq|≤) 0", text)
    assert activation(-0.05, 0.15, 3.0) == activation(0.0, 0.15, 6.0) == 1.0
    assert "in Fig. 5 the left robot stays at its place and avoids" in model and "both robots avoid each other" in model
