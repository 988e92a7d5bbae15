"""The run of a notebook: an app inside the kernel, and what the kernel may ask of it."""

import secrets
from collections.abc import Callable
from concurrent.futures import Future
from time import perf_counter
from typing import Any, Final, TypeVar

from app.classroom.lecture import LectureHost
from app.hosting.serve_options import ServeOptions
from app.hosting.teacher_key import is_teacher
from app.recording.outcome import columns_of
from app.session.actions import Action
from app.session.session import Session
from app.settings import Settings
from app.start import start_app
from controllers.errors import BadSetting, DuetError
from controllers.kinematics import Array
from scenes.settings import LawSettings, changed

T = TypeVar("T")

AGAIN: Final = 0.5
"""A question that is not answered after this time is put again [s]: what waits is dropped when the tab with the controls leaves."""

PATIENCE: Final = 30.0
"""How long a question waits for its answer [s]."""


class Ask(Action, newest_by=("answer",)):
    """Answer a question of the kernel's, once."""

    question: Callable[[Session], Any]
    answer: Future[Any]


class NotebookRun:
    """One run that all cells of a notebook show. All methods may be called from the kernel's thread at any time.

    It is the stage of a lecture: the key that its cells bring makes them the teacher's, and lets no other page operate it.

    Args:
        settings: with which it begins.

    Attributes:
        key: of its pages.
    """

    def __init__(self, settings: Settings) -> None:
        self.key = secrets.token_urlsafe(32)
        self._app = start_app(ServeOptions(settings=settings, sessions=1, watchers=1, lecture=True, key=self.key))
        # The kernel does not know under which address a hub is opened, but no page of others has the key.
        self._app.server.trusts = lambda query: is_teacher(self.key, query)
        assert isinstance(self._app.host, LectureHost)
        self._session = self._app.host.session
        self._session.takers["notebook"] = self._take
        self._closed = False

    @property
    def port(self) -> int:
        """Where the server listens, at 127.0.0.1."""
        return self._app.server.get_port()

    @property
    def server_run(self) -> str:
        """The server's random word, by which a page knows that it is this one."""
        return self._app.server.run

    def __repr__(self) -> str:
        if self._closed:
            return "<Duet, closed>"
        session = self._session
        return f"<Duet at {session.simulation.time:.1f} s: {session.settings.run.scene}, {session.settings.run.law.law}>"

    @property
    def settings(self) -> Settings:
        """All settings in force: `settings.run` of the run, `settings.page` of the page."""
        return self._ask(lambda session: session.settings)

    @property
    def law(self) -> LawSettings:
        """The law in force with its parameters (SI units)."""
        return self.settings.run.law

    def history(self, seconds: float | None = None) -> dict[str, Array]:
        """Return the newest steps: column → (steps,), oldest first.

        The columns are those of `scenes.history.SCALARS` (t [s], d [m], lambda, …), then "left_q1" … [rad], "left_dq1" … [rad/s] and
        "left_qd1" … (nan where nothing is followed).

        Args:
            seconds: how much of the run [s]; None for all that is kept, the last 16 000 steps.
        """

        def read(session: Session) -> tuple[tuple[str, ...], Array]:
            simulation = session.simulation
            newest = None if seconds is None else max(round(seconds / simulation.settings.dt), 0)
            return columns_of(simulation), simulation.history.table(newest)

        names, table = self._ask(read)
        return dict(zip(names, table.T, strict=True))

    def change(self, **settings: object) -> None:
        """Change settings from the next step on; keys and values as in a link.

        Raises:
            BadSetting: one is not possible; nothing is changed.
        """

        def apply(session: Session) -> None:
            wanted = session.settings
            for key, value in settings.items():
                wanted = changed(wanted, key, value)
            for key, value in settings.items():
                session.change(key, value)

        self._ask(apply)

    def advance(self, seconds: float) -> None:
        """Simulate so much of the run [s] as fast as the machine can, while the page shows it; a pause or a reset on the page ends it.

        Raises:
            BadSetting: the time is not above 0.
        """
        if not seconds > 0.0:
            raise BadSetting(f"seconds = {seconds} is out of range; valid: above 0")

        def hurry(session: Session) -> tuple[float, float]:
            begin = session.simulation.time
            session.hurry(begin + seconds)
            return begin, begin + seconds

        begin, end = self._ask(hurry)

        def is_over(session: Session) -> bool:
            time, dt = session.simulation.time, session.settings.run.dt
            return session.paused or not begin <= time < end - dt / 2.0

        while not self._ask(is_over):
            pass

    def close(self) -> None:
        """End the run, its pages and its server. May be called twice."""
        if not self._closed:
            self._closed = True
            self._app.close()

    def _take(self, action: Action) -> bool:
        if isinstance(action, Ask) and not action.answer.done():
            try:
                action.answer.set_result(action.question(self._session))
            except Exception as error:
                action.answer.set_exception(error)
        return isinstance(action, Ask)

    def _ask(self, question: Callable[[Session], T]) -> T:
        """Return the answer to a question that is put between two frames, on the session's own thread.

        Raises:
            DuetError: the run is closed, or does not answer.
        """
        if self._closed:
            raise DuetError("This Duet is closed; duet.show() opens a new one.")
        answer: Future[T] = Future()
        until = perf_counter() + PATIENCE
        while perf_counter() < until:
            self._session.post(Ask(question, answer))
            try:
                return answer.result(AGAIN)
            except TimeoutError:
                if answer.done():
                    raise
        raise DuetError("The run does not answer; duet.close() ends it, and duet.show() opens a new one.")
