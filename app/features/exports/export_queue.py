"""Exports and loaded files of one session, as jobs."""

from collections.abc import Callable
from typing import Any, Final, Literal, NamedTuple

from app.features.exports.csv_table import csv_bytes, csv_suffix
from app.features.exports.player import player_html
from app.features.exports.python_snippet import Snippet, as_python
from app.i18n.speaking import N_, set_language, spoken
from app.recording.run_file import SUFFIX, Agreement, Loaded, load_run, saved_bytes
from app.session.replay_player import ReplayPlayer
from app.session.session import Session
from app.settings import Language
from controllers.errors import LazyText
from scenes.inputs import KEEP, Recorded
from scenes.rerun import not_again

FileKind = Literal["run", "csv", "png", "svg", "html", "python"]

WORDS: Final[dict[str, str]] = {
    "run": N_("the file of the run"),
    "csv": N_("the table"),
    "png": N_("the picture"),
    "svg": N_("the picture"),
    "html": N_("the page that plays it"),
    "python": N_("the lines of Python"),
    "film": N_("the replay"),
    "load": N_("the run of the file"),
}

TITLES: Final[dict[Agreement, str]] = {
    "exact": N_("Loaded: the same run"),
    "close": N_("Loaded: the same run, except for the last digits"),
    "differs": N_("Loaded, but it is not the same run"),
}


class File(NamedTuple):
    name: str
    content: bytes


class ExportQueue:
    """Belongs to the thread that advances the session. `player` collects finished jobs."""

    def __init__(self, session: Session, player: ReplayPlayer) -> None:
        self.session, self.player, self._jobs = session, player, player.jobs
        self._files: list[File] = []
        self._snippet: str | None = None

    def ask(self, kind: FileKind, seconds: float) -> None:
        """Export the last `seconds` [s] of the shown run."""
        recorded = self.player.recorded(seconds)
        if recorded is None:
            self.session.notify("There is nothing to export yet", "Run it for a moment.")
            return
        language = spoken().language
        page, name = self.session.settings.page, file_name(recorded, KEEP if kind == "run" else seconds)
        if recorded.law is not None and kind == "python":
            self.session.notify("This export is not available for this run", not_again(recorded.law.file))
            return
        match kind:
            case "run":
                live = self.session.simulation.history
                last = live.table(1).tobytes() if self.player.replay is None else None
                self._jobs.submit(kind, self._file(name + SUFFIX), saved_bytes, recorded, last)
            case "csv":
                self._jobs.submit(
                    kind, lambda data: self._file(name + csv_suffix(data))(data), csv_bytes, recorded, seconds
                )
            case "html":
                self._jobs.submit(
                    kind, self._file(name + ".html"), make_player, language, recorded, seconds, page
                )
            case "python":
                whole = self.player.recorded(KEEP) or recorded
                self._jobs.submit(
                    kind,
                    lambda snippet: self._take_python(snippet, name),
                    as_python,
                    whole,
                    recorded,
                    seconds,
                    name,
                )
            case _:
                self._jobs.submit(
                    kind,
                    self._file(f"{name}.{kind}"),
                    make_picture,
                    language,
                    recorded,
                    seconds,
                    page.details,
                    kind,
                )

    def make(self, what: str, name: str, compute: Callable[..., bytes], *arguments: Any) -> None:
        """Submit another feature's file. `what`: English name for `tr`; `compute`: top-level function for
        another process.
        """
        self._jobs.submit(what, self._file(name), compute, *arguments)

    def load(self, data: bytes, name: str) -> None:
        """Compute a file's run again, compare the outcome, and replay it."""
        self._jobs.submit("load", lambda loaded: self._take(loaded, name), load_run, data, name)

    def _file(self, name: str) -> Callable[[bytes], None]:
        return lambda data: self._files.append(File(name, data))

    def _take_python(self, snippet: Snippet, name: str) -> None:
        self._snippet = snippet.text
        if snippet.inputs is not None:
            self._files.append(File(name + SUFFIX, snippet.inputs))

    def _take(self, loaded: Loaded, name: str) -> None:
        self.session.notify(TITLES[loaded.verdict], LazyText("{name}: {what}", name=name, what=loaded.words))
        self.player.watch_file(loaded.recorded, name)

    @property
    def busy(self) -> str:
        """Name of the oldest unfinished job, or ""."""
        return next((WORDS.get(kind, kind) for kind in self._jobs.kinds), "")

    def take_files(self) -> list[File]:
        files, self._files = self._files, []
        return files

    def take_snippet(self) -> str | None:
        snippet, self._snippet = self._snippet, None
        return snippet

    def close(self) -> None:
        self._jobs.close()


# ---- jobs, each in the language of who asked, and the names of their files -----------------------------------------------------


def make_picture(language: Language, *arguments: Any) -> bytes:
    """Only the worker imports matplotlib."""
    from app.features.exports.plot_pictures import picture_bytes

    set_language(language)
    return picture_bytes(*arguments)


def make_player(language: Language, *arguments: Any) -> bytes:
    set_language(language)
    return player_html(*arguments)


def file_name(recorded: Recorded, seconds: float) -> str:
    """Scene and times, without ending."""
    end = recorded.begin + recorded.seconds
    begin = max(recorded.begin, end - seconds)
    return f"duet-{recorded.settings.scene}-{begin:.0f}-{end:.0f}s"
