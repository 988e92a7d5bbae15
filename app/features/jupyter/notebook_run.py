"""The run of a notebook: an app inside the kernel."""

import hashlib
import math
import secrets
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from app.features import FEATURES
from app.features.custom_law.student_law import let_custom_law_run, take_law_file
from app.features.lecture.lecture import LectureHost
from app.features.lecture.lecture_options import LectureOptions
from app.features.lessons.bookmark import Bookmark
from app.hosting.serve_options import ServeOptions
from app.hosting.teacher_key import is_teacher
from app.recording.outcome import history_columns
from app.runtime.temporary_folder import TemporaryFolder, remove_abandoned
from app.session.actions import Action
from app.session.session import Session
from app.settings import Settings
from app.start import start_app
from controllers.errors import BadSetting, DuetError
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from controllers.system_libraries import naming_missing_library
from scenes.headless import check_length
from scenes.history import unit_of
from scenes.law_answers import LawOfFile
from scenes.laws import DEFAULT_LAW
from scenes.person.source import MissingPackage
from scenes.settings import LawSettings, changed, leaves, values

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")

AGAIN: Final = 0.5
"""Time after which an unanswered question is repeated [s]: a leaving operator loses it."""

PATIENCE: Final = 30.0
"""Longest wait for an answer [s]."""


class Ask(Action, newest_by=("answer",)):
    """Answer a question of the kernel, once."""

    question: Callable[[Session], Any]
    answer: Future[Any]


def all_changed(settings: Settings, wanted: Mapping[str, object]) -> Settings:
    """Settings with changes by link key or long name.

    Raises:
        BadSetting: one is not possible.
    """
    for name, value in wanted.items():
        settings = changed(settings, key_of(name), value)
    return settings


def step_with(session: Session, law: Law) -> bool:
    """Pause, and make one step with a law that answers at once; false if the ghost's law has not answered."""
    if not session.control.halt:
        session.control.halt.set("visitor")
    session.simulation.use(law)
    try:
        return session.step_both()
    finally:
        session.simulation.use(session.law.of_run)


def key_of(name: str) -> str:
    """Link key: `dm` for critical_distance; unknown names are unchanged."""
    known = leaves(Settings)
    return name if name in known else {path[-1]: key for key, (path, _) in known.items()}.get(name, name)


def _number(value: Any, name: str = "seconds") -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise BadSetting(f"{name} = {value!r} is no finite number.")
    return number


def _law(session: Session) -> LawSettings:
    law = session.settings.run.law
    return law if session.law.of_run is None else replace(law, law="my own law")


class GivenVelocities(LawOfFile):
    """Law with the joint velocities of a cell. `velocities`: (n,) [rad/s]."""

    file, sha256 = "notebook", hashlib.sha256(b"notebook").hexdigest()

    def __init__(self, velocities: Array) -> None:
        self.velocities = velocities

    def __call__(self, situation: Situation) -> Array:
        del situation
        return self.velocities.copy()

    def activation(self, distance: float) -> float:
        del distance
        return 0.0


class NotebookRun:
    """One run that all cells of a notebook show; for the kernel's thread.

    It is a shared session that only pages with its key, the cells, can operate.

    Attributes:
        port: of the server, at 127.0.0.1.
        server_run: random word by which a page recognises the server.
        closed: it has ended for good.
    """

    def __init__(self, settings: Settings) -> None:
        self.key = secrets.token_urlsafe(32)
        self._app = start_app(
            ServeOptions(
                settings=settings,
                sessions=1,
                key=self.key,
                features=(LectureOptions(watchers=1, lecture=True),),
            ),
            features=FEATURES,
        )
        # The kernel does not know the hub's public address, but no foreign page has the key.
        self._app.server.trusts = lambda query: is_teacher(self.key, query)
        self.port, self.server_run, self.closed = self._app.server.get_port(), self._app.server.run, False
        assert isinstance(self._app.host, LectureHost)
        self._session, self._lessons = self._app.host.session, self._app.host.lessons
        self._session.handlers.add(Ask, self._answer)
        self._given = GivenVelocities(np.zeros(0))
        remove_abandoned()
        self._folder = TemporaryFolder("notebook")

    def __repr__(self) -> str:
        if self.closed:
            return "<Duet, closed>"
        session = self._session
        return f"<Duet at {session.simulation.time:.1f} s: {session.settings.run.scene}, {_law(session).law}>"

    @property
    def settings(self) -> Settings:
        """`settings.run` of the run, `settings.page` of the page."""
        return self._ask(lambda session: session.settings)

    @property
    def law(self) -> LawSettings:
        """Law and its parameters (SI units); "my own law" while a function of the notebook drives the arm."""
        return self._ask(_law)

    def history(self, seconds: float | None = None) -> dict[str, Array]:
        """Newest steps: column → (steps,), oldest first.

        The columns are `scenes.history.SCALARS` (t [s], d [m], lambda, …), then "left_q1" … [rad], "left_dq1"
        … [rad/s] and "left_qd1" … (nan where nothing is followed).

        Args:
            seconds: length [s]; None for all kept steps, the last 16 000.

        Raises:
            BadSetting: the time is not above 0.
        """
        if seconds is not None and (seconds := _number(seconds)) <= 0.0:
            raise BadSetting(
                f"seconds = {seconds:g} is out of range; give a number above 0, or None for all that is kept."
            )

        def read(session: Session) -> tuple[tuple[str, ...], Array]:
            simulation = session.simulation
            newest = None if seconds is None else max(round(seconds / simulation.settings.dt), 1)
            return history_columns(simulation), simulation.history.table(newest)

        names, table = self._ask(read)
        return dict(zip(names, table.T, strict=True))

    def __getitem__(self, name: str) -> Any:
        """Setting by link key or long name: `run["dm"]` is `run["critical_distance"]` [m].

        Raises:
            BadSetting: no such setting.
        """
        known = values(self.settings) | {"law": self.law.law}
        if key_of(name) not in known:
            raise BadSetting(f"There is no setting {name!r}; choose from {', '.join(known)}.")
        return known[key_of(name)]

    def table(self, seconds: float | None = None) -> "pandas.DataFrame":
        """`history` as a pandas table with units in the heads: "t [s]", "d [m]", ….

        Raises:
            MissingPackage: pandas is not installed.
        """
        try:
            with naming_missing_library():
                import pandas
        except ImportError:
            raise MissingPackage("A table needs pandas: pip install 'lwr-duet[notebook]'.") from None
        error_unit, history = self.settings.run.experiment.error_unit, self.history(seconds)
        heads = [f"{name} [{unit}]" if (unit := unit_of(name, error_unit)) else name for name in history]
        return pandas.DataFrame(dict(zip(heads, history.values(), strict=True)))

    def open_lesson(self, lesson: int | str, step: int = 1) -> None:
        """Open a step on the page. `lesson`: number or name; `step`: from 1.

        Raises:
            BadSetting: unknown lesson or step.
        """
        name = self.find_lesson(lesson, step)
        self._ask(lambda _session: self._lessons.enter(name, step - 1))

    def find_lesson(self, lesson: int | str, step: int = 1) -> str:
        """Name of a lesson; arguments and errors as in `open_lesson`."""
        book = self._lessons.book
        return Bookmark(book).at(book.index(lesson), round(_number(step, "step")) - 1).lesson.id

    def take_law(self, text: str | None) -> None:
        """Restart with a law file's text, and the paper's law as the ghost; None for the settings' law."""
        if text is None:
            self._ask(lambda session: let_custom_law_run(session, False))
            return
        path = self._folder.path / "law.py"
        path.write_text(text, encoding="utf-8")

        def begin(session: Session) -> None:
            session.change("ghost", DEFAULT_LAW)
            take_law_file(session, path)
            let_custom_law_run(session, True)

        self._ask(begin)

    def step(self, dq: ArrayLike) -> dict[str, float]:
        """Pause, make one step with these joint velocities, and return it as in `history`.

        Joint bounds hold. If both arms avoid, both get these velocities.

        Args:
            dq: q̇ (n,) of an avoiding arm [rad/s].

        Raises:
            BadSetting: not n finite numbers; no step is made.
            DuetError: the ghost's custom law does not answer.
        """
        try:
            given = np.asarray(dq, float)
        except (TypeError, ValueError, OverflowError):
            given = np.array(math.nan)

        def make(session: Session) -> bool:
            joints = session.simulation.avoiding.joints
            if given.shape != (joints.stop - joints.start,) or not np.isfinite(given).all():
                raise BadSetting(f"step needs {joints.stop - joints.start} finite joint velocities [rad/s].")
            self._given.velocities = given
            return step_with(session, self._given)

        until = perf_counter() + PATIENCE
        while not self._ask(make):
            if perf_counter() > until:
                raise DuetError("The ghost's law does not answer; change its file, or choose another ghost.")
        return {name: float(column[-1]) for name, column in self.history(self.settings.run.dt).items()}

    def change(self, **settings: object) -> None:
        """Change settings, by link key or long name, from the next step on.

        A `law` ends that of `duet.law`, and restarts the run.

        Raises:
            BadSetting: one is not possible; nothing is changed.
        """

        def apply(session: Session) -> None:
            all_changed(session.settings, settings)
            if session.law.of_run is not None and "law" in map(key_of, settings):
                let_custom_law_run(session, False)
            for name, value in settings.items():
                session.change(key_of(name), value)

        self._ask(apply)

    def advance(self, seconds: float) -> None:
        """Simulate this time [s] as fast as possible; a pause or a reset on the page ends it.

        Raises:
            BadSetting: the time is not above 0, or longer than `lwr-duet run` allows.
        """
        seconds = _number(seconds)
        check_length(self.settings.run, seconds)

        def hurry(session: Session) -> tuple[float, float]:
            begin = session.simulation.time
            session.control.hurry(begin + seconds)
            return begin, begin + seconds

        begin, end = self._ask(hurry)

        def is_over(session: Session) -> bool:
            time, dt = session.simulation.time, session.settings.run.dt
            return session.paused or not begin <= time < end - dt / 2.0

        while not self._ask(is_over):
            pass

    def close(self) -> None:
        """End the run, its pages and its server. May be called twice."""
        if not self.closed:
            self.closed = True
            self._app.close()
            self._folder.remove()

    def _answer(self, action: Ask) -> None:
        if not action.answer.done():
            try:
                action.answer.set_result(action.question(self._session))
            except Exception as error:
                action.answer.set_exception(error)

    def _ask(self, question: Callable[[Session], T]) -> T:
        """Ask a question between two frames on the session's thread.

        Raises:
            DuetError: the run is closed, or does not answer.
        """
        if self.closed:
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
