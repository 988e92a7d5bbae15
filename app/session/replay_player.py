"""The replay in a session: the last part of its run, or the run of a file, in the place of the live one."""

from collections.abc import Callable
from typing import Final

from app.i18n.speaking import N_
from app.runtime.job_pool import Job, Jobs, JobWatch
from app.session.actions import Action, Pause, Reset, SingleStep
from app.session.replay import RecordedFilm, Replay, make_film, make_films
from app.session.shown import Live, Mark, Past
from controllers.errors import LazyText
from scenes.inputs import Recorded
from scenes.settings import RunSettings

DRAFT: Final = 20.0
"""The newest part of a long replay, which is there first [s]."""

REVIEWED: Final = DRAFT + 2.0
"""How much of a run that stands can be looked back at [s]: at least as much as the plots over time show; further if an earlier moment is
asked for."""


class ReplayPlayer:
    """All methods belong to the thread that advances the session.

    Args:
        background: computes the replay's film.
        wake: called, from any thread, when the state of a job has changed.

    Attributes:
        jobs: the film, and the exports of what is shown.
        news: messages to the visitor: title and text, in English, for `tr`.
        replay: None while live.
        loaded: name of the file that is replayed, "" for the session's own run.
        reviewing: whether it shows a moment of the live run, which stands, see `review`.
        mark: the moment of the replay that is worth a look; None if there is none.
    """

    def __init__(self, session: Live, background: Jobs, wake: Callable[[], None]) -> None:
        self._session = session
        self.jobs = JobWatch(background, wake, self._fail)
        self.news: list[tuple[str, str]] = []
        self.replay: Replay | None = None
        self.loaded = ""
        self.reviewing = False
        self.mark: Mark | None = None
        self._ghost: Replay | None = None
        self._whole: Recorded | None = None
        self._run: RunSettings | None = None
        self._seek: float | None = None

    def recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece [s] of the run that is shown, live or replayed; None if there is none."""
        if self.replay is not None and not self.reviewing:
            return self.replay.recorded
        # After a reset the log still has the run before, until the first step.
        return self._session.recorded(seconds) if self._session.simulation.history.count else None

    def watch(self, seconds: float) -> None:
        """Replay the last `seconds` [s] of the live run, which pauses meanwhile."""
        self.leave()
        whole, draft = self.recorded(seconds), self.recorded(min(seconds, DRAFT))
        if whole is None or draft is None:
            self.news.append((N_("There is nothing to replay yet"), N_("Let it run for a moment.")))
            return
        self._watch(draft, whole if whole.steps > draft.steps else None, "")

    def watch_file(self, recorded: Recorded, name: str) -> None:
        self.leave()
        self._watch(recorded, None, name)

    def review(self, time: float, mark: Mark | None = None) -> None:
        """Show a moment of the live run while it stands: the scene as it was then, plots over time of the whole run.

        In a replay it is the moment of the replay. Nothing happens while the run goes on.

        Args:
            time: on the clock of the run [s].
            mark: the moment of it that is worth a look; None for that of the smallest distance.
        """
        if self.replay is not None or self._run is not None:
            self.seek(time)
            return
        reach = max(REVIEWED, self._session.simulation.time - time + 2.0)
        if self._session.paused and (recorded := self.recorded(reach)) is not None:
            self.reviewing, self.mark, self._seek = True, mark, time
            self._stop()
            self.jobs.submit("film", self._show_moment, make_films, recorded, self._session.ghost_recorded(reach), urgent=True)

    def _show_moment(self, films: tuple[RecordedFilm, RecordedFilm | None]) -> None:
        own, beside = films
        self._open(Replay(own.recorded, own))
        self._ghost = None if beside is None else Replay(beside.recorded, beside)

    def _stop(self) -> None:
        """Let the live run stand while it is replayed."""
        if self._run is None:
            self._session.halt.set("replay")
        self._run = self._session.settings.run

    def _open(self, replay: Replay) -> None:
        self.replay = replay
        if self.mark is None and (time := replay.nearest_moment) is not None:
            self.mark = Mark(time, LazyText(N_("smallest distance")))

    def _watch(self, recorded: Recorded, whole: Recorded | None, name: str) -> None:
        self.loaded, self._whole = name, whole
        self._stop()
        # Urgent jobs go first.
        self.jobs.submit("film", self._show, make_film, recorded, urgent=recorded.seconds <= 2.0 * DRAFT)

    def _show(self, kept: RecordedFilm) -> None:
        self._open(replay := Replay(kept.recorded, kept))
        replay.toggle()
        whole, self._whole = self._whole, None
        if whole is not None:
            self.jobs.submit("film", self._lengthen, make_film, whole)

    def _lengthen(self, kept: RecordedFilm) -> None:
        before, replay = self.replay, Replay(kept.recorded, kept)
        self.mark = None
        self._open(replay)
        if before is not None:
            replay.seek(before.time)
            replay.playing = before.playing

    def leave(self) -> None:
        """Go back to live: a run that went on before goes on."""
        self.jobs.drop("film")
        self.replay, self.loaded, self._whole, self._seek = None, "", None, None
        self.reviewing, self.mark, self._ghost, self._run = False, None, None, None
        self._session.halt.set("replay", False)

    def seek(self, time: float) -> None:
        """Pause the replay at a time [s] from the next frame on."""
        self._seek = time

    def toggle(self) -> None:
        """Play the replay, or let it rest."""
        if self.replay is not None:
            self.replay.toggle()

    def take(self, action: Action) -> bool:
        """Apply an action to the replay; return whether it was one of the replay's."""
        replay = self.replay
        if self.reviewing and isinstance(action, Pause | Reset):
            # The run goes on from where it is, or from its beginning.
            self.leave()
            return False
        if replay is None:
            return False
        match action:
            case Pause():
                replay.toggle()
            case SingleStep():
                replay.playing = False
                replay.seek_step(replay.step + 1)
            case Reset():
                self.leave()
            case _:
                return False
        return True

    def _fail(self, job: Job) -> None:
        if job.kind == "film":
            self.leave()
        title = N_("This file was not loaded") if job.kind == "load" else N_("The export failed")
        self.news.append((title, job.message))

    @property
    def past(self) -> Past | None:
        """What the page draws in place of the session; None while live."""
        if self.replay is None:
            return None
        live = self._session if self.reviewing else None
        return Past(self.replay, self._session.settings, self.loaded, self._ghost, live, self.mark)

    def advance(self, elapsed: float) -> bool:
        """Collect finished jobs and play `elapsed` seconds [s] on; return whether the replay has moved."""
        self.jobs.collect()
        if self._run is not None and ("replay" not in self._session.halt or self._session.settings.run is not self._run):
            # After a change of the experiment the visitor wants to see the live run.
            self.leave()
        if self.replay is None:
            return False
        before = self.replay.step
        if self._seek is not None:
            self.replay.playing = False
            self.replay.seek(self._seek)
            self._seek = None
        self.replay.speed = self._session.settings.page.speed
        self.replay.advance(elapsed)
        if self._ghost is not None:
            self._ghost.seek(self.replay.time)
        return self.replay.step != before
