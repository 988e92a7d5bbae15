"""Our own lessons: complete in every language, with notes, a bookmark and documents that name what exists; the command."""

import dataclasses
import math
import re
from pathlib import Path
from typing import Any

import pytest
import tyro

import app
from app.features.lessons.bookmark import Bookmark
from app.features.lessons.check import Walk, at_step, check_lesson, shown_early
from app.features.lessons.commands import Lessons, lessons
from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import LessonBook, Step
from app.features.lessons.library import notes_of
from app.features.lessons.loading import Notes, StepNotes, read_notes
from app.features.lessons.scripts import SCRIPTS
from app.features.lessons.steps import HINTS, MOST_NUMBERS, MOST_PLOTS
from app.features.lessons.walkthrough import Walkthrough
from app.features.measures.quantities.quantity import QUANTITIES
from app.settings import LANGUAGES, TRANSLATIONS
from app.text.law_texts import ALONE
from app.text.templates import macros
from controllers.activation import activation
from controllers.errors import BadSetting
from scenes.lwr.facts import JOINTS
from tests.app.features.lessons.helpers import SMALL, book_of, our_book

DOCUMENTS = Path(app.__file__).parent / "documents"


@pytest.mark.parametrize("language", LANGUAGES)
def test_all_twelve_lessons_load_in_every_language(language: str) -> None:
    book = our_book(language)
    assert [str(problem) for problem in book.problems] == []
    assert [lesson.number for lesson in book.lessons] == list(range(1, 13))
    assert {lesson.language for lesson in book.lessons} == {language}
    for lesson, english in zip(book.lessons, our_book().lessons, strict=True):
        said = (lesson.promise == english.promise, lesson.learned == english.learned)
        assert said == (language == "en",) * 2, lesson.file


def test_every_lesson_is_complete() -> None:
    for lesson in our_book().lessons:
        assert (
            lesson.goal
            and lesson.promise
            and lesson.learned
            and lesson.equations
            and 5 <= lesson.minutes <= 25
        )
        assert any(step.question for step in lesson.steps)
        assert any(step.challenge for step in lesson.steps)
        for step in lesson.steps:
            assert len(step.plots) <= MOST_PLOTS and 1 <= len(step.numbers) <= MOST_NUMBERS
            assert len(step.hints) == (HINTS if step.challenge else 0) and step.measurements
            if step.question:
                wrong = [choice for i, choice in enumerate(step.question.choices) if i != step.question.right]
                assert all(choice.why for choice in wrong), (lesson.id, step.id)
                assert step.explain and "measured:" in "".join(
                    choice.reply for choice in step.question.choices
                )


def test_translations_keep_the_numbers_and_the_equations() -> None:
    english = our_book()
    for language in TRANSLATIONS:
        for lesson, original in zip(our_book(language).lessons, english.lessons, strict=True):
            for step, before in zip(lesson.steps, original.steps, strict=True):
                for pattern in (r"\{(?:measured|setting):[^}]*\}", r"\\tag\{[^}]*\}"):
                    assert sorted(set(re.findall(pattern, words_of(step)))) == sorted(
                        set(re.findall(pattern, words_of(before)))
                    )
                assert words_of(step) != words_of(before)


def words_of(step: object) -> str:
    return repr(dataclasses.astuple(step))  # pyright: ignore[reportArgumentType]


def test_the_model_says_what_is_simplified() -> None:
    model = (DOCUMENTS / "model.md").read_text(encoding="utf-8")
    assert all(word in model for word in ("Simplified", "leaves open", "Euler", "out of authority"))


def test_what_pulls_at_the_elbow_is_called_as_on_the_panel_beside_it() -> None:
    """In lessons 1 and 2 the panel shows N q̇₀; q̇_n is what the whole task asks for."""
    assert r"N\,\dot q_0" in ALONE[0][0]
    for path in [path for number in ("01", "02") for path in FOLDER.glob(f"{number}-*.md")]:
        text = path.read_text(encoding="utf-8")
        assert r"\dot q_n" not in text and (r"N\,\dot q_0" in text or path.name.endswith(".notes.md"))
    for path in FOLDER.glob("03-*.md"):
        assert not re.search(r"\bjerk|\bRuck\b|\bsunek\b", path.read_text(encoding="utf-8")), path.name


def test_the_model_says_what_the_program_and_the_paper_do() -> None:
    model = (DOCUMENTS / "model.md").read_text(encoding="utf-8")
    speeds = [round(math.degrees(joint.velocity_limit)) for joint in JOINTS]
    assert f"({min(speeds)}° to {max(speeds)}° a second)" in model
    for text in (model, (DOCUMENTS.parents[1] / "README.md").read_text(encoding="utf-8")):
        assert "min(1" not in text and r"\min\left(1" not in text and re.search(r"d \\?(leq|≤) 0", text)
    assert activation(-0.05, 0.15, 3.0) == activation(0.0, 0.15, 6.0) == 1.0
    assert (
        "in Fig. 5 the left robot stays at its place and avoids" in model
        and "both robots avoid each other" in model
    )


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        (
            "# For *me*\n\nAll.\n\n## 2. The switch\nA.\n### Deep\nB.\n## 1\nC.\n",
            Notes(
                "For *me*", "All.", (StepNotes(2, "The switch", "A.\n### Deep\nB."), StepNotes(1, "", "C."))
            ),
        ),
        ("", Notes("", "", ())),
        ("just a word", Notes("", "just a word", ())),
        ("# Title", Notes("Title", "", ())),
        ("a\n## Without a number\nb", Notes("", "a\n## Without a number\nb", ())),
        ("## 3: c", Notes("", "", (StepNotes(3, "c", ""),))),
        ("a\n## 3rd floor", Notes("", "a\n## 3rd floor", ())),
    ],
)
def test_notes_need_no_form_but_a_heading_with_a_number_begins_a_step(text: str, notes: Notes) -> None:
    assert read_notes(text) == notes


def test_our_notes_have_a_part_for_every_step_and_say_what_no_lesson_says() -> None:
    texts = notes_of(our_book())
    for lesson in our_book().lessons:
        everything, text = repr(lesson), texts.pop(lesson.id)
        assert not any(line in everything for line in text.splitlines() if len(line) > 20)
        notes = read_notes(text)
        assert [(part.number, part.title) for part in notes.steps] == [
            (i, s.title) for i, s in enumerate(lesson.steps, 1)
        ]
        assert notes.text.startswith(f"{lesson.minutes} minutes")
        for part in notes.steps:
            assert "minutes" in part.text.partition("\n")[0] and "**Answers.**" in part.text
        assert sum(int(part.text.split()[0]) for part in notes.steps) == lesson.minutes
    assert not texts


def test_the_present_step_comes_first_and_nothing_is_left_out() -> None:
    notes = read_notes("# Title\nWhole.\n## 1. One\nA <b>.\n## 2. Two\nB.")
    for step, order in (
        (1, ("1. One", "Title", "Whole", "2. Two")),
        (2, ("2. Two", "Title", "Whole", "1. One")),
    ):
        made = macros("features/lessons/panel/notes.html").notes(notes, step, None)
        places = [made.index(text) for text in order]
        assert places == sorted(places) and made.count('class="now"') == 1 and made.count("<section") == 2
        assert "A &lt;b&gt;." in made
    assert 'class="now"' not in macros("features/lessons/panel/notes.html").notes(notes, 3, None)


BOOK = our_book()
ALL = [(i, j) for i, lesson in enumerate(BOOK.lessons) for j in range(len(lesson.steps))]


def test_every_step_is_on_the_way_there_and_back_and_is_found_by_place_and_by_name() -> None:
    way = [Bookmark(BOOK)]
    while (after := way[-1].next_to(1)) is not None:
        way.append(after)
    assert [(at.lesson_index, at.step_index) for at in way] == ALL
    assert way[0].next_to(-1) is None and [at.next_to(-1) for at in way[1:]] == way[:-1]
    at = way[0]
    for there, (i, j) in zip(way, ALL, strict=True):
        lesson = BOOK.lessons[i]
        assert there.step is lesson.steps[j] and there == Bookmark(BOOK, i, j)
        assert at.at(i, j) == at.at(lesson.id, j) == at.of(lesson.id, lesson.steps[j].id) == there
    assert at.of("no such lesson", "") == at.of(BOOK.lessons[1].id, "no such step") == Bookmark(BOOK)


README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_the_example_of_the_readme_is_a_lesson_that_passes_its_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (example,) = re.findall(r"````markdown\n(.*?)\n````\n", README, flags=re.DOTALL)
    assert "01-nearer.md" in README
    (tmp_path / "01-nearer.md").write_text(example, encoding="utf-8")
    assert lessons(Lessons(check=True, folder=tmp_path, out=tmp_path / "check.json")) == 0
    assert "0 not as declared" in capsys.readouterr().out
    assert tyro.cli(Lessons, args=["--check", "--only", "nearer", "--folder", str(tmp_path)]) == Lessons(
        True, ("nearer",), tmp_path
    )
    assert '"nearer"' in (tmp_path / "check.json").read_text(encoding="utf-8")


def test_the_readme_names_everything_there_is() -> None:
    for name, quantity in QUANTITIES.items():
        (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
        assert all(parameter in row for parameter in quantity.parameters)
        assert row.rstrip(" |").endswith("live") == quantity.live
    for name, known in SCRIPTS.items():
        (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
        assert all(f"`{parameter}`" in row for parameter in known.parameters)


def test_the_list_names_the_lessons_and_what_was_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert lessons(Lessons()) == 0
    printed = capsys.readouterr().out
    assert all(lesson.title in printed for lesson in our_book().lessons)
    book_of(tmp_path, SMALL.replace("right = 2", "right = 9"))
    book_of(tmp_path, name="02-good.md")
    assert lessons(Lessons(folder=tmp_path)) == 1
    assert "fault: 01-small.md, line" in capsys.readouterr().out


def test_bad_commands_are_named(tmp_path: Path) -> None:
    with pytest.raises(BadSetting, match="choose from 0 beliefs, 1 redundancy"):
        lessons(Lessons(only=("x",)))
    with pytest.raises(BadSetting, match="add --check"):
        lessons(Lessons(out=tmp_path / "x.json"))
    with pytest.raises(BadSetting, match="there is no folder"):
        lessons(Lessons(check=True, only=("lambda",), out=tmp_path / "none" / "x.json"))


def walks_with(place: int, step: Step, **changes: Any) -> tuple[Walk, ...]:
    """The walks through a lesson of ours, from 0, that has this step alone."""
    lesson = dataclasses.replace(our_book().lessons[place], steps=(step,), **changes)
    return check_lesson(LessonBook((lesson,), ()), lesson)


def asked_alone(step: Step) -> Step:
    return dataclasses.replace(step, challenge=None, trials=())


def test_the_check_asks_our_lessons_for_what_the_list_shows() -> None:
    """What does show it is not named: `test_lessons.py` walks all of ours."""
    walks = walks_with(4, asked_alone(our_book().lessons[4].steps[0]), promise="")
    (walk,) = [walk for walk in walks if walk.name == "list"]
    assert not walk.ok and "### Promise" in walk.text


def test_the_check_finds_a_page_that_shows_the_answer_while_it_asks(monkeypatch: pytest.MonkeyPatch) -> None:
    book = our_book()
    monkeypatch.setattr(Walkthrough, "locked", False)
    told = {
        lesson.id: list(shown_early(at_step(book, lesson, int(lesson.steps[0].at_lever))))
        for lesson in book.lessons
    }
    assert (
        told["strict-priority"]
        == told["hold"]
        == ["λ and what follows from it, on the card of the line of contact"]
    )
    assert told["lambda"][1:] == ["the plot curve"] and told["stability"][1:] == ["the plot stability"]
    (walk,) = [
        walk for walk in walks_with(3, asked_alone(book.lessons[3].steps[1])) if walk.name == "questions"
    ]
    assert not walk.ok and walk.text.startswith("shown while it is asked: curve: λ")


def test_positive_control_the_check_notices_what_goes_otherwise(tmp_path: Path) -> None:
    text = (
        SMALL.replace("right = 2", "right = 1")
        .replace("choice = 1", "choice = 2")
        .replace("at_least = 5.0", "at_least = 1.0")
    )
    book = book_of(tmp_path, text)
    walks = {(walk.kind, walk.name): walk for walk in check_lesson(book, book.lessons[0])}
    assert "does not speak for the right answer" in walks["reference", "the right answers"].text
    assert "speaks for the wrong answer" in walks["answer", "answer 2"].text
    assert "fails by nothing instead of ('n',)" in walks["attempt", "less"].text
    assert "passes with nothing changed: n: 2, as asked" in walks["untouched", "as the step starts it"].text
    assert not walks["lesson", "wrong paths"].ok
    assert not any(
        walks[key].ok
        for key in (("reference", "the right answers"), ("answer", "answer 2"), ("attempt", "less"))
    )


def test_a_contrast_with_the_number_of_the_question_says_that_this_is_the_point() -> None:
    step = our_book().lessons[5].steps[0]
    assert step.question is not None and step.question.choices[0].same
    choices = tuple(
        dataclasses.replace(one, same=one.why is not None and not one.same) for one in step.question.choices
    )
    other = dataclasses.replace(
        asked_alone(step), question=dataclasses.replace(step.question, choices=choices)
    )
    walks = {walk.name: walk for walk in walks_with(5, other)}
    assert not walks["answer 1"].ok and "say same = true" in walks["answer 1"].text
    assert not walks["answer 3"].ok and "which is not the same" in walks["answer 3"].text


def test_a_challenge_that_a_movement_alone_passes_is_noticed() -> None:
    swing = our_book().lessons[0].steps[2]
    assert swing.challenge is not None
    lenient = tuple(
        dataclasses.replace(c, high=0.004) if c.measurement.id == "hand" else c
        for c in swing.challenge.criteria
    )
    step = dataclasses.replace(swing, challenge=dataclasses.replace(swing.challenge, criteria=lenient))
    (walk,) = [walk for walk in walks_with(0, step) if walk.kind == "untouched"]
    assert not walk.ok and "passes with nothing changed" in walk.text and "3.42 mm, as asked" in walk.text
