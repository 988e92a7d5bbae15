"""`lwr-duet new-law`, `law-test` and `grade`: a law file to begin with, its test, and marks for a folder of laws and lab reports."""

import csv
import os
import sys
import tempfile
import threading
import zipfile
import zlib
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import tyro

from app.cli.sweep import cores
from app.runtime.terminal import ending_at_once
from controllers.errors import BadSetting
from scenes.files import csv_cell, read_file, readable, replacing, written

if TYPE_CHECKING:
    from app.custom_law.fence import FenceLimits
    from app.custom_law.marked import LawMarks
    from app.export.report_record import StepRecord


@dataclass(frozen=True)
class NewLaw:
    """Write a file with a law of your own: the paper's, to begin with."""

    path: tyro.conf.Positional[Path]
    """Where to, such as my_law.py."""


@dataclass(frozen=True)
class LawTest:
    """Put a law of your own through six tests, and say why it fails."""

    path: tyro.conf.Positional[Path]
    """The file, such as my_law.py."""


def new_law(command: NewLaw) -> int:
    """Write the file; return the exit code.

    Raises:
        BadSetting: the file exists, or cannot be written.
    """
    path = command.path
    template = Path(__file__).parents[1] / "custom_law" / "template.py"
    text = template.read_text(encoding="utf-8").replace("my_law.py", readable(path.name))
    if os.path.lexists(path):
        raise BadSetting(f"{path} is there already and is left alone; give another name.")
    try:
        with replacing(path) as new:
            new.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise BadSetting(f"{path}: cannot be written ({error.strerror}); give a name in a folder that exists.") from None
    print(f"{path} holds the paper's law. Next: lwr-duet law-test {path}, lwr-duet serve --law-file {path}")
    return 0


def law_test(command: LawTest) -> int:
    """Print one line for each test; return the exit code, 0 if all are passed, else 1.

    Raises:
        BadInputFile: there is no such file, or it cannot be read.
    """
    with ending_at_once():
        from app.custom_law.examination import examine, verdict_table

    verdicts = list(examine(command.path))
    print(verdict_table(command.path, verdicts))
    return 0 if all(verdict.passed for verdict in verdicts) else 1


KINDS: Final = {".py": "law", ".html": "report", ".htm": "report"}
"""Ending of a file → what it holds."""

MOST_PARTS: Final = 2000
MOST_BYTES: Final = 2**29
"""Files that are read of a ZIP file, and their size together [bytes]."""

ISOLATION: Final = {
    "network": "only the network was closed to these files: they could read and write what you can. Grade in a container or "
    "a virtual machine.",
    "none": "nothing but time, memory and number of processes was limited: the files could do what you can do. Grade in a container or "
    "a virtual machine.",
}
"""What to say where the system does not allow all of it."""


@dataclass(frozen=True)
class Grade:
    """Put every law (*.py) in a folder or a ZIP file through the six tests, read every lab report (*.html), and write a table of marks.

    A law is worth a point a test; a report one for each right prediction and each challenge that is passed. A report can be forged."""

    folder: tyro.conf.Positional[Path]
    """With what was handed in, and folders in it; or a ZIP file of that, such as the teacher's page saves."""
    csv: Path = Path("marks.csv")
    """The table: one row a file, with the reason for every failure."""
    jobs: int = 0
    """Files at a time; 0 takes half of the cores, so that no law is slow for another's sake."""
    seconds: float = 120.0
    """Longest time for one file [s]."""


@dataclass
class GradedFile:
    """One row of the table; a column that does not apply stays empty.

    Attributes:
        isolation: see `app.custom_law.marked.LawMarks`.
    """

    name: str
    kind: str
    cells: dict[str, object] = field(default_factory=dict)
    points: int = 0
    reason: str = ""
    isolation: str = ""


def grade(command: Grade) -> int:
    """Grade the files and write the table; return the exit code.

    Raises:
        BadSetting: there is nothing to grade, an option is not possible, or the table cannot be written.
    """
    with ending_at_once():
        from app.custom_law.fence import FenceLimits
        from app.custom_law.trials import TRIALS
    if command.jobs < 0 or not 1.0 <= command.seconds <= 3600.0:
        raise BadSetting("grade needs jobs from 1, or 0 for half of the cores, and seconds from 1 to 3600.")
    if not command.csv.absolute().parent.is_dir():
        raise BadSetting(f"csv = {command.csv}: there is no folder {command.csv.absolute().parent}; make it first.")
    limits = FenceLimits(seconds=command.seconds)
    with unpacked(command.folder) as folder:
        paths = handed_in(folder)
        if not paths:
            raise BadSetting(f"{command.folder}: holds no law (*.py) and no lab report (*.html).")
        with written(command.csv, "csv") as new:
            rows = _graded(replace(command, folder=folder), paths, limits)
            write_marks(new, rows, tuple(TRIALS))
    print(f"{command.csv}: {len(rows)} files.")
    return 0


@contextmanager
def unpacked(given: Path) -> Iterator[Path]:
    """Give a folder, or one with the content of a ZIP file while open.

    Raises:
        BadSetting: it is neither, or what it holds is too much.
    """
    if given.is_dir():
        yield given
        return
    with tempfile.TemporaryDirectory(prefix="duet-grade-") as folder:
        try:
            with zipfile.ZipFile(given) as archive:
                parts = [part for part in archive.infolist() if Path(part.filename).suffix.lower() in KINDS]
                if len(parts) > MOST_PARTS or sum(part.file_size for part in parts) > MOST_BYTES:
                    raise BadSetting(
                        f"{given}: holds more than {MOST_PARTS} files or {MOST_BYTES >> 20} MiB; grade a part of it."
                    )
                archive.extractall(folder, parts)
        except (OSError, RuntimeError, ValueError, NotImplementedError, zlib.error, zipfile.BadZipFile):
            raise BadSetting(f"{given}: is no folder and no ZIP file; give the one with what was handed in.") from None
        yield Path(folder)


def handed_in(folder: Path) -> list[Path]:
    """Return what is to be graded in a folder and below, sorted; links are named, and not followed."""
    found: list[Path] = []
    for where, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name != "__pycache__"]
        links = [name for name in folders if os.path.islink(os.path.join(where, name))]
        found += [Path(where, name) for name in (*files, *links) if Path(name).suffix.lower() in KINDS]
    return sorted(found, key=lambda path: os.fsencode(path))


def _graded(command: Grade, paths: list[Path], limits: "FenceLimits") -> list[GradedFile]:
    """Return the rows in the order of the files, and say on stderr how far it is."""
    stopped, said = threading.Event(), set[str]()
    jobs = command.jobs or max(1, cores() // 2)
    with ThreadPoolExecutor(jobs) as pool:
        work = {pool.submit(graded, path, command.folder, limits, stopped): path for path in paths}
        try:
            for number, done in enumerate(as_completed(work), 1):
                row = done.result()
                print(f"{number}/{len(paths)} {csv_cell(row.name)}: {row.points}", file=sys.stderr)
                if row.isolation in ISOLATION and row.isolation not in said:
                    said.add(row.isolation)
                    print(f"lwr-duet: {ISOLATION[row.isolation]}", file=sys.stderr)
        except BaseException:
            stopped.set()
            pool.shutdown(cancel_futures=True)
            raise
        return [done.result() for done in work]


def graded(path: Path, folder: Path, limits: "FenceLimits", stopped: threading.Event) -> GradedFile:
    """Return the row of a file, whatever that holds."""
    from app.custom_law.custom_law import LARGEST
    from app.custom_law.marked import marked
    from app.export import report_record

    kind = KINDS[path.suffix.lower()]
    row = GradedFile(readable(str(path.relative_to(folder))), kind)
    if path.is_symlink():
        row.reason = "a link, not a file"
        return row
    try:
        if kind == "law":
            marks = marked(readable(path.name), read_file(path, LARGEST), limits, stopped.is_set)
            _take_marks(row, marks)
        else:
            _take_records(row, report_record.read_records(read_file(path, report_record.LARGEST)))
    except OSError as error:
        row.reason = f"cannot be read ({error.strerror or error})"
    except Exception as error:
        # It costs its own row, and not the others'.
        row.reason = str(error) or type(error).__name__
    return row


def _take_marks(row: GradedFile, marks: "LawMarks") -> None:
    row.isolation = marks.isolation
    row.cells |= {name: "pass" if passed else "fail" for name, passed in marks.passed.items()}
    row.points = sum(marks.passed.values())
    same: defaultdict[str, list[str]] = defaultdict(list)
    for name, reason in marks.reasons.items():
        same[reason].append(name)
    row.reason = "; ".join((*(f"{', '.join(names)}: {reason}" for reason, names in same.items()), *filter(None, [marks.ended])))


def _take_records(row: GradedFile, records: "tuple[StepRecord, ...]") -> None:
    predicted = [record for record in records if record.prediction is not None]
    challenges = [record for record in records if record.passed is not None]
    right, passed = sum(record.right is True for record in predicted), sum(record.passed is True for record in challenges)
    row.cells |= {
        "steps": len(records),
        "predictions": len(predicted),
        "right": right,
        "challenges": len(challenges),
        "passed": passed,
        "attempts": sum(record.attempts for record in records),
    }
    row.points = right + passed
    wrong = [
        f"{r.lesson}/{r.step}: answer {r.prediction} is {'not right' if r.right is False else 'open'}"
        for r in predicted
        if not r.right
    ]
    failed = [f"{r.lesson}/{r.step}: challenge not passed in {r.attempts} attempts" for r in challenges if not r.passed]
    row.reason = "; ".join((*wrong, *failed))


REPORT: Final = ("steps", "predictions", "right", "challenges", "passed", "attempts")
"""Columns of a report."""


def write_marks(path: Path, rows: list[GradedFile], tests: tuple[str, ...]) -> None:
    """Write the table."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("name", "kind", *tests, *REPORT, "points", "reason"))
        for row in rows:
            values = (row.name, row.kind, *(row.cells.get(key, "") for key in (*tests, *REPORT)), row.points, row.reason)
            writer.writerow([csv_cell(value) for value in values])
