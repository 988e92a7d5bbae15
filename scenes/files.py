"""The user's files: read up to a size, written completely or not at all, with one-line errors."""

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
    """Content of a file of at most `most` bytes; never blocks.

    Raises:
        OSError: unreadable, a pipe, a device or a folder, or larger (errno EFBIG).
    """
    # Opening a pipe without a writer would block.
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
        raise OSError(errno.EFBIG, f"larger than {most / 1e6:.3g} MB")
    return data


def input_content(
    path: Path, most: int, missing: BadInputFile | None = None, larger: BadInputFile | None = None
) -> bytes:
    """`read_file` for input files.

    Args:
        missing, larger: error for a missing or larger file; None for the system's words.

    Raises:
        BadInputFile: unreadable.
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
    """Yield a draft in the same folder, which replaces `path` at the end: a reader never sees half a file,
    and an error or Ctrl+C leaves none. A device or a pipe is yielded itself.

    Raises:
        OSError: `path` cannot be written.
    """
    if path.exists():
        _check_replaceable(path)
        if not path.is_file():
            # Kept open: a pipe without a reader raises here, and would block later.
            with open(os.open(path, os.O_WRONLY | _WITHOUT_WAITING), "wb", 0):
                yield path
            return
    # A link stays; its file is replaced.
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
    """Command-line text or file name as UTF-8, in any locale."""
    return os.fsencode(text).decode("utf-8", "replace")


LONGEST_CELL: Final = 2000

_FORMULA: Final = ("=", "+", "-", "@", "＝", "＋", "－", "＠")


def csv_cell(value: object) -> str:
    """A value as one line, never a spreadsheet formula."""
    text = "".join(c if c.isprintable() else " " for c in str(value))[:LONGEST_CELL].strip()
    return f"'{text}" if text[:1] in _FORMULA else text


def csv_text(rows: Iterable[Iterable[object]], end: str = "\n") -> str:
    """Rows as CSV: numbers exactly, other values by `csv_cell`. `end`: of a line."""
    out = io.StringIO()
    cells = (
        [repr(value) if isinstance(value, int | float) else csv_cell(value) for value in row] for row in rows
    )
    csv.writer(out, lineterminator=end).writerows(cells)
    return out.getvalue()


def path_inside(folder: Path, name: str) -> Path | None:
    """Path in a folder, all links followed; None if it is outside."""
    try:
        path = Path(os.path.realpath(folder / name))
    except ValueError:
        # A zero byte.
        return None
    return path if path.is_relative_to(os.path.realpath(folder)) else None


@contextmanager
def written(path: Path, option: str) -> Iterator[Path]:
    """`replacing` for the path or folder of a command's option.

    Raises:
        BadSetting: the path cannot be written.
    """
    with writable(path, option), replacing(path) as draft:
        yield draft


@contextmanager
def writable(path: Path, option: str) -> Iterator[None]:
    """Turn an `OSError` into the `BadSetting` of an option."""
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
    """Raise `BadSetting` if the file of an option cannot be written."""
    if not os.path.isdir(path.absolute().parent):
        raise BadSetting(f"{option} = {path}: there is no folder {path.absolute().parent}; make it first.")
    with writable(path, option):
        if path.exists():
            _check_replaceable(path)
        # A device or a pipe needs no draft, and must not be opened twice.
        if not path.exists() or path.is_file():
            with tempfile.TemporaryFile(dir=Path(os.path.realpath(path)).parent):
                pass
