"""Files named by the user: read only up to a size, and written completely or not at all, with one-line
errors.
"""

import csv
import errno
import io
import os
import secrets
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from controllers.errors import BadInputFile, BadSetting

_WITHOUT_WAITING: Final = getattr(os, "O_NONBLOCK", 0)


def read_file(path: Path, most: int) -> bytes:
    """Content of a file of at most `most` bytes. Never blocks, as a pipe would.

    Raises:
        OSError: it cannot be read, is a pipe, a device or a folder, or is larger (errno EFBIG).
    """
    # A pipe without a writer would block already when it is opened.
    try:
        number = os.open(path, os.O_RDONLY | _WITHOUT_WAITING | getattr(os, "O_BINARY", 0))
    except ValueError:
        # A zero byte in the name.
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)) from None
    if not stat.S_ISREG(os.fstat(number).st_mode):
        is_folder = stat.S_ISDIR(os.fstat(number).st_mode)
        os.close(number)
        raise OSError(errno.EINVAL, "a folder, not a file" if is_folder else "a pipe or a device, not a file")
    with open(number, "rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"larger than {most / 1e6:g} MB")
    return data


def input_content(
    path: Path, most: int, missing: BadInputFile | None = None, larger: BadInputFile | None = None
) -> bytes:
    """Content of an input file of a run or a scene; see `read_file`.

    Args:
        missing, larger: error for a missing file, or for more than `most` bytes; None for the system's words.

    Raises:
        BadInputFile: it cannot be read.
    """
    try:
        return read_file(path, most)
    except OSError as error:
        said = {errno.ENOENT: missing, errno.EFBIG: larger}.get(error.errno or 0)
        raise said or BadInputFile(
            "{name}: cannot be read ({reason}).", name=path, reason=error.strerror
        ) from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a path in the same folder, moved to `path` at the end: a reader never sees half a file, and an
    error or Ctrl+C leaves none. A device or a pipe is yielded as it is.

    Raises:
        OSError: it cannot be written.
    """
    if path.exists():
        _check_replaceable(path)
        if not path.is_file():
            # Held open: a pipe that no other process reads is refused here, and would block below.
            with open(os.open(path, os.O_WRONLY | _WITHOUT_WAITING), "wb", 0):
                yield path
            return
    # Of a link, the file that it leads to is replaced.
    path = Path(os.path.realpath(path))
    draft = path.with_name(f".{path.name[:64]}.{secrets.token_hex(4)}")
    try:
        yield draft
        os.replace(draft, path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def _check_replaceable(path: Path) -> None:
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def readable(text: str) -> str:
    """Text of the command line or a file's name as UTF-8, whatever the locale."""
    return os.fsencode(text).decode("utf-8", "replace")


LONGEST_CELL: Final = 2000

_FORMULA: Final = ("=", "+", "-", "@", "＝", "＋", "－", "＠")
"""Beginnings of a cell that a spreadsheet may compute."""


def csv_cell(value: object) -> str:
    """A value as one line that a spreadsheet does not take for a formula."""
    text = "".join(c if c.isprintable() else " " for c in str(value))[:LONGEST_CELL].strip()
    return f"'{text}" if text[:1] in _FORMULA else text


def csv_text(rows: Iterable[Iterable[object]], end: str = "\n") -> str:
    """Rows as CSV: numbers exactly, every other value by `csv_cell`. `end`: of a line."""
    out = io.StringIO()
    cells = (
        [repr(value) if isinstance(value, int | float) else csv_cell(value) for value in row] for row in rows
    )
    csv.writer(out, lineterminator=end).writerows(cells)
    return out.getvalue()


def path_inside(folder: Path, name: str) -> Path | None:
    """Path of a name in a folder with all links followed; None if that is outside the folder."""
    try:
        path = Path(os.path.realpath(folder / name))
    except ValueError:
        # A zero byte.
        return None
    return path if path.is_relative_to(os.path.realpath(folder)) else None


@contextmanager
def written(path: Path, option: str) -> Iterator[Path]:
    """Yield a draft that replaces `path` once it is written; see `replacing`.

    Args:
        option: the command's option that names it or its folder.

    Raises:
        BadSetting: it cannot be written.
    """
    with writable(path, option), replacing(path) as draft:
        yield draft


@contextmanager
def writable(path: Path, option: str) -> Iterator[None]:
    """Turn an `OSError` about a path into the `BadSetting` of the option that names it."""
    try:
        yield
    except OSError as error:
        # A folder was to be made.
        why = (
            f"{error.filename} is a file; give a folder"
            if isinstance(error, FileExistsError)
            else error.strerror or error
        )
        raise BadSetting(f"{option} = {path}: cannot be written ({why}).") from None


def check_writable(path: Path, option: str) -> None:
    """Raise the `BadSetting` of an option if its file cannot be written: before long work rather than after
    it.
    """
    if not os.path.isdir(path.absolute().parent):
        raise BadSetting(f"{option} = {path}: there is no folder {path.absolute().parent}; make it first.")
    with writable(path, option):
        if path.exists():
            _check_replaceable(path)
        # A device or a pipe needs no draft, and must not be opened twice.
        if not path.exists() or path.is_file():
            with tempfile.TemporaryFile(dir=Path(os.path.realpath(path)).parent):
                pass
