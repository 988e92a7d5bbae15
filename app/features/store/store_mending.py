"""Replacement of a damaged store."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from glob import escape
from pathlib import Path
from typing import Final

from app.features.store.sqlite_pages import Pages, is_whole
from app.features.store.store_file import Change, StoreFile, is_passing

_DATE: Final = "%Y%m%d-%H%M%S"


@contextmanager
def mending(path: Path, how: int = fcntl.LOCK_EX) -> Iterator[None]:
    """Lock under which one process replaces an unusable file. `how`: `LOCK_SH` to open it."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    lock = os.open(path.with_name(path.name + ".mending"), os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(lock, how)
        yield
    finally:
        os.close(lock)


def is_usable(path: Path, most_bytes: int) -> bool:
    """True if a file can be read and written, or made.

    Raises:
        sqlite3.Error, OSError: it cannot be opened now.
    """
    try:
        StoreFile(path, most_bytes).close()
    except Exception as error:
        if is_passing(error):
            raise
        return False
    return True


def set_aside(path: Path, most_bytes: int, now: float) -> tuple[Path, int]:
    """Replace an unusable file by a new one with the readable records. `now`: time [s since 1970].

    Returns:
        The old file's new path, and the number of readable records.

    Raises:
        sqlite3.Error, OSError: there can be no new file now; the old one stays.
    """
    new = path.with_name(path.name + ".new")
    for one in (new, *_sides(new)):
        one.unlink(missing_ok=True)
    changes = list(_readable(path, now))
    file = StoreFile(new, most_bytes)
    try:
        file.write(changes)
    finally:
        file.close()
    aside = _free_name(path, now)
    for side, its in zip(_sides(path), _sides(aside), strict=True):
        if side.exists():
            side.rename(its)
    path.rename(aside)
    new.rename(path)
    return aside, len(changes)


def _free_name(path: Path, now: float) -> Path:
    """Name of a damaged file; a later second if another one has this one."""
    while True:
        name = path.with_name(f"{path.name}.damaged-{datetime.fromtimestamp(now):{_DATE}}")
        if not name.exists():
            return name
        now += 1.0


def last_aside(path: Path) -> tuple[str, float]:
    """Name and time [s since 1970] of the newest damaged file; "" and 0 without one."""
    # Excludes SQLite's own files and packed ones.
    names = path.parent.glob(f"{escape(path.name)}.damaged-{8 * '[0-9]'}-{6 * '[0-9]'}")
    name = max((one.name for one in names), default="")
    return name, datetime.strptime(name.rpartition(".damaged-")[2], _DATE).timestamp() if name else 0.0


def _sides(path: Path) -> tuple[Path, ...]:
    return tuple(path.with_name(path.name + end) for end in ("-wal", "-shm"))


def _readable(path: Path, now: float) -> Iterator[Change]:
    """An impossible time becomes now."""
    heads: dict[str, tuple[float, bytes]] = {}
    parts: dict[str, dict[str, bytes]] = {}
    for row in Pages(path).rows():
        match row:
            case (str(tab), str(name), bytes(content)) if is_whole(content):
                parts.setdefault(tab, {})[name] = content
            case (str(tab), float() | int() as saved, bytes(head)) if is_whole(head):
                heads[tab] = saved if 0.0 < saved <= now else now, head
            case _:
                pass
    for tab, (saved, head) in heads.items():
        yield Change(tab, saved, head, parts.get(tab, {}), ())
