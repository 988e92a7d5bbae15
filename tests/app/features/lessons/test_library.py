"""Lessons of a server: ours, a folder's, a playlist's, their order; and changed files."""

import os
import re
from collections.abc import Callable
from itertools import chain, repeat
from pathlib import Path
from threading import Event
from unittest.mock import MagicMock

import pytest

from app.__main__ import run_command as main
from app.features.lessons import library as library_module
from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import LAST, LessonBook
from app.features.lessons.lesson_options import LessonOptions
from app.features.lessons.library import Library, notes_of
from app.features.lessons.loading import load_lessons
from app.features.lessons.panel.lesson_visit import LessonServer
from app.features.lessons.panel.teachers_tab import NotesView
from app.features.lessons.reference_runs import simulated
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from app.text.lesson_text import lesson_html
from tests.app.conftest import Arrive, OpenHouse, visitor_of
from tests.app.features.lessons.helpers import SMALL, lessons_of, our_book
from tests.approved import Approve

OURS = [lesson.id for lesson in our_book().lessons]

QUESTION = """## Why {name}

```duet
concept = true
right = 2
```

### Predict

Is it so?

1. Yes.
   > It is not.
2. No.
   > It is not.

"""


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorter period between checks of the files."""
    monkeypatch.setattr(library_module, "PERIOD", 0.1)


def ids(book: LessonBook) -> list[str]:
    return [lesson.id for lesson in book.lessons]


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_a_folders_lessons_follow_ours_between_the_two_tests(tmp_path: Path) -> None:
    write(tmp_path / "01-nearer.md", SMALL)
    write(tmp_path / "02-drift.md", SMALL)
    write(tmp_path / "02-drift.notes.md", "Of this folder.")
    library = Library(tmp_path, with_notes=True)
    book = library.book
    assert ids(book) == ["beliefs", *OURS, "nearer", "beliefs" + LAST] and not book.problems
    assert [lesson.number for lesson in book.lessons] == [*range(len(OURS) + 3)]
    assert book.lessons[book.first].id == OURS[0]
    drift = book.lessons[book.index("drift")]
    assert drift.title == "A small lesson" and library.notes["drift"] == "Of this folder."
    assert library.notes["beliefs"] == library.notes["beliefs" + LAST] and not Library(tmp_path).notes
    german = book.in_language("de")
    assert ids(german) == ids(book) and german.lessons[0].language == german.lessons[-1].language == "de"
    assert german.lessons[0].title != german.lessons[-1].title and book.in_language("de") is german


def test_a_playlist_may_name_lessons_and_steps_in_any_order(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "theirs" / "07-nearer.md", SMALL)
    write(
        tmp_path / "mine" / "03-quiz.md",
        "# Quiz\n\nTwo questions.\n\n" + "".join(QUESTION.format(name=name) for name in "ab"),
    )
    names = (
        *("beliefs", "hold#push", "hold#3", "lambda", "mine/03-quiz.md", "nearer#second"),
        *("lambda#tail", "hold", "beliefs", "beliefs#delay"),
    )
    playlist = write(tmp_path / "week.toml", f"lessons = {list(names)}\n".replace("'", '"'))
    book = Library(tmp_path / "theirs", playlist).book
    assert not book.problems
    assert ids(book) == [
        "beliefs",
        "hold",
        "lambda",
        "quiz",
        "nearer",
        "lambda_2",
        "hold_2",
        "beliefs" + LAST,
        "beliefs_3",
    ]
    assert [lesson.number for lesson in book.lessons] == [*range(1, 10)]
    steps = [[step.id for step in lesson.steps] for lesson in book.lessons]
    assert (
        steps[1] == ["push", "break"]
        and steps[5] == ["tail"]
        and steps[4] == ["second"]
        and len(steps[2]) > 1
    )
    assert [lesson.asked for lesson in book.lessons] == ["first", *[""] * 6, "last", ""]
    minutes, whole = {lesson.id: lesson.minutes for lesson in book.lessons}, our_book().lessons[3]
    assert minutes["lambda"] == whole.minutes and minutes["lambda_2"] == round(
        whole.minutes / len(whole.steps)
    ), whole.id
    capsys.readouterr()
    assert main(["lessons", "--playlist", str(playlist), "--folder", str(tmp_path / "theirs")]) == 0
    assert f" 1 step, {minutes['lambda_2']} min" in capsys.readouterr().out


def test_a_teacher_gets_the_notes_to_a_playlists_steps(tmp_path: Path) -> None:
    write(tmp_path / "theirs" / "02-drift.md", SMALL)
    playlist = write(tmp_path / "week.toml", 'lessons = ["lambda#tail", "drift", "lambda"]')
    library = Library(tmp_path / "theirs", playlist, with_notes=True)
    assert ids(library.book) == ["lambda", "drift", "lambda_2"]
    assert library.notes == dict.fromkeys(("lambda", "lambda_2"), notes_of(our_book())["lambda"]), (
        "a folder's lesson does not get our notes"
    )
    run, gui = LessonSession(Session(Settings()), library.book), MagicMock()
    run.enter("lambda")
    NotesView(gui, library.notes).show(run)
    tail = our_book().lessons[our_book().index("lambda")].steps[run.walk.step.number - 1]
    assert tail.id == "tail"
    assert gui.add_html.return_value.content.partition("</h4>")[0].endswith(
        f"<h4>{tail.number}. {tail.title}"
    )


def said(book: LessonBook) -> str:
    """All problems, one line each."""
    return "".join(f"{one.file}, line {one.line}: {one.message}\n" for one in book.problems)


def test_faults_of_a_playlist_are_named_in_the_order_of_its_entries(tmp_path: Path, approve: Approve) -> None:
    write(
        tmp_path / "01-bad.md",
        SMALL.replace("right = 2", "right = 9").replace('id = "second"', 'id = "second"\ncolour = 1'),
    )
    playlist = write(
        tmp_path / "week.toml",
        'lessons = [\n  "hold",\n  "holt",\n  "hold#pull",\n  "01-bad.md",\n  "02-none.md",\n]\n',
    )
    book = Library(None, playlist).book
    assert ids(book) == ["hold"]
    right = SMALL[: SMALL.index("right = 2")].count("\n") + 1
    assert ("01-bad.md", right) in [(problem.file, problem.line) for problem in book.problems]
    approve("playlist.txt", said(book))


@pytest.mark.parametrize(
    "text", ["lessons = 3", "[", 'lessons = ["hold"]\nx = 1'], ids=["number", "toml", "key"]
)
def test_an_invalid_playlist_has_one_fault(
    tmp_path: Path, text: str, approve: Approve, request: pytest.FixtureRequest
) -> None:
    book = Library(None, write(tmp_path / "week.toml", text)).book
    assert len(book.problems) == 1
    # The rest is Python's own message.
    approve(f"none {request.node.callspec.id}.txt", said(book).partition(" here: ")[0].strip() + "\n")


def test_faults_in_one_line_of_a_playlist_are_named_with_their_entries(
    tmp_path: Path, approve: Approve
) -> None:
    playlist = 'lessons = ["hold", "nope", "lambda#", "../x.md",\n3, ""]\nx = 1'
    book = Library(None, write(tmp_path / "week.toml", playlist)).book
    assert ids(book) == ["hold"]
    approve("entries.txt", said(book))


def again(library: Library) -> bool:
    """Refresh twice, because a changed file must first be stable."""
    return library.refresh() or library.refresh()


def test_a_changed_file_is_read_again_and_a_faulty_one_is_not_used(tmp_path: Path) -> None:
    lesson, playlist = (
        write(tmp_path / "01-small.md", SMALL),
        write(tmp_path / "week.toml", 'lessons = ["small#first"]'),
    )
    library = Library(tmp_path, playlist)
    assert not again(library)
    for path, text, titles, faults in (
        (lesson, SMALL.replace("# A small", "# Another small"), ["Another small lesson"], ()),
        (lesson, SMALL.replace("right = 2", "right = 9"), ["Another small lesson"], ("stays as it was",)),
        (
            playlist,
            'lessons = ["small", "hold"]',
            ["Another small lesson", "Hold while a person pushes"],
            ("stays as it was",),
        ),
        (
            playlist,
            "lessons = [",
            ["Another small lesson", "Hold while a person pushes"],
            ("stays as it was", "not TOML"),
        ),
        (lesson, SMALL, ["A small lesson", "Hold while a person pushes"], ("not TOML",)),
        (playlist, 'lessons = ["small"]', ["A small lesson"], ()),
    ):
        write(path, text)
        assert again(library) and not again(library)
        book = library.book
        assert [one.title for one in book.lessons] == titles
        assert len(book.problems) == len(faults) and all(part in str(book.problems) for part in faults)
    os.remove(lesson)
    assert again(library) and not library.book.lessons and library.book.problems


def test_changed_pictures_and_simulated_runs_are_renewed_too(tmp_path: Path) -> None:
    write(tmp_path / "01-small.md", SMALL)
    svg = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><text>old</text></svg>'
    picture = write(tmp_path / "pictures" / "a.svg", svg)
    library, text = Library(tmp_path), "![what](pictures/a.svg)"
    setup = library.book.lessons[library.book.index("small")].steps[1].setup
    before = simulated(setup)
    assert "old" in lesson_html(text, tmp_path)
    write(picture, svg.replace("old", "newer"))
    assert again(library)
    assert "newer" in lesson_html(text, tmp_path) and simulated(setup) is not before


def test_a_visitor_gets_a_changed_text_without_a_restart(
    tmp_path: Path, house: OpenHouse, arrive: Arrive
) -> None:
    path = write(tmp_path / "01-small.md", SMALL)
    opened = house(features=(LessonOptions(lessons=tmp_path),))
    guest = arrive(opened, "lesson=small")
    visitor = visitor_of(opened)
    guest.wait(lambda _: lessons_of(visitor).open)

    def reads(title: str) -> Callable[[object], bool]:
        return lambda _: lessons_of(visitor).open and lessons_of(visitor).walk.lesson.title == title

    write(path, SMALL.replace("# A small", "# Another small"))
    guest.wait(reads("Another small lesson"))
    write(path, SMALL.replace("right = 2", "right = 9"))
    guest.wait(
        lambda _: (
            bool(opened.context.part(LessonServer).book.problems)
            and lessons_of(visitor).book is opened.context.part(LessonServer).book
        )
    )
    assert reads("Another small lesson")(None)
    write(path, SMALL)
    guest.wait(reads("A small lesson"))


def test_the_files_are_still_watched_after_a_failed_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "01-small.md", SMALL)
    library, read = Library(tmp_path), Event()
    monkeypatch.setattr(
        library, "refresh", MagicMock(side_effect=chain((RuntimeError("bad"), True), repeat(False)))
    )
    library.watch(read.set)
    assert read.wait(60.0)
    library.close()


def test_a_new_lesson_passes_its_check_and_fits_the_readmes_playlist(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    path = tmp_path / "my own" / "mine" / "01-nearer.md"
    assert main(["new-lesson", str(path)]) == 0
    assert f"--folder '{path.parent}'" in capsys.readouterr().out
    assert main(["lessons", "--check", "--folder", str(path.parent)]) == 0
    assert "0 not as declared" in capsys.readouterr().out
    (text,) = re.findall(
        r"```toml\n(lessons = .*?)```", (FOLDER / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL
    )
    book = Library(None, write(path.parents[1] / "week-3.toml", text)).book
    assert not book.problems and [step.id for step in book.lessons[book.index("nearer")].steps] == [
        "the_stop"
    ]
    for bad, message in ((path, "a file already"), (path.with_name("nearer.md"), "is like 01-nearer.md")):
        assert main(["new-lesson", str(bad)]) == 2 and message in capsys.readouterr().err
    text = path.read_text(encoding="utf-8")
    for old, new in (("n = 2.0", "n = 200.0"), ("minutes = 6", "minute = 6")):
        assert text.count(old) == 1
        text = text.replace(old, new)
    write(path, text)
    assert main(["lessons", "--check", "--folder", str(path.parent)]) == 1
    approve("faults.txt", capsys.readouterr().out.splitlines()[-1] + "\n")
    assert main(["lessons", "--playlist", str(tmp_path / "none.toml")]) == 2


def test_faults_of_a_question_without_a_run_are_named(tmp_path: Path) -> None:
    good = "# Quiz\n\nOne question.\n\n" + QUESTION.format(name="a")
    write(tmp_path / "01-quiz.md", good)
    assert not load_lessons(tmp_path).problems
    for old, new, message in (
        ("right = 2", 'right = 2\nplots = ["distance"]', "without a run has no plots"),
        ("### Predict", "### Goal", "needs a section “### Predict”"),
        ("One question.", "One question.\n\n### Again\n\nNow?", ""),
        ("concept = true", "", "needs an outcome"),
    ):
        write(tmp_path / "01-quiz.md", good.replace(old, new))
        assert message in str(load_lessons(tmp_path).problems) and bool(message) == bool(
            load_lessons(tmp_path).problems
        )
