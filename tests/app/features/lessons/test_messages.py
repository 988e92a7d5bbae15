"""Lesson cases of the core's `test_messages.py`."""

import io
import zipfile
from collections.abc import Callable

import pytest

from app.features.lessons.lesson import NO_LESSONS
from app.features.lessons.loading import load_lessons
from app.features.lessons.panel.lesson_visit import open_link, step_of
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.walkthrough import Walkthrough
from app.features.person_files.bvh import read_bvh
from app.i18n.catalogue import words_of
from app.i18n.speaking import set_language, tr
from app.recording.run_file import load_run
from app.session.session import Session
from app.settings import Settings, from_query
from app.text.templates import macros
from controllers.errors import LazyText
from scenes.inputs_file import recorded_from
from scenes.person.clips import Clip
from scenes.rerun import not_again
from scenes.settings import RunSettings, changed
from tests.app.features.lessons.helpers import our_book
from tests.app.features.person_files.bvh_text import MIXAMO, write_bvh
from tests.app.i18n.conftest import untranslated
from tests.app.i18n.test_messages import RUN, refusal
from tests.approved import Approve

SKELETON = write_bvh(Clip("wave", 1), MIXAMO, frames=4)


def damaged(part: str) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(RUN)) as old, zipfile.ZipFile(out, "w") as new:
        for info in old.infolist():
            if info.filename != f"{part}.npy":
                new.writestr(info, old.read(info))
    return out.getvalue()


WALK = Walkthrough(our_book())


WRONG: dict[str, Callable[[], object]] = {
    "unknown": lambda: changed(RunSettings(), "🦆", "1"),
    "choice": lambda: changed(Settings(), "theme", "🦆"),
    "flag": lambda: changed(Settings(), "whatif", "2"),
    "number": lambda: changed(RunSettings(), "dm", "-"),
    "whole": lambda: changed(RunSettings(), "seed", "1.5"),
    "range": lambda: changed(RunSettings(), "dm", "9"),
    "not a run": lambda: load_run(b"1", "🦆"),
    "empty run": lambda: load_run(damaged("about"), "🦆"),
    "nothing to compare": lambda: load_run(damaged("made"), "🦆"),
    "no inputs": lambda: recorded_from(damaged("codes"), "🦆"),
    "not a skeleton": lambda: read_bvh(b"1\n2\n", "🦆"),
    "cut skeleton": lambda: read_bvh(SKELETON[: len(SKELETON) // 3].encode(), "🦆"),
    "no elbow": lambda: read_bvh(SKELETON.replace("ForeArm", "1").replace("forearm", "1").encode(), "🦆"),
    "a word among the numbers": lambda: read_bvh(SKELETON.rstrip().rsplit(" ", 1)[0].encode() + b" -", "🦆"),
    "no lesson": lambda: WALK.go("🦆"),
    "no such lesson": lambda: WALK.go(99),
    "no lesson before": lambda: WALK.go(-1),
    "no step": lambda: WALK.go(0, 99),
    "no step before": lambda: WALK.go(0, -1),
    "an empty book": lambda: Walkthrough(NO_LESSONS),
}


@pytest.mark.parametrize("name", WRONG)
def test_all_errors_are_translated(name: str) -> None:
    said = refusal(WRONG[name])
    set_language("pseudo")
    # User texts and names of settings, lessons and joints are not translated.
    parts = [str(part) for part in leaves(said)]
    shown = tr(said)
    for part in sorted(parts, key=len, reverse=True):
        shown = shown.replace(part, "")
    assert "⟦" in shown and untranslated(shown) == []


def leaves(message: LazyText) -> list[object]:
    """Filled-in values of a message that are not messages themselves."""
    parts = (leaves(part) if isinstance(part, LazyText) else [part] for part in message.parts.values())
    return [leaf for some in parts for leaf in some if str(leaf)]


def test_problems_of_links_are_in_the_pages_language(approve: Approve) -> None:
    _, problems = from_query({"dm": "9", "🦆": "1"}, Settings())
    run = LessonSession(Session(Settings()), load_lessons())
    for link in ({"lesson": "99"}, {"lesson": "🦆"}, {"step": "2"}):
        problems += open_link(run, link, None)
    problems += (step_of("🦆")[1], not_again("🦆.py"))
    set_language("de")
    approve("links de.txt", "".join(f"{tr(problem)}\n" for problem in problems))


def test_the_lessons_labels_are_texts_of_the_page() -> None:
    # The catalogue has the texts of the page and no others, see `tests/app/i18n/test_words.py`.
    assert "Predict first" in words_of("sl").texts
    # In lessons the button has another word.
    assert words_of("sl")("lesson\x04Run") == "Zaženi" and words_of("en")("lesson\x04Run") == "Run"


def test_a_number_keeps_its_unit_in_the_boxes_of_a_lesson() -> None:
    lines = macros("features/lessons/panel/lesson.html").paragraphs(["Smallest d: 14 mm; with n = 1: 30 mm."])
    assert "14\u00a0mm" in lines and "30\u00a0mm" in lines
