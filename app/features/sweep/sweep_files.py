"""Files of a sweep, CSV or Parquet."""

import csv
import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal

from controllers.errors import BadInputFile, BadSetting
from controllers.system_libraries import naming_missing_library
from scenes.csv_reading import read_text_table
from scenes.files import read_file, writable, written
from scenes.sweep import FIGURES, Grid, SweepFigures

_HEAD: Final = b"sweep"
_MOST_BYTES: Final = 1_000_000_000


def head_of(grid: Grid) -> tuple[str, ...]:
    """Common settings, and the values of the swept ones."""
    fixed = [f"{key} = {value}" for key, value in grid.fixed().items()]
    swept = [f"over {axis.key} = {', '.join(map(_cell, axis.values))}" for axis in grid.axes]
    return (*fixed, f"seconds = {grid.seconds!r}", *swept)


def sweep_columns(grid: Grid) -> tuple[str, ...]:
    return (*(axis.key for axis in grid.axes), *FIGURES)


class SweepFiles:
    """The table in a folder, `sweep.csv` or `sweep.parquet`; while incomplete, `sweep.part.csv`.

    Raises:
        BadSetting: it holds another sweep, or pyarrow is missing.
        BadInputFile: a table cannot be read.
    """

    def __init__(self, folder: Path, grid: Grid, form: Literal["csv", "parquet"]) -> None:
        if form == "parquet":
            _pyarrow()
        self.folder, self.grid, self.form = folder, grid, form
        self.table = folder / f"sweep.{form}"
        self.part = folder / "sweep.part.csv"
        self._points = grid.points()
        self.rows: dict[int, SweepFigures] = {}
        """Index of a point → figures."""
        for path in (self.table, self.part):
            if path.exists():
                self.rows |= self._read(path)

    def missing(self) -> list[int]:
        return [index for index in range(self.grid.size) if index not in self.rows]

    @contextmanager
    def recording(self) -> Iterator[Callable[[int, SweepFigures], None]]:
        """Function that writes a point's row at once.

        Raises:
            BadSetting: the folder cannot be written to.
        """
        with writable(self.folder, "out"):
            self.folder.mkdir(parents=True, exist_ok=True)
        # Rewritten: after a power failure the last row may be incomplete.
        self._write_csv(self.part)
        with writable(self.part, "out"):
            out = self.part.open("a", encoding="utf-8", newline="\n")

        def add(index: int, figures: SweepFigures) -> None:
            with writable(self.part, "out"):
                out.write(self._line(index, figures))
                out.flush()
            self.rows[index] = figures

        try:
            with out:
                yield add
        except KeyboardInterrupt:
            # It may come between a row's line and its place among the rows: what the file holds counts.
            self.rows |= self._read(self.part)
            raise

    def finish(self) -> None:
        if self.form == "csv":
            self._write_csv(self.table)
        else:
            self._write_parquet(self.table)
        self.part.unlink(missing_ok=True)

    def _line(self, index: int, figures: SweepFigures) -> str:
        line = io.StringIO()
        csv.writer(line, lineterminator="\n").writerow(map(_cell, (*self._points[index], *figures)))
        return line.getvalue()

    def _write_csv(self, path: Path) -> None:
        lines = [f"# {line}\n" for line in head_of(self.grid)]
        lines.append(",".join(sweep_columns(self.grid)) + "\n")
        lines += [self._line(index, figures) for index, figures in sorted(self.rows.items())]
        with written(path, "out") as new:
            new.write_text("".join(lines), encoding="utf-8", newline="\n")

    def _write_parquet(self, path: Path) -> None:
        pa, pq = _pyarrow()
        table = [(*self._points[index], *figures) for index, figures in sorted(self.rows.items())]
        columns = dict(zip(sweep_columns(self.grid), map(list, zip(*table, strict=True)), strict=True))
        with written(path, "out") as new:
            pq.write_table(
                pa.table(columns).replace_schema_metadata({_HEAD: "\n".join(head_of(self.grid)).encode()}),
                new,
            )

    def _read(self, path: Path) -> dict[int, SweepFigures]:
        head, cells = _read_parquet(path) if path.suffix == ".parquet" else _read_csv(path)
        self._check_head(path, head)
        indices = {tuple(map(_cell, point)): index for index, point in enumerate(self._points)}
        width = len(self.grid.axes)
        kept: dict[int, SweepFigures] = {}
        for row in cells:
            try:
                figures = zip(FIGURES, row[width:], strict=True)
                numbers = tuple(
                    int(text) if name == "pair_switches" else float(text) for name, text in figures
                )
                kept[indices[tuple(row[:width])]] = numbers
            except (ValueError, KeyError):
                raise BadInputFile(
                    f"{path}: the row {','.join(row)[:80]!r} is not of this sweep; remove the file."
                ) from None
        return kept

    def _check_head(self, path: Path, head: tuple[str, ...]) -> None:
        mine = head_of(self.grid)
        if head == mine:
            return
        theirs, ours = (
            dict(line.split(" = ", 1) for line in head if " = " in line),
            dict(line.split(" = ", 1) for line in mine),
        )
        key = next((key for key in (*ours, *theirs) if theirs.get(key) != ours.get(key)), None)
        # The rows of a file mean what the order of its settings says.
        difference = (
            "its settings are in another order"
            if key is None
            else f"{key} is {_short(theirs.get(key))} there, {_short(ours.get(key))} here"
        )
        raise BadSetting(
            f"out = {self.folder}: {path.name} is of another sweep ({difference}); "
            "give another --out, or remove the file."
        )


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else repr(value)


def _short(text: str | None) -> str:
    return "not given" if text is None else text if len(text) <= 40 else text[:37] + "…"


def _read_csv(path: Path) -> tuple[tuple[str, ...], list[list[str]]]:
    with _readable(path):
        data = read_file(path, _MOST_BYTES)
        # What follows the last line break is a row that was being written.
        data = data[: data.rfind(b"\n") + 1]
        head = tuple(line[2:] for line in data.decode("utf-8").split("\n") if line.startswith("# "))
        table = read_text_table(data, str(path), "remove it, or give another --out")
        # A drawn curve has commas.
        return head, [list(row.cells) for row in table.rows[1:]]


def _read_parquet(path: Path) -> tuple[tuple[str, ...], list[list[str]]]:
    _, pq = _pyarrow()
    with _readable(path):
        table = pq.read_table(io.BytesIO(read_file(path, _MOST_BYTES)))
    head = (table.schema.metadata or {}).get(_HEAD, b"").decode()
    return tuple(head.split("\n")), [[_cell(value) for value in row.values()] for row in table.to_pylist()]


def _pyarrow() -> tuple[Any, Any]:
    try:
        with naming_missing_library():
            import pyarrow  # pyright: ignore[reportMissingImports]
            import pyarrow.parquet  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise BadSetting(
            "format = parquet needs pyarrow, which is not installed: pip install pyarrow, or take --format csv."
        ) from None
    return pyarrow, pyarrow.parquet


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise BadInputFile(f"{path}: cannot be read ({error.strerror or error}).") from None
    except ValueError:
        raise BadInputFile(
            f"{path}: is not a table that a sweep has written; remove it, or give another --out."
        ) from None
