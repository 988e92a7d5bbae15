"""A lecture's shared session with a projector, without a server."""

from time import monotonic

from app.features.classroom.classroom import Classroom, Poll
from app.features.lecture.overlays import screen_html
from app.features.lecture.presenter import Presenter, Station
from app.features.lecture.teacher_control import TeacherControl
from app.session.frame import make_frame
from app.session.session import Session
from app.settings import Settings
from tests.app.features.lessons.helpers import lessons_in, our_book

BOOK = our_book()

FRAME = 0.0625
"""Duration of a frame, exact in binary [s]."""


class Stage:
    """Tests make each frame."""

    def __init__(self) -> None:
        self.session, self._now = Session(Settings()), 100.0
        self.lessons, self.classroom = lessons_in(self.session, BOOK), Classroom(8)
        self.control = TeacherControl(self.classroom, self.session, self.lessons)
        self.presenter = self.control.presenter = Presenter(lambda: self._now)
        self.lessons.enter(0, 0)
        self.frame()

    def frame(self, count: int = 1) -> Station:
        for _ in range(count):
            self._now += FRAME
            make_frame(self.session, self._now, FRAME)
            self.control.present()
        return self.presenter.station

    def act(self, *actions: str) -> Station:
        for action in actions:
            self.control.post(action)  # type: ignore[arg-type]
            self.frame()
        return self.presenter.station

    def answer(self, *choices: int) -> None:
        for i, choice in enumerate(choices):
            self.classroom.enter(i, f"student {i}")
            assert self.classroom.answer(self.lessons.walk, f"student {i}", choice)

    def until(self, station: Station) -> None:
        """Make frames until this station: the run ends, and its measurements are computed in a thread."""
        deadline = monotonic() + 60.0
        while self.frame() is not station:
            assert monotonic() < deadline, (station, self.presenter.station)


def screen(stage: Stage, poll: Poll | None, station: Station, left: int | None = None) -> str:
    """HTML over a projector's scene. `left`: remaining time of the timer [s]."""
    return screen_html(station, stage.lessons.walk.view(), poll, left, False)
