"""The replay in a session: the last part of its run, or the run of a file, in the place of the live one."""

from collections.abc import Callable
from typing import Final

from app.i18n.speaking import N_
from app.recording.past import Past
from app.recording.replay import RecordedFilm, Replay, film
from app.runtime.job_watch import JobWatch
from app.session.actions import Action, Pause, Reset, SingleStep
from app.session.session import Session
from controllers.errors import LazyText
from scenes.inputs import Recorded
from scenes.settings import RunSettings

DRAFT: Final = 20.0
"""The newest part of a long replay, which is there first [s]."""


class ReplayPlayer:
    """All methods belong to the thread that advances the session.

    Args:
        jobs: compute the replay's film.
        notify: gives the visitor a message: title and text, in English, for `tr`.

    Attributes:
        replay: None while live.
        loaded: name of the file that is replayed, "" for the session's own run.
    """

    def __init__(self, session: Session, jobs: JobWatch, notify: Callable[[str, str], None]) -> None:
        self._session, self._jobs, self._notify = session, jobs, notify
        self.replay: Replay | None = None
        self.loaded = ""
        self._whole: Recorded | None = None
        self._run: RunSettings | None = None
        self._seek: float | None = None

    @property
    def custom_law(self) -> str | None:
        """Name of the file of the law of the run that is shown; None if that is the settings' law."""
        return self._session.student_law.file if self.replay is None else None

    def recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece [s] of the run that is shown, live or replayed; None if there is none."""
        if self.replay is not None:
            return self.replay.recorded
        # After a reset the log still has the run before, until the first step.
        return self._session.recorded(seconds) if self._session.simulation.history.count else None

    def watch(self, seconds: float) -> None:
        """Replay the last `seconds` [s] of the live run, which pauses meanwhile."""
        if self.custom_law is not None:
            self._notify(N_("This run cannot be replayed"), not_again(self.custom_law))
            return
        self.leave()
        whole, draft = self.recorded(seconds), self.recorded(min(seconds, DRAFT))
        if whole is None or draft is None:
            self._notify(N_("There is nothing to replay yet"), N_("Let it run for a moment."))
            return
        self._watch(draft, whole if whole.steps > draft.steps else None, "")

    def watch_file(self, recorded: Recorded, name: str) -> None:
        self._watch(recorded, None, name)

    def _watch(self, recorded: Recorded, whole: Recorded | None, name: str) -> None:
        self.loaded, self._whole = name, whole
        if self._run is None:
            self._session.halt.set("replay")
        self._run = self._session.settings.run
        # Urgent jobs go first.
        self._jobs.submit("film", self._show, film, recorded, urgent=recorded.seconds <= 2.0 * DRAFT)

    def _show(self, kept: RecordedFilm) -> None:
        self.replay = Replay(kept.recorded, kept)
        self.replay.toggle()
        whole, self._whole = self._whole, None
        if whole is not None:
            self._jobs.submit("film", self._lengthen, film, whole)

    def _lengthen(self, kept: RecordedFilm) -> None:
        before, self.replay = self.replay, Replay(kept.recorded, kept)
        if before is not None:
            self.replay.seek(before.time)
            self.replay.playing = before.playing

    def leave(self) -> None:
        """Go back to live: a run that went on before goes on."""
        self._jobs.drop("film")
        self.replay, self.loaded, self._whole, self._seek = None, "", None, None
        self._run = None
        self._session.halt.set("replay", False)

    def seek(self, time: float) -> None:
        """Pause the replay at a time [s] from the next frame on."""
        self._seek = time

    def take(self, action: Action) -> bool:
        """Apply an action to the replay; return whether it was one of the replay's."""
        replay = self.replay
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

    @property
    def past(self) -> Past | None:
        """What the page draws in place of the session; None while live."""
        session = self._session
        if self.replay is None:
            return None
        return Past(self.replay, session.settings, session.trade_off, session.safety_curves, self.loaded)

    def advance(self, elapsed: float) -> bool:
        """Collect finished jobs and play `elapsed` seconds [s] on; return whether the replay has moved."""
        self._jobs.collect()
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
        return self.replay.step != before


def not_again(law: str) -> LazyText:
    """Return why a run with a custom law cannot be computed again. `law`: name of its file."""
    return LazyText(
        "{law} runs in its own process, so this run cannot be computed again. The table and the pictures are available.", law=law
    )
