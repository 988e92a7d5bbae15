"""Reads lessons and notes from Markdown; faulty files are reported, the others load."""

import errno
import os
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Final, NamedTuple

from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import NO_LESSONS, Lesson, LessonBook, LessonProblem, Step
from app.features.lessons.markdown import Chapter, Fault, FaultLog, Sheet, read_items, read_sheet
from app.features.lessons.setups import usual_setup
from app.features.lessons.steps import (
    LEFT_DOLLAR,
    head_faults,
    head_texts,
    read_lesson,
    read_step,
    step_texts,
)
from app.settings import TRANSLATIONS, Language
from app.text.lesson_text import left_dollar
from app.text.picture import picture_problems
from scenes.files import read_file

_STEP: Final = re.compile(r"^## +(\d{1,3})\b[.:]? *(.*)$", re.MULTILINE)


class StepNotes(NamedTuple):
    """Notes on a step. `number`: 1-based."""

    number: int
    title: str
    text: str


class Notes(NamedTuple):
    """Notes on a lesson (Markdown); `title` and `text` may be empty."""

    title: str
    text: str
    steps: tuple[StepNotes, ...]


def read_notes(text: str) -> Notes:
    """Parse notes; text under no step is about the lesson. Never raises."""
    whole, *parts = _STEP.split("\n".join(text.strip().splitlines()))
    first, _, rest = whole.partition("\n")
    title = re.sub("^#+ *", "", first) if first.startswith("#") else ""
    steps = zip(parts[0::3], parts[1::3], parts[2::3], strict=True)
    about = (rest if title else whole).strip()
    return Notes(
        title,
        about,
        tuple(StepNotes(int(number), name.strip(), said.strip()) for number, name, said in steps),
    )


MOST_BYTES: Final = 200_000
"""Largest lesson file [bytes]."""

_NAME: Final = re.compile(r"^(\d{1,3})-([a-z0-9-]+)(?:\.([a-z]{2}|notes))?\.md$")


def load_lessons(
    folder: Path = FOLDER, language: Language = "en", before: LessonBook = NO_LESSONS
) -> LessonBook:
    """Load a folder's lessons in order, and report faults. Never raises.

    A lesson is a file `NN-name.md`; `NN-name.de.md` has its texts in another language, `NN-name.notes.md` the
    teacher's notes. Names without a leading digit are ignored.

    Args:
        language: missing translations stay English.
        before: earlier state, kept for files that have become faulty.
    """
    try:
        files = sorted(path for path in folder.iterdir() if path.suffix == ".md" and path.name[0].isdigit())
    except OSError as error:
        return LessonBook(
            (), (LessonProblem(str(folder), 0, f"the folder cannot be read ({error.strerror})."),)
        )
    lessons: list[Lesson] = []
    problems: list[LessonProblem] = []
    for path in files:
        try:
            problems += _load(path, lessons)
        except Fault as fault:
            kept = [lesson for lesson in before.lessons if lesson.file == path.name]
            lessons += kept
            problems += problems_of(
                path, fault, " The lesson stays as it was before the change." if kept else ""
            )
    if language != "en":
        lessons = [_translated(folder, lesson, language, problems) for lesson in lessons]
    if not lessons and not problems:
        problems.append(
            LessonProblem(
                str(folder),
                0,
                "holds no lesson; a lesson is a file like 01-redundancy.md, see README.md there.",
            )
        )
    in_order = tuple(sorted(lessons, key=lambda lesson: lesson.number))
    return LessonBook(in_order, tuple(problems), cache(lambda other: load_lessons(folder, other, before)))


def problems_of(path: Path, fault: Fault, more: str = "") -> list[LessonProblem]:
    return [LessonProblem(path.name, one.line, one.message + more) for one in fault.all]


def _load(path: Path, lessons: list[Lesson]) -> Iterator[LessonProblem]:
    """Append the lesson of a file; yield the faults of its notes."""
    name = _NAME.match(path.name)
    if name is None:
        raise Fault(
            1, "the name of a lesson is like 01-redundancy.md, of a translation like 01-redundancy.de.md."
        )
    if name[3] is None:
        lesson = _read(path, int(name[1]), name[2])
        if any(other.id == lesson.id or other.number == lesson.number for other in lessons):
            raise Fault(1, "another lesson has the same number or name; every lesson has its own.")
        lessons.append(lesson)
    elif name[3] not in (*TRANSLATIONS, "notes"):
        raise Fault(1, f"there is no language {name[3]}; choose from {', '.join(TRANSLATIONS)}.")
    elif not os.path.lexists(path.with_name(f"{name[1]}-{name[2]}.md")):
        raise Fault(1, f"belongs to {name[1]}-{name[2]}.md, which is not there.")
    elif name[3] == "notes":
        yield from _faults_of_notes(path)


def _faults_of_notes(path: Path) -> Iterator[LessonProblem]:
    try:
        text = read_text(path)
    except Fault:
        return
    if (left := left_dollar(text)) is not None:
        yield LessonProblem(path.name, left + 1, LEFT_DOLLAR)
    for number, line in enumerate(text.splitlines(), 1):
        for problem in picture_problems(line, path.parent, not line.startswith("#")):
            yield LessonProblem(path.name, number, problem)


def read_text(path: Path) -> str:
    """Text of a file.

    Raises:
        Fault: unreadable, too large, or not UTF-8.
    """
    try:
        data = read_file(path, MOST_BYTES)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise Fault(
                1, f"the file is larger than {MOST_BYTES // 1000} kB; a lesson is a few pages of text."
            ) from None
        raise Fault(1, f"the file cannot be read ({error.strerror}).") from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise Fault(line, "the file is not UTF-8 text; save it as UTF-8.") from None


def _read(path: Path, number: int, id: str) -> Lesson:
    sheet, log = read_sheet(read_text(path)), FaultLog()
    read, head = log.take(lambda: read_lesson(sheet, path.parent), None), sheet.head
    # Steps build on the settings of the header.
    base, equations, minutes = read or (usual_setup(path.parent), "", 0)
    steps: list[Step] = []
    for place, part in enumerate(sheet.steps if read is not None or not head.blocks else (), 1):
        step = log.take(partial(read_step, part, base), None)
        if step is not None and any(other.id == step.id for other in steps):
            log.found.append(
                Fault(part.line, f"two steps are called {step.id}; give one of them another id.")
            )
        elif step is not None:
            steps.append(replace(step, number=place))
    promise, learned, again = head_texts(head)
    runs = (
        [part.line for part, step in zip(sheet.steps, steps, strict=False) if not step.concept]
        if again
        else []
    )
    log.found += [
        Fault(line, "a test that is asked twice has questions without a run alone; add concept = true.")
        for line in runs
    ]
    log.close()
    texts = head.title, head.text, equations, minutes, promise, learned
    return Lesson(id, number, path.name, "en", *texts, tuple(steps), again)


def _translated(folder: Path, lesson: Lesson, language: Language, problems: list[LessonProblem]) -> Lesson:
    """Unchanged if its texts are missing or do not fit."""
    path = folder / lesson.file.replace(".md", f".{language}.md")
    if not os.path.lexists(path):
        return lesson
    try:
        sheet, log = read_sheet(read_text(path)), FaultLog()
        _compare(sheet, lesson)
        log.found += head_faults(sheet.head, folder)
        pairs = zip(lesson.steps, sheet.steps, strict=True)
        steps = tuple(log.take(partial(_with_texts, step, part), step) for step, part in pairs)
        log.close()
    except Fault as fault:
        problems += problems_of(path, fault)
        return lesson
    head = sheet.head
    promise, learned, again = head_texts(head)
    return replace(
        lesson,
        language=language,
        title=head.title,
        goal=head.text,
        promise=promise or lesson.promise,
        learned=learned or lesson.learned,
        steps=steps,
        again=again or lesson.again,
    )


def _compare(sheet: Sheet, lesson: Lesson) -> None:
    if len(sheet.steps) != len(lesson.steps):
        line = sheet.steps[-1].line
        raise Fault(
            line,
            f"has {len(sheet.steps)} steps, but {lesson.file} has {len(lesson.steps)}; translate all of them.",
        )
    for part in (sheet.head, *sheet.steps):
        if part.blocks:
            raise Fault(
                part.blocks[0].line, f"a translation carries texts only; the blocks stay in {lesson.file}."
            )


def _with_texts(step: Step, part: Chapter) -> Step:
    texts = step_texts(part, step)
    question = step.question
    if question is not None:
        asked, items = read_items(part.sections["Predict"])
        if len(items) != len(question.choices):
            line = part.sections["Predict"].line
            raise Fault(line, f"has {len(items)} answers, but the English step has {len(question.choices)}.")
        choices = tuple(
            replace(c, text=i.text, reply=i.quote or c.reply)
            for c, i in zip(question.choices, items, strict=True)
        )
        question = replace(question, text=asked, choices=choices)
    challenge, challenge_text = step.challenge, texts.pop("challenge")
    if challenge is not None:
        challenge = replace(challenge, text=challenge_text)
    hints = step.hints
    if hints:
        _, items = read_items(part.sections["Hints"])
        if len(items) != len(hints):
            raise Fault(part.sections["Hints"].line, f"has {len(items)} hints; there must be {len(hints)}.")
        hints = tuple(item.text for item in items)
    return replace(step, title=part.title, question=question, challenge=challenge, hints=hints, **texts)
