"""Opening what a link, or a visitor's record, asks for; the tab's script that makes it possible."""

from collections.abc import Mapping

from app.hosting.visitor_record import VisitorRecord, lesson_link
from app.lessons.session.lesson_session import LessonSession
from app.settings import WHOLE
from controllers.errors import LazyText


def open_link(run: LessonSession, query: Mapping[str, str], record: VisitorRecord | None) -> tuple[str, ...]:
    """Open the lesson of a link, or resume a visitor's record; return a message for every part of the link that is not possible.

    Args:
        record: of the visitor; by the same lesson link its lesson is open again, by another one only its progress counts.
    """
    lesson, step = lesson_link(query)
    if record is not None and record.lessons is not None:
        same = lesson_link(record.query) == (lesson, step)
        run.resume(record.lessons, reopen=same)
        if same:
            return ()
    if not lesson:
        return (LazyText("step = {step} needs lesson = … beside it.", step=step),) if step else ()
    index, problem = step_of(step)
    by_number = lesson.isascii() and lesson.isdecimal()
    known = [str(one.number) if by_number else one.id for one in run.book.lessons]
    # 03 is lesson 3.
    name = str(int(lesson)) if by_number else lesson
    if name not in known:
        names = ", ".join(known) or LazyText("none: the folder holds no lesson")
        return (LazyText("There is no lesson {id}; choose from {names}.", id=lesson, names=names),)
    run.enter(known.index(name), index)
    if query.get(WHOLE) == "1":
        run.vary(query)
    return (problem,) if problem else ()


def step_of(text: str) -> tuple[int, str]:
    """Return the step of a link, from 0, and the message if its text is not valid, else ""."""
    if not text:
        return 0, ""
    if text.isascii() and text.isdecimal() and int(text) >= 1:
        return int(text) - 1, ""
    return 0, LazyText("step = {step} is not a number from 1.", step=text)
