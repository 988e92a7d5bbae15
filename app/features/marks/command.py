"""`lwr-duet grade`."""

import lzma
import os
import sys
import threading
import zipfile
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import tyro

from app.runtime.progress import cores
from app.runtime.temporary_folder import TemporaryFolder, remove_abandoned
from app.runtime.terminal import INTERRUPTED, ending_at_once
from app.settings import LANGUAGES
from controllers.errors import BadSetting
from scenes.files import check_writable, csv_cell, writable, written

if TYPE_CHECKING:
    from app.features.marks.fence import FenceLimits
    from app.features.marks.graded_file import GradedFile


ENDINGS: Final = (".py", ".html", ".htm")

MOST_PARTS: Final = 2000
MOST_BYTES: Final = 2**29
"""Most files of a ZIP file, and their total size [bytes]."""

ISOLATION: Final = {
    "network": "only the network is closed to these files: they can read and write what you can. Use a container or a virtual machine.",
    "none": "nothing but time, memory and number of processes is limited: these files can do what you can do. Use a container or a "
    "virtual machine.",
}


@dataclass(frozen=True)
class Grade:
    """Grade the laws and lab reports in a folder or a ZIP file.

    Puts every law (*.py) through the six tests, reads every lab report (*.html), and writes a table of marks.

    A law is worth a point a test, but only for what it passes beside "keeps its distance" and "gets out"; a report one for each right
    prediction and each challenge that is passed. A report can be forged."""

    folder: tyro.conf.Positional[Path]
    """With what was handed in, and folders in it; or a ZIP file of that, such as the teacher's page saves."""
    csv: Path = Path("marks.csv")
    """The table: one row a file, with the reason for every failure."""
    points: tuple[float, ...] = ()
    """What the six tests are worth, in their order; without it a point each."""
    feedback: Path | None = None
    """Folder for a page of feedback for every student; made if there is none."""
    moodle: Path | None = None
    """Also write a grading worksheet for Moodle, one row a student."""
    canvas: Path | None = None
    """Also write a table for Canvas' gradebook, one row a student."""
    gradescope: Path | None = None
    """Also write a results.json: all files are one submission."""
    lang: Literal[tuple(LANGUAGES)] = "en"  # type: ignore[valid-type]
    """In which reasons and feedback speak."""
    jobs: int = 0
    """Files at a time; 0 takes half of the cores, so that no law is slow for another's sake."""
    seconds: float = 120.0
    """Longest time for one file [s]."""


def grade(command: Grade) -> int:
    """Returns the exit code. Ctrl+C writes only the rows so far.

    Raises:
        KeyboardInterrupt: no file is graded yet.
        BadSetting: nothing to grade, an option is not possible, or a table cannot be written.
    """
    with ending_at_once():
        from app.features.marks import mark_files
        from app.features.marks.fence import FenceLimits
        from app.features.marks.graded_file import weights_of
    if command.jobs < 0 or not 1.0 <= command.seconds <= 3600.0:
        raise BadSetting("grade needs jobs from 1, or 0 for half of the cores, and seconds from 1 to 3600.")
    for option in ("csv", *mark_files.WRITERS):
        path: Path | None = getattr(command, option)
        if path is not None:
            check_writable(path, option)
    weights = weights_of(command.points)
    remove_abandoned()
    limits = FenceLimits(seconds=command.seconds)
    with unpacked(command.folder) as folder:
        paths = handed_in(folder)
        if not paths:
            raise BadSetting(f"{command.folder}: holds no law (*.py) and no lab report (*.html).")
        if command.feedback is not None:
            with writable(command.feedback, "feedback"):
                command.feedback.mkdir(parents=True, exist_ok=True)
            check_writable(command.feedback / "feedback.html", "feedback")
        with written(command.csv, "csv") as new:
            rows = _graded(replace(command, folder=folder), paths, limits, weights)
            mark_files.write_marks(new, rows)
    if len(rows) < len(paths):
        print(
            f"lwr-duet: interrupted; {command.csv} has {len(rows)} of {len(paths)} files, and nothing else was written.",
            file=sys.stderr,
        )
        return INTERRUPTED
    students = mark_files.by_student(rows)
    for option, write in mark_files.WRITERS.items():
        if (path := getattr(command, option)) is not None:
            with written(path, option) as new:
                write(new, students)
    if command.feedback is not None:
        with writable(command.feedback, "feedback"):
            mark_files.write_feedback(command.feedback, students, command.lang)
    print(f"{command.csv}: {len(rows)} files.")
    return 0


@contextmanager
def unpacked(given: Path) -> Iterator[Path]:
    """The folder, or the content of a ZIP file while open.

    Raises:
        BadSetting: neither, or too large.
    """
    if os.path.isdir(given):
        yield given
        return
    with TemporaryFolder("grade") as folder:
        try:
            with zipfile.ZipFile(given) as archive:
                parts = [part for part in archive.infolist() if Path(part.filename).suffix.lower() in ENDINGS]
                if len(parts) > MOST_PARTS or sum(part.file_size for part in parts) > MOST_BYTES:
                    raise BadSetting(
                        f"{given}: holds more than {MOST_PARTS} files or {MOST_BYTES >> 20} MiB; grade a part of it."
                    )
                archive.extractall(folder.path, parts)
        except (
            OSError,
            EOFError,
            RuntimeError,
            ValueError,
            NotImplementedError,
            zlib.error,
            lzma.LZMAError,
            zipfile.BadZipFile,
        ):
            raise BadSetting(
                f"{given}: not a folder or a ZIP file; give the one that holds the hand-ins."
            ) from None
        yield folder.path


def handed_in(folder: Path) -> list[Path]:
    """Sorted, with subfolders; links are included, not followed."""
    found: list[Path] = []
    for where, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name != "__pycache__"]
        links = [name for name in folders if os.path.islink(os.path.join(where, name))]
        found += [Path(where, name) for name in (*files, *links) if Path(name).suffix.lower() in ENDINGS]
    return sorted(found, key=lambda path: os.fsencode(path))


def _graded(
    command: Grade, paths: list[Path], limits: "FenceLimits", weights: dict[str, float]
) -> "list[GradedFile]":
    """Rows in the order of the files; after Ctrl+C the rows so far.

    Raises:
        KeyboardInterrupt: there is no row yet.
    """
    from app.features.marks.graded_file import graded

    stopped, said = threading.Event(), set[str]()
    jobs = command.jobs or max(1, cores() // 2)
    with ThreadPoolExecutor(jobs) as pool:
        work = {
            pool.submit(graded, path, command.folder, limits, stopped, weights, command.lang): path
            for path in paths
        }
        try:
            for number, done in enumerate(as_completed(work), 1):
                row = done.result()
                print(f"{number}/{len(paths)} {csv_cell(row.name)}: {row.points:g}", file=sys.stderr)
                if row.isolation in ISOLATION and row.isolation not in said:
                    said.add(row.isolation)
                    print(f"lwr-duet: {ISOLATION[row.isolation]}", file=sys.stderr)
        except BaseException as error:
            # Unfinished files are given up, without marks.
            so_far = [done for done in work if done.done()]
            stopped.set()
            pool.shutdown(cancel_futures=True)
            if not (so_far and isinstance(error, KeyboardInterrupt)):
                raise
            return [done.result() for done in so_far]
        return [done.result() for done in work]
