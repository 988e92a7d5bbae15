"""A class without a server, and the model of its expected state, for the state machine of the class."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import cast

from app.features.classroom.class_record import NEW_CLASS, ClassRecord, class_of, interrupted
from app.features.classroom.class_summary import ClassSummary
from app.features.classroom.classroom import Classroom
from app.features.lecture.leader import Leader
from app.features.lecture.lecture_record import LectureRecorder
from app.features.lecture.teacher_control import TeacherControl
from app.features.lessons.lesson import LessonBook
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.tally import Ballot, QuestionId
from app.features.store.session_store import SessionStore
from app.hosting.app_context import AppContext
from app.hosting.visitor_record import VisitorRecord
from app.session.actions import Action
from app.session.session import Session
from app.settings import Settings
from app.web.connection import FilteredConnection
from tests.app.features.lessons.helpers import lessons_in
from tests.app.features.store.test_session_store import again

MOST_PLACES = 2


class BytesStore(SessionStore):
    """Store in memory that encodes and decodes named records, as a file does."""

    def __init__(self) -> None:
        super().__init__()
        self.named_records: dict[str, VisitorRecord] = {}

    @property
    def lasting(self) -> bool:
        return True

    def save_named(self, name: str, record: VisitorRecord) -> None:
        self.named_records[name] = again(record)

    def named(self, name: str) -> VisitorRecord | None:
        return self.named_records.get(name)


class Lecture:
    """The saved parts of a lecture, made as `app.features.lecture.lecture.LectureHost` makes them."""

    def __init__(self, store: BytesStore, book: LessonBook, clock: Callable[[], float]) -> None:
        record = interrupted(store)
        room = (None if record is None else class_of(record)) or NEW_CLASS
        self.store, self.classroom = store, Classroom(MOST_PLACES, room)
        self.session = Session(Settings() if record is None or record.state is None else record.settings)
        self.lessons: LessonSession = lessons_in(self.session, book)
        self.control = TeacherControl(self.classroom, self.session, self.lessons)
        self.leader = Leader(None, room, clock)
        context = SimpleNamespace(store=store, part=lambda kind: SimpleNamespace(book=book))
        self._recorder = LectureRecorder(cast(AppContext, context), record, self.control, self.leader)
        self._saves = 0.0

    def save(self) -> ClassRecord:
        self._saves += 10.0
        self._recorder.save(self._saves)
        record = interrupted(self.store)
        room = None if record is None else class_of(record)
        assert room is not None
        return room

    def end(self) -> None:
        self._recorder.close()

    @property
    def last_class(self) -> ClassSummary | None:
        return self._recorder.last_class

    def close(self) -> None:
        self.session.close()

    def post(self, action: Action) -> None:
        self.control.answers.put(action)
        self.control.answers.do()


def origin(number: int, is_page: bool) -> FilteredConnection:
    return cast(FilteredConnection, SimpleNamespace(address=f"10.0.0.{number}", is_page=is_page))


@dataclass
class Ask:
    """Rounds of one question, oldest first: student → ballot."""

    rounds: list[dict[str, Ballot]] = field(default_factory=lambda: [{}])
    revealed: bool = False


@dataclass
class ClassModel:
    """Expected state of the class.

    Attributes:
        here: connection → student.
        given: names of the hand-ins.
    """

    asked: dict[QuestionId, Ask] = field(default_factory=dict)
    here: dict[int, str] = field(default_factory=dict)
    given: dict[str, str] = field(default_factory=dict)
    pageless: set[str] = field(default_factory=set)
    pages_only: bool = False
    free: bool = False

    def ask(self, question: QuestionId) -> Ask:
        return self.asked.setdefault(question, Ask())

    def counted(self, question: QuestionId) -> list[dict[str, Ballot]]:
        left_out = self.pageless if self.pages_only else set[str]()
        return [
            {student: ballot for student, ballot in given.items() if student not in left_out}
            for given in self.asked.get(question, Ask()).rounds
        ]
