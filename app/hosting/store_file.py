"""The SQLite file in which visitors' records outlive the server."""

import fcntl
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Final, NamedTuple

import platformdirs

from controllers.errors import DuetError

APPLICATION: Final = 0x44754574
"""SQLite's application id of our files."""

VERSION: Final = 1
"""Of the tables and of what is in them; a file of another one is set aside."""

MOST_BYTES: Final = 500_000_000
"""Largest file, if no other size is chosen [B]."""

_TABLES: Final = """
CREATE TABLE tabs (tab TEXT PRIMARY KEY, saved REAL NOT NULL, head BLOB NOT NULL);
CREATE TABLE parts (
    tab TEXT NOT NULL REFERENCES tabs ON DELETE CASCADE, name TEXT NOT NULL, content BLOB NOT NULL, PRIMARY KEY (tab, name)
);
CREATE INDEX by_age ON tabs (saved);
"""

_DAMAGED: Final = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)

_SIDES: Final = ("-wal", "-shm")
"""What SQLite adds to the name of a file that it writes to."""


class StoreInUse(DuetError):
    """Another server holds the file; the message names the remedy."""


class Unusable(Exception):
    """The file is damaged, or not one of this version; the message says which."""


class Change(NamedTuple):
    """What is new of one tab.

    Attributes:
        saved: when it was so [s since 1970].
        head: None if it is as before.
        parts: new ones by name.
        gone: names of parts that are no longer needed.
    """

    tab: str
    saved: float
    head: bytes | None
    parts: Mapping[str, bytes]
    gone: Iterable[str]


def usual_path() -> Path:
    """Return where the store is if no other place is chosen."""
    return platformdirs.user_state_path("lwr-duet") / "visitors.sqlite"


class StoreLock:
    """Holds a store for one server until it is released or its process dies. Worker processes open the file without it.

    Raises:
        StoreInUse: another server holds it.
        OSError: there can be no file.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._file = os.open(path.with_name(path.name + ".lock"), os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._file)
            raise StoreInUse(
                f"Another server keeps its visitors in {path}; give this one a file of its own with --store other.sqlite, "
                "or --store memory to keep nothing."
            ) from None

    def release(self) -> None:
        os.close(self._file)


class StoreFile:
    """The records in a file. Each process opens it for itself; in a process it belongs to one thread at a time.

    Args:
        path: made if it does not exist, for the user alone.
        most_bytes: beyond this the tabs that were saved longest ago are deleted.

    Raises:
        Unusable: what is there is damaged, or not of this version; `set_aside` makes room.
        sqlite3.Error, OSError: the file cannot be opened.
    """

    def __init__(self, path: Path, most_bytes: int) -> None:
        self._path, self._most_bytes = path, most_bytes
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))
        path.chmod(0o600)
        self._number = path.stat().st_ino
        self.connection = sqlite3.connect(path, timeout=2.0, isolation_level=None, check_same_thread=False)
        try:
            self._prepare()
        except BaseException as error:
            self.connection.close()
            if is_damage(error):
                raise Unusable(f"is damaged ({error})") from None
            raise

    def _prepare(self) -> None:
        execute = self.connection.execute
        (tables,) = execute("SELECT count(*) FROM sqlite_master").fetchone()
        if not tables:
            execute("PRAGMA auto_vacuum = INCREMENTAL")
            execute("PRAGMA journal_mode = WAL")
            self.connection.executescript(
                f"BEGIN; PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {VERSION}; {_TABLES} COMMIT;"
            )
        if execute("PRAGMA application_id").fetchone()[0] != APPLICATION:
            raise Unusable("is not a file of this program")
        (version,) = execute("PRAGMA user_version").fetchone()
        if version != VERSION:
            raise Unusable(f"is of version {version}, and this program reads {VERSION}")
        (state,) = execute("PRAGMA quick_check(1)").fetchone()
        if state != "ok":
            raise Unusable(f"is damaged ({state})")
        execute("PRAGMA journal_mode = WAL")
        # A killed server loses nothing; only a machine without power may lose the last moments.
        execute("PRAGMA synchronous = NORMAL")
        execute("PRAGMA foreign_keys = ON")
        execute("PRAGMA secure_delete = ON")

    def is_replaced(self) -> bool:
        """Return whether another file has its name now."""
        try:
            return os.stat(self._path).st_ino != self._number
        except FileNotFoundError:
            return True

    def write(self, changes: Iterable[Change]) -> None:
        """Write what is new of several tabs, all of it or nothing."""
        execute = self.connection.execute
        execute("BEGIN IMMEDIATE")
        try:
            for tab, saved, head, parts, gone in changes:
                if head is None:
                    execute("UPDATE tabs SET saved = ? WHERE tab = ?", (saved, tab))
                else:
                    execute(
                        "INSERT INTO tabs VALUES (?, ?, ?) ON CONFLICT (tab) DO UPDATE SET saved = excluded.saved, head = excluded.head",
                        (tab, saved, head),
                    )
                self.connection.executemany("DELETE FROM parts WHERE tab = ? AND name = ?", ((tab, name) for name in gone))
                rows = ((tab, name, content) for name, content in parts.items())
                self.connection.executemany("INSERT OR REPLACE INTO parts VALUES (?, ?, ?)", rows)
            execute("COMMIT")
        except BaseException:
            if self.connection.in_transaction:
                execute("ROLLBACK")
            raise

    def read(self, tab: str) -> tuple[float, bytes, dict[str, bytes]] | None:
        """Return when a tab was saved [s since 1970], its head and its parts; None if it is not there."""
        execute = self.connection.execute
        found = execute("SELECT saved, head FROM tabs WHERE tab = ?", (tab,)).fetchone()
        return None if found is None else (*found, dict(execute("SELECT name, content FROM parts WHERE tab = ?", (tab,))))

    def names(self, tab: str) -> list[str]:
        """Return the names of a tab's parts."""
        return [name for (name,) in self.connection.execute("SELECT name FROM parts WHERE tab = ?", (tab,))]

    def clean(self, before: float) -> set[str]:
        """Delete the tabs that were saved before a time [s since 1970], and the oldest beyond the limit; return which."""
        execute = self.connection.execute
        gone = {tab for (tab,) in execute("DELETE FROM tabs WHERE saved < ? RETURNING tab", (before,)).fetchall()}
        while self._used > self._most_bytes:
            oldest = execute(
                "DELETE FROM tabs WHERE tab = (SELECT tab FROM tabs ORDER BY saved LIMIT 1) RETURNING tab"
            ).fetchall()
            if not oldest:
                break
            gone |= {tab for (tab,) in oldest}
        if gone:
            # Statements without a column are stepped to their end only in a script.
            self.connection.executescript("PRAGMA incremental_vacuum; PRAGMA wal_checkpoint(TRUNCATE);")
        return gone

    @property
    def _used(self) -> int:
        """Return how many bytes are in use."""
        pages, free, size = (self._pragma(name) for name in ("page_count", "freelist_count", "page_size"))
        return (pages - free) * size

    def _pragma(self, name: str) -> int:
        return self.connection.execute(f"PRAGMA {name}").fetchone()[0]

    def close(self) -> None:
        self.connection.close()


def is_damage(error: BaseException) -> bool:
    """Return whether an error says that the content of a file is damaged."""
    return isinstance(error, sqlite3.DatabaseError) and getattr(error, "sqlite_errorcode", 0) & 0xFF in _DAMAGED


def is_usable(path: Path) -> bool:
    """Return whether a file can be read and written, or made.

    Raises:
        sqlite3.Error, OSError: it cannot be opened now.
    """
    try:
        StoreFile(path, MOST_BYTES).close()
    except Unusable:
        return False
    return True


@contextmanager
def mending(path: Path) -> Iterator[None]:
    """Let one process at a time replace a file that cannot be used."""
    lock = os.open(path.with_name(path.name + ".mending"), os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def set_aside(path: Path, now: datetime) -> Path:
    """Rename a file that cannot be used, with what SQLite has added to it, and return its new path."""
    aside = path.with_name(f"{path.name}.damaged-{now:%Y%m%d-%H%M%S}")
    for end in _SIDES:
        side = path.with_name(path.name + end)
        if side.exists():
            side.rename(aside.with_name(aside.name + end))
    path.rename(aside)
    return aside
