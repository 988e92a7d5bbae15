"""The exports, the loaded files and the replay of one visitor's session, independent of the page.

A request submits a job to the pool. `advance`, called once a frame, collects finished jobs; the page then takes files, messages and
the snippet.
"""

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final, Literal, NamedTuple, get_args

from app.export.csv_table import csv_bytes, csv_suffix
from app.export.jobs import file_name, not_again, picture, player
from app.export.lab_report import Done, lab_bytes
from app.export.python_snippet import Snippet, as_python
from app.i18n.speaking import N_, spoken
from app.recording.past import Past
from app.recording.replay import RecordedFilm, Replay, film
from app.recording.run_file import SUFFIX, Loaded, Verdict, load_run, saved_bytes
from app.runtime.job_pool import Job, JobPool
from app.session.actions import Action, Pause, Reset, SingleStep
from app.session.session import Session
from controllers.errors import LazyText
from controllers.kinematics import Array
from scenes.inputs import KEEP, Recorded
from scenes.settings import RunSettings

Kind = Literal["run", "csv", "png", "svg", "html", "python"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)

WORDS: Final[dict[str, str]] = {
    "run": N_("the file of the run"),
    "csv": N_("the table"),
    "png": N_("the picture"),
    "svg": N_("the picture"),
    "html": N_("the page that plays it"),
    "python": N_("the lines of Python"),
    "film": N_("the replay"),
    "load": N_("the run of the file"),
    "report": N_("the lab report"),
}
"""Kind of a job → its name on the page."""

DRAFT: Final = 20.0
"""The newest part of a long replay, which is there first [s]."""

TITLES: Final[dict[Verdict, str]] = {
    "exact": N_("Loaded: the same run"),
    "close": N_("Loaded: the same run, but for the last digits"),
    "differs": N_("Loaded, but it is not the same run"),
}


class File(NamedTuple):
    """A finished export."""

    name: str
    content: bytes


class News(NamedTuple):
    """A message to the visitor, in English, for `tr`."""

    title: str
    text: str


class ExportQueue:
    """All methods belong to the thread that advances the session.

    Args:
        session: the live session.
        background: runs the jobs.

    Attributes:
        replay: the player; None while live.
        loaded: name of the file that is replayed, "" for the session's own run.
    """

    def __init__(self, session: Session, background: JobPool) -> None:
        self._session, self._background = session, background
        self.replay: Replay | None = None
        self.loaded = ""
        self._jobs: dict[Job, Callable[[Any], None]] = {}
        self._whole: Recorded | None = None
        self._run: RunSettings | None = None
        self._seek: float | None = None
        self._files: list[File] = []
        self._news: list[News] = []
        self._snippet: str | None = None

    # --- files -----------------------------------------------------------------------------------------------------------------

    def ask(self, kind: Kind, seconds: float) -> None:
        """Submit an export of the last `seconds` [s] of the run that is shown, live or replayed."""
        recorded = self._shown(seconds)
        if recorded is None:
            self._news.append(News(N_("There is nothing to export yet"), N_("Let it run for a moment.")))
            return
        language = spoken().language
        page, name = self._session.settings.page, file_name(recorded, KEEP if kind == "run" else seconds)
        table: Array | None = None
        if self._custom_law is not None:
            if kind in ("run", "html", "python"):
                self._news.append(News(N_("This export is not available for this run"), not_again(self._custom_law)))
                return
            table = self._session.simulation.history.table(recorded.steps)
        match kind:
            case "run":
                live = self._session.simulation.history
                last = live.table(1).tobytes() if self.replay is None else None
                self._submit(kind, self._file(name + SUFFIX), saved_bytes, recorded, last)
            case "csv":
                self._submit(kind, lambda data: self._file(name + csv_suffix(data))(data), csv_bytes, recorded, seconds, table)
            case "html":
                self._submit(kind, self._file(name + ".html"), player, language, recorded, seconds, page)
            case "python":
                whole = self._shown(KEEP) or recorded
                self._submit(kind, lambda snippet: self._take_python(snippet, name), as_python, whole, recorded, seconds, name)
            case _:
                arguments = language, recorded, seconds, page.details, kind, table
                self._submit(kind, self._file(f"{name}.{kind}"), picture, *arguments)

    @property
    def _custom_law(self) -> str | None:
        return self._session.student_law.file if self.replay is None else None

    def ask_report(self, done: Sequence[Done]) -> None:
        """Submit a lab report on steps of lessons."""
        if not done:
            self._news.append(News(N_("There is nothing to report yet"), N_("Answer a question of a lesson first.")))
            return
        lessons = sorted({one.lesson.number for one in done})
        name = "duet-lab-report" + (f"-lesson-{lessons[0]}" if len(lessons) == 1 else "")
        # The job is pickled later, when the student may have gone on.
        given = [replace(one, progress=copy.deepcopy(one.progress)) for one in done]
        self._submit("report", self._file(name + ".html"), lab_bytes, given, spoken().language)

    def load(self, data: bytes, name: str) -> None:
        """Submit a file: its run is computed again, compared with the stored outcome and replayed."""
        self._submit("load", lambda loaded: self._take(loaded, name), load_run, data, name)

    def _shown(self, seconds: float) -> Recorded | None:
        if self.replay is not None:
            return self.replay.recorded
        # After a reset the log still has the run before, until the first step.
        return self._session.recorded(seconds) if self._session.simulation.history.count else None

    def _file(self, name: str) -> Callable[[bytes], None]:
        return lambda data: self._files.append(File(name, data))

    def _take_python(self, snippet: Snippet, name: str) -> None:
        self._snippet = snippet.text
        if snippet.inputs is not None:
            self._files.append(File(name + SUFFIX, snippet.inputs))

    def _take(self, loaded: Loaded, name: str) -> None:
        self._news.append(
            News(TITLES[loaded.verification.verdict], LazyText("{name}: {what}", name=name, what=loaded.verification.words))
        )
        self._watch(loaded.recorded, None, name)

    # --- replay ----------------------------------------------------------------------------------------------------------------

    def watch(self, seconds: float) -> None:
        """Replay the last `seconds` [s] of the live run, which pauses meanwhile."""
        if self._custom_law is not None:
            self._news.append(News(N_("This run cannot be replayed"), not_again(self._custom_law)))
            return
        self.leave()
        whole, draft = self._shown(seconds), self._shown(min(seconds, DRAFT))
        if whole is None or draft is None:
            self._news.append(News(N_("There is nothing to replay yet"), N_("Let it run for a moment.")))
            return
        self._watch(draft, whole if whole.steps > draft.steps else None, "")

    def _watch(self, recorded: Recorded, whole: Recorded | None, name: str) -> None:
        self.loaded, self._whole = name, whole
        if self._run is None:
            self._session.halt.set("replay")
        self._run = self._session.settings.run
        # Urgent jobs go first.
        self._submit("film", self._show, film, recorded, urgent=recorded.seconds <= 2.0 * DRAFT)

    def _show(self, kept: RecordedFilm) -> None:
        self.replay = Replay(kept.recorded, kept)
        self.replay.toggle()
        whole, self._whole = self._whole, None
        if whole is not None:
            self._submit("film", self._lengthen, film, whole)

    def _lengthen(self, kept: RecordedFilm) -> None:
        before, self.replay = self.replay, Replay(kept.recorded, kept)
        if before is not None:
            self.replay.seek(before.time)
            self.replay.playing = before.playing

    def leave(self) -> None:
        """Go back to live: a run that went on before goes on."""
        self._drop("film")
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
    def watching(self) -> bool:
        """Whether a replay is shown or being prepared, so that the live run pauses."""
        return self._run is not None

    @property
    def past(self) -> Past | None:
        """What the page draws in place of the session; None while live."""
        return None if self.replay is None else Past(self.replay, self._session.settings, self._session.trade_off, self.loaded)

    # --- every frame -----------------------------------------------------------------------------------------------------------

    def advance(self, elapsed: float) -> bool:
        """Collect finished jobs and play `elapsed` seconds [s] on; return whether the replay has moved."""
        for job, done in list(self._jobs.items()):
            if job.state in ("waiting", "running"):
                continue
            self._jobs.pop(job, None)
            if job.state == "done":
                done(job.result)
            elif job.state == "failed":
                self._fail(job)
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

    def _fail(self, job: Job) -> None:
        if job.kind == "film":
            self.leave()
        title = N_("This file was not loaded") if job.kind == "load" else N_("The export failed")
        self._news.append(News(title, job.message))

    @property
    def busy(self) -> str:
        """Name of the oldest job under way, "" for none."""
        return next((WORDS[job.kind] for job in self._jobs), "")

    def take_files(self) -> list[File]:
        """Return the finished files, each once."""
        files, self._files = self._files, []
        return files

    def take_news(self) -> list[News]:
        """Return the messages to the visitor, each once."""
        news, self._news = self._news, []
        return news

    def take_snippet(self) -> str | None:
        """Return the finished Python snippet, once."""
        snippet, self._snippet = self._snippet, None
        return snippet

    def close(self) -> None:
        """Cancel all jobs."""
        self._background.cancel(self)
        self._jobs.clear()

    def _submit(
        self, kind: str, done: Callable[[Any], None], function: Callable[..., Any], *arguments: Any, urgent: bool = False
    ) -> None:
        self._drop(kind)
        # An empty post wakes the session.
        wake: Callable[[], None] = lambda: self._session.post(lambda: None, "news")  # noqa: E731
        self._jobs[self._background.submit(self, kind, function, *arguments, urgent=urgent, wake=wake)] = done

    def _drop(self, kind: str) -> None:
        self._background.cancel(self, kind)
        for job in [job for job in self._jobs if job.kind == kind]:
            del self._jobs[job]
