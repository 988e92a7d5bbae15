"""Lessons of a server and of a visitor."""

import logging
from collections.abc import Mapping

import viser

from app.features.lessons.lesson import LessonBook
from app.features.lessons.lesson_options import LessonOptions
from app.features.lessons.library import Library
from app.features.lessons.panel.teachers_tab import TeachersTab
from app.features.lessons.panel.welcome import Welcome, is_for_newcomers
from app.features.lessons.session.lesson_session import LessonSession
from app.hosting.app_context import AppContext
from app.hosting.server_part import ServerPart, Visit, VisitorPart
from app.hosting.teacher_key import is_teacher
from app.hosting.visitor_record import VisitorRecord
from app.page.view import View
from app.session.frame import Frame
from app.session.session import Session
from app.settings import WHOLE, Language
from controllers.errors import LazyText

log = logging.getLogger("duet.lessons")

MOST_PROBLEMS = 5


class LessonServer(ServerPart):
    """`library`: has teacher's notes only if the server has a key."""

    def __init__(self, context: AppContext) -> None:
        options, own = context.options, context.options.of(LessonOptions)
        self._context, self.library = context, Library(own.lessons, own.playlist, options.key is not None)
        for problem in self.library.book.problems:
            log.warning("a lesson was left out: %s", problem)
        if options.shared is None:
            # A shared session keeps its first lessons.
            self.library.watch(context.wake)

    @property
    def book(self) -> LessonBook:
        return self.library.book

    def visit(self, visit: Visit) -> VisitorPart:
        return LessonVisit(self._context, self.library, visit)

    def prepare(self, language: Language) -> None:
        self.book.in_language(language)

    def close(self) -> None:
        self.library.close()


class LessonVisit(VisitorPart):
    def __init__(self, context: AppContext, library: Library, visit: Visit) -> None:
        self._workload, self._library, self._session = context.workload, library, visit.session
        self._query, self._language = visit.query, visit.language
        self._lessons = visit.session.parts.of(LessonSession)
        if not visit.back:
            self._lessons.begin_with(library.book, visit.language)
        self._welcomes = visit.private and visit.new and is_for_newcomers(visit.query)
        self._teaches = visit.private and is_teacher(context.options.key, visit.query)
        self._welcome: Welcome | None = None
        self._notes: TeachersTab | None = None

    def open(self, record: VisitorRecord | None) -> tuple[str, ...]:
        return open_link(self._lessons, self._query, record)

    def notify(self) -> None:
        name_faults(self._session, self._library.book)

    def add_to(self, client: viser.ClientHandle, view: View) -> None:
        del view
        if self._welcomes and self._lessons.book.lessons:
            self._welcome = Welcome(client.gui, self._session, self._lessons)
        if self._teaches:
            self._notes = TeachersTab(client.gui, self._library.notes)

    def show(self, frame: Frame) -> None:
        if self._welcome is not None:
            self._welcome.show(frame)
        if self._notes is not None:
            self._notes.show(self._lessons, self._workload.report)

    @property
    def outdated(self) -> bool:
        return self._library.book.in_language(self._language) is not self._lessons.book

    def renew(self, language: Language) -> None:
        self._language = language
        self._lessons.read_again(self._library.book, language)


def name_faults(session: Session, book: LessonBook) -> None:
    for problem in book.problems[:MOST_PROBLEMS]:
        session.notify("A lesson file has a fault", str(problem))


def lesson_link(query: Mapping[str, str]) -> tuple[str, str]:
    return query.get("lesson", "")[:60], query.get("step", "")[:8]


def open_link(run: LessonSession, query: Mapping[str, str], record: VisitorRecord | None) -> tuple[str, ...]:
    """Open a link's lesson, or resume a record; a message for each impossible part of the link.

    Args:
        record: keeps only its progress if its link names another step.
    """
    lesson, step = lesson_link(query)
    if record is not None and run.left is not None:
        same = lesson_link(record.query) == (lesson, step)
        run.resume(run.left, reopen=same)
        if same:
            return ()
    if not lesson:
        return (LazyText("step = {step} also needs lesson = ….", step=step),) if step else ()
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
    """Step of a link (0-based), and a message; "" if valid."""
    if not text:
        return 0, ""
    if text.isascii() and text.isdecimal() and int(text) >= 1:
        return int(text) - 1, ""
    return 0, LazyText("step = {step} is not a number from 1.", step=text)
