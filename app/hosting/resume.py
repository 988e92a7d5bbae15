"""Opening what a link, or a visitor's record, asks for; the tab's script that makes it possible."""

import logging
from collections.abc import Iterator, Mapping

from app.hosting.visitor_record import VisitorRecord, lesson_link
from app.lessons.runs import LONGEST
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import WHOLE
from controllers.errors import LazyText

log = logging.getLogger("duet.hosts")


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


def run_again(session: Session, lessons: LessonSession, record: VisitorRecord) -> Iterator[None]:
    """Go on with the run of a record, after its settings and its lesson; yield every few steps that are made again for it."""
    saved = record.lessons if lessons.open else None
    if record.state is None or (saved is not None and saved.now is None):
        # The run that shows why an answer is wrong begins again.
        return
    try:
        yield from session.go_on_from(record.state, LONGEST if saved is not None else 0.0)
        lessons.run_goes_on(saved is not None and saved.measured)
    except Exception:
        log.exception("a session could not go on from its record, and begins again")
        session.reset()


def step_of(text: str) -> tuple[int, str]:
    """Return the step of a link, from 0, and the message if its text is not valid, else ""."""
    if not text:
        return 0, ""
    if text.isascii() and text.isdecimal() and int(text) >= 1:
        return int(text) - 1, ""
    return 0, LazyText("step = {step} is not a number from 1.", step=text)
