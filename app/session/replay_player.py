"""Replay of the live run or of a file, in a session."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple, Protocol

from app.i18n.speaking import N_
from app.runtime.job_pool import Job, Jobs, JobWatch
from app.session.actions import Pause, Reset, SingleStep
from app.session.clock import Pace
from app.session.ghost_run import GhostRun
from app.session.late_law import LateLawStatus
from app.session.replay import RecordedFilm, Replay, make_films
from app.session.run_control import RunControl
from app.settings import Settings
from app.text.first_task_texts import least_name
from controllers.errors import LazyText
from scenes.inputs import InputsLog, Recorded
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import Target

DRAFT: Final = 20.0
"""Newest part of a long replay, which is computed first [s]."""

REVIEWED: Final = DRAFT + 2.0
"""Shortest reviewed part of a paused run [s]: at least the plots' length."""


class Mark(NamedTuple):
    """Notable moment of a run. `time`: on the run's clock [s]; `name`: for `tr`."""

    time: float
    name: LazyText


class ReplayStatus(NamedTuple):
    """State of the replay.

    Attributes:
        time: replayed moment on the run's clock [s]; None while live.
        file: name of the replayed file; "" for the session's own run.
        reviewed: True for a moment of the paused live run.
        coming: name of the loading run, or "".
    """

    time: float | None = None
    file: str = ""
    reviewed: bool = False
    mark: Mark | None = None
    coming: str = ""


class Live(Protocol):
    settings: Settings
    simulation: Simulation
    control: RunControl
    inputs: InputsLog
    ghost_run: GhostRun

    def notify(self, title: str, text: str) -> None: ...


class Past:
    """A replay in place of a session. `beside`: replay of the ghost; for the rest see `ReplayStatus`."""

    # Of a live session, see `app.session.shown.Shown`.
    held, parts, ghost_hidden = None, None, False

    def __init__(
        self,
        replay: Replay,
        settings: Settings,
        file: str = "",
        beside: Replay | None = None,
        reviewed: bool = False,
        mark: Mark | None = None,
    ) -> None:
        self._replay, self._settings = replay, settings
        self._file, self._reviewed, self._mark = file, reviewed, mark
        self.ghost = None if beside is None else beside.simulation
        law = replay.recorded.law
        self.law_status = LateLawStatus() if law is None else LateLawStatus(law.file, sha256=law.sha256)

    @property
    def simulation(self) -> Simulation:
        return self._replay.simulation

    @property
    def settings(self) -> Settings:
        """The run's settings of that moment, with the page's present ones."""
        page = self._settings.page if self._reviewed else replace(self._settings.page, ghost="off")
        return replace(self._settings, run=self._replay.simulation.settings, page=page)

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        return self._replay.traced, None

    @property
    def pace(self) -> Pace:
        return Pace(not self._replay.playing, self._replay.speed, False)

    @property
    def replay(self) -> ReplayStatus:
        return ReplayStatus(self._replay.time, self._file, self._reviewed, self._mark)

    def target(self) -> Target | None:
        return self._replay.target


class ReplayPlayer:
    """Replays of one session. All methods belong to the thread that advances the session.

    Args:
        background: None: no replay.
        wake: called from any thread when the state of a job changes.

    Attributes:
        replay: None while live.
        loaded: name of the replayed file; "" for the session's own run.
        reviewing: True while a moment of the paused live run is shown.
    """

    def __init__(self, session: Live, background: Jobs | None, wake: Callable[[], None]) -> None:
        self._session = session
        self.jobs = JobWatch(background, wake, self._fail)
        self.replay: Replay | None = None
        self.loaded = ""
        self.reviewing = False
        self.mark: Mark | None = None
        self._ghost: Replay | None = None
        self._run: RunSettings | None = None
        self._seek: float | None = None

    @property
    def coming(self) -> str:
        return self.loaded if self.replay is None else ""

    def recorded(self, seconds: float) -> Recorded | None:
        """Newest `seconds` of the shown run; None if nothing was recorded."""
        if self.replay is not None and not self.reviewing:
            return self.replay.recorded
        # After a reset the log still has the run before, until the first step.
        return self._session.inputs.window(seconds) if self._session.simulation.history.count else None

    def watch(self, seconds: float) -> None:
        """Replay the last `seconds` of the live run, which pauses."""
        self.leave()
        whole, draft = self.recorded(seconds), self.recorded(min(seconds, DRAFT))
        if whole is None or draft is None:
            self._session.notify("There is nothing to replay yet", "Run it for a moment.")
            return
        self._watch(draft, whole=whole if whole.steps > draft.steps else None)

    def watch_file(self, recorded: Recorded, name: str) -> None:
        self.leave()
        self._watch(recorded, name)

    def review(self, time: float, mark: Mark | None = None) -> None:
        """Show a moment of the paused live run, or of the replay; ignored while the run moves.

        Args:
            time: on the run's clock [s].
            mark: None for the smallest distance.
        """
        if self.replay is not None or self._run is not None:
            self.seek(time)
            return
        reach = max(REVIEWED, self._session.simulation.time - time + 2.0)
        if (
            self.jobs.computes
            and self._session.control.halt
            and (recorded := self.recorded(reach)) is not None
        ):
            self.reviewing, self.mark, self._seek = True, mark, time
            self._watch(recorded, beside=self._session.ghost_run.recorded(reach))

    def _watch(
        self,
        recorded: Recorded,
        name: str = "",
        beside: Recorded | None = None,
        whole: Recorded | None = None,
    ) -> None:
        if not self.jobs.computes:
            return
        self.loaded, self._run = name, self._session.settings.run
        self._session.control.halt.set("replay")
        urgent = self.reviewing or recorded.seconds <= 2.0 * DRAFT
        self.jobs.submit("film", partial(self._show, whole), make_films, recorded, beside, urgent=urgent)

    def _show(self, whole: Recorded | None, films: tuple[RecordedFilm, RecordedFilm | None]) -> None:
        (own, beside), draft = films, self.replay
        self.replay = replay = Replay(own)
        self._ghost = None if beside is None else Replay(beside)
        if draft is not None:
            replay.seek(draft.time)
            replay.playing = draft.playing
        elif not self.reviewing:
            replay.toggle()
        if (draft is not None or self.mark is None) and (time := replay.nearest_moment) is not None:
            self.mark = Mark(time, LazyText(least_name(replay.simulation.settings.quantity)))
        if whole is not None:
            self.jobs.submit("film", partial(self._show, None), make_films, whole, None)

    def leave(self) -> None:
        self.jobs.drop("film")
        self.replay, self.loaded, self._seek = None, "", None
        self.reviewing, self.mark, self._ghost, self._run = False, None, None, None
        self._session.control.halt.set("replay", False)

    def seek(self, time: float) -> None:
        """Pause the replay at a time [s] from the next frame on."""
        self._seek = time

    def toggle(self) -> None:
        if self.replay is not None:
            self.replay.toggle()

    def pause(self, action: Pause) -> bool:
        """False if the action is for the live run."""
        del action
        if self.reviewing:
            # The run continues from its present state.
            self.leave()
        self.toggle()
        return self._in_place_of_live

    def single_step(self, action: SingleStep) -> bool:
        """False if the action is for the live run."""
        del action
        if self.replay is not None:
            self.replay.playing = False
            self.replay.seek_step(self.replay.step + 1)
        return self._in_place_of_live

    def reset(self, action: Reset) -> bool:
        del action
        done = self._in_place_of_live and not self.reviewing
        if done or self.reviewing:
            self.leave()
        return done

    @property
    def _in_place_of_live(self) -> bool:
        """True while a replay is shown or loading."""
        return self.replay is not None or bool(self.coming)

    def _fail(self, job: Job) -> None:
        if job.kind == "film":
            self.leave()
        title = N_("This file was not loaded") if job.kind == "load" else N_("The export failed")
        self._session.notify(title, job.message)

    @property
    def past(self) -> Past | None:
        """Replay to draw; None while live."""
        if self.replay is None:
            return None
        return Past(self.replay, self._session.settings, self.loaded, self._ghost, self.reviewing, self.mark)

    def advance(self, elapsed: float) -> None:
        """Collect finished jobs, and play `elapsed` seconds of wall time."""
        self.jobs.collect()
        if self._run is not None and (
            "replay" not in self._session.control.halt or self._session.settings.run is not self._run
        ):
            # After a change of the experiment the visitor wants to see the live run.
            self.leave()
        if self.replay is None:
            return
        if self._seek is not None:
            self.replay.playing = False
            self.replay.seek(self._seek)
            self._seek = None
        self.replay.speed = self._session.settings.page.speed
        self.replay.advance(elapsed)
        if self._ghost is not None:
            self._ghost.seek(self.replay.time)
