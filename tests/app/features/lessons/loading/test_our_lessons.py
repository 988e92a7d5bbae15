"""Our lessons: complete in every language; notes, bookmark, documents; the command `lessons`."""

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
from tests.approved import Approve

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


def test_the_model_names_its_simplifications() -> None:
    model = (DOCUMENTS / "model.md").read_text(encoding="utf-8")
    assert all(word in model for word in ("Simplified", "leaves open", "Euler", "out of authority"))


def test_lessons_name_the_elbows_velocity_as_the_panel_does() -> None:
    """In lessons 1 and 2 the panel shows N q̇₀; q̇_n is the velocity of the whole task."""
    assert r"N\,\dot q_0" in ALONE[0][0]
    for path in [path for number in ("01", "02") for path in FOLDER.glob(f"{number}-*.md")]:
        text = path.read_text(encoding="utf-8")
        assert r"\dot q_n" not in text and (r"N\,\dot q_0" in text or path.name.endswith(".notes.md"))
    for path in FOLDER.glob("03-*.md"):
        assert not re.search(r"\bjerk|\bRuck\b|\bsunek\b", path.read_text(encoding="utf-8")), path.name


def test_the_model_describes_the_program_and_the_paper_correctly() -> None:
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
def test_in_notes_only_a_numbered_heading_begins_a_step(text: str, notes: Notes) -> None:
    assert read_notes(text) == notes


def test_our_notes_have_a_part_for_every_step_and_repeat_no_lesson_text() -> None:
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


def test_notes_show_the_present_step_first_and_all_others() -> None:
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


def test_next_and_back_reach_every_step() -> None:
    way = [Bookmark(BOOK)]
    while (after := way[-1].next_to(1)) is not None:
        way.append(after)
    assert [(at.lesson_index, at.step_index) for at in way] == ALL
    assert way[0].next_to(-1) is None and [at.next_to(-1) for at in way[1:]] == way[:-1]
    for there, (i, j) in zip(way, ALL, strict=True):
        assert there.step is BOOK.lessons[i].steps[j] and there == Bookmark(BOOK, i, j)


def test_a_step_is_found_by_place_or_by_name() -> None:
    at = Bookmark(BOOK)
    for i, j in ALL:
        lesson, there = BOOK.lessons[i], Bookmark(BOOK, i, j)
        assert at.at(i, j) == at.at(lesson.id, j) == at.of(lesson.id, lesson.steps[j].id) == there
    assert at.of("no such lesson", "") == at.of(BOOK.lessons[1].id, "no such step") == at


README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_the_readmes_example_passes_its_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"````markdown\n(.*?)\n````\n", README, flags=re.DOTALL)
    assert "01-nearer.md" in README
    (tmp_path / "01-nearer.md").write_text(example, encoding="utf-8")
    assert lessons(Lessons(check=True, folder=tmp_path, out=tmp_path / "check.json")) == 0
    assert "0 not as declared" in capsys.readouterr().out
    assert tyro.cli(Lessons, args=["--check", "--only", "nearer", "--folder", str(tmp_path)]) == Lessons(
        True, ("nearer",), tmp_path
    )
    assert '"nearer"' in (tmp_path / "check.json").read_text(encoding="utf-8")


def test_the_readme_names_all_measurements_and_scripts() -> None:
    for name, quantity in QUANTITIES.items():
        (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
        assert all(parameter in row for parameter in quantity.parameters)
        assert row.rstrip(" |").endswith("live") == quantity.live
    for name, known in SCRIPTS.items():
        (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
        assert all(f"`{parameter}`" in row for parameter in known.parameters)


def test_the_list_names_the_lessons_and_the_faulty_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert lessons(Lessons()) == 0
    printed = capsys.readouterr().out
    assert all(lesson.title in printed for lesson in our_book().lessons)
    book_of(tmp_path, SMALL.replace("right = 2", "right = 9"))
    book_of(tmp_path, name="02-good.md")
    assert lessons(Lessons(folder=tmp_path)) == 1
    assert "fault: 01-small.md, line" in capsys.readouterr().out


def test_bad_options_of_the_command_are_named(tmp_path: Path, approve: Approve) -> None:
    said = ""
    for command in (
        Lessons(only=("x",)),
        Lessons(out=tmp_path / "x.json"),
        Lessons(check=True, only=("lambda",), out=tmp_path / "none" / "x.json"),
    ):
        with pytest.raises(BadSetting) as found:
            lessons(command)
        said += f"{found.value}\n"
    approve("commands.txt", said.replace(str(tmp_path), "…"))


def walks_with(place: int, step: Step, **changes: Any) -> tuple[Walk, ...]:
    """Walks through one of our lessons (0-based) reduced to this step."""
    lesson = dataclasses.replace(our_book().lessons[place], steps=(step,), **changes)
    return check_lesson(LessonBook((lesson,), ()), lesson)


def asked_alone(step: Step) -> Step:
    return dataclasses.replace(step, challenge=None, trials=())


def test_the_check_requires_the_lists_texts_in_our_lessons() -> None:
    """The opposite case, complete lessons, is in `test_lessons.py`."""
    walks = walks_with(4, asked_alone(our_book().lessons[4].steps[0]), promise="")
    (walk,) = [walk for walk in walks if walk.name == "list"]
    assert not walk.ok and "### Promise" in walk.text


def test_the_check_finds_a_page_that_shows_the_answer_too_early(
    monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    book = our_book()
    monkeypatch.setattr(Walkthrough, "locked", False)
    told = {
        lesson.id: list(shown_early(at_step(book, lesson, int(lesson.steps[0].at_lever))))
        for lesson in book.lessons
    }
    assert told["strict-priority"] == told["hold"] and len(told["hold"]) == 1
    assert told["lambda"][1:] == ["the plot curve"] and told["stability"][1:] == ["the plot stability"]
    (walk,) = [
        walk for walk in walks_with(3, asked_alone(book.lessons[3].steps[1])) if walk.name == "questions"
    ]
    assert not walk.ok
    approve("early.txt", f"hold: {told['hold'][0]}\n{walk.text}\n")


def test_positive_control_the_check_notices_wrong_declarations(tmp_path: Path, approve: Approve) -> None:
    text = (
        SMALL.replace("right = 2", "right = 1")
        .replace("choice = 1", "choice = 2")
        .replace("at_least = 5.0", "at_least = 1.0")
    )
    book = book_of(tmp_path, text)
    walks = {(walk.kind, walk.name): walk for walk in check_lesson(book, book.lessons[0])}
    noticed = (
        ("reference", "the right answers"),
        ("answer", "answer 2"),
        ("attempt", "less"),
        ("untouched", "as the step starts it"),
        ("lesson", "wrong paths"),
    )
    assert [key for key in noticed if walks[key].ok] == []
    said = "".join(f"{', '.join(key)}: {walks[key].text}\n" for key in noticed)
    approve("check.txt", re.sub(r"(\d\.\d{4})\d+", r"\1…", said))


def test_a_contrast_with_the_questions_number_must_declare_it() -> None:
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


def test_the_check_notices_a_challenge_passed_by_movement_alone(approve: Approve) -> None:
    swing = our_book().lessons[0].steps[2]
    assert swing.challenge is not None
    lenient = tuple(
        dataclasses.replace(c, high=0.004) if c.measurement.id == "hand" else c
        for c in swing.challenge.criteria
    )
    step = dataclasses.replace(swing, challenge=dataclasses.replace(swing.challenge, criteria=lenient))
    (walk,) = [walk for walk in walks_with(0, step) if walk.kind == "untouched"]
    assert not walk.ok
    approve("movement.txt", f"{walk.text}\n")
