"""The command that checks lessons, and the document that says how they are written."""

import dataclasses
import re
from pathlib import Path

import pytest
import tyro

from app.cli.lessons import Lessons, lessons
from app.lessons import FOLDER
from app.lessons.check import check_lesson
from app.lessons.measures import QUANTITIES
from app.lessons.scripts import SCRIPTS
from controllers.errors import BadSetting
from tests.lessons.helpers import SMALL, book_of, our_book

README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_the_example_of_the_readme_is_a_lesson_that_passes_its_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


def test_the_list_names_the_lessons_and_what_was_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lessons(Lessons()) == 0
    printed = capsys.readouterr().out
    assert all(lesson.title in printed for lesson in our_book().lessons)
    book_of(tmp_path, SMALL.replace("right = 2", "right = 9"))
    book_of(tmp_path, name="02-good.md")
    assert lessons(Lessons(folder=tmp_path)) == 1
    assert "left out: 01-small.md, line" in capsys.readouterr().out


def test_bad_commands_are_named(tmp_path: Path) -> None:
    with pytest.raises(BadSetting, match="choose from redundancy"):
        lessons(Lessons(only=("x",)))
    with pytest.raises(BadSetting, match="there is no folder"):
        lessons(Lessons(check=True, only=("lambda",), out=tmp_path / "none" / "x.json"))


def test_positive_control_the_check_notices_what_goes_otherwise(tmp_path: Path) -> None:
    text = SMALL.replace("right = 2", "right = 1").replace("choice = 1", "choice = 2").replace("at_least = 5.0", "at_least = 1.0")
    book = book_of(tmp_path, text)
    walks = {(walk.kind, walk.name): walk for walk in check_lesson(book, book.lessons[0])}
    assert "does not speak for the right answer" in walks["reference", "the right answers"].text
    assert "speaks for the wrong answer" in walks["answer", "answer 2"].text
    assert "fails by nothing instead of ('n',)" in walks["attempt", "less"].text
    assert "passes with nothing changed: n: 2, as asked" in walks["untouched", "as the step starts it"].text
    assert not walks["lesson", "wrong paths"].ok
    assert not any(walks[key].ok for key in (("reference", "the right answers"), ("answer", "answer 2"), ("attempt", "less")))


def test_a_challenge_that_a_movement_alone_passes_is_noticed(tmp_path: Path) -> None:
    book = our_book()
    lesson = book.lessons[0]
    swing = lesson.steps[2]
    assert swing.challenge is not None
    lenient = tuple(dataclasses.replace(c, high=0.004) if c.measurement.id == "hand" else c for c in swing.challenge.criteria)
    step = dataclasses.replace(swing, challenge=dataclasses.replace(swing.challenge, criteria=lenient))
    lenient_lesson = dataclasses.replace(lesson, steps=(step,))
    walks = check_lesson(dataclasses.replace(book, lessons=(lenient_lesson,)), lenient_lesson)
    (walk,) = [walk for walk in walks if walk.kind == "untouched"]
    assert not walk.ok and "passes with nothing changed" in walk.text and "3.42 mm, as asked" in walk.text
