"""The SQLite file of visitors' records."""

import fcntl
import os
import sqlite3
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final, NamedTuple

import platformdirs

from app.features.store.sqlite_pages import PAGE, Pages, is_whole
from controllers.errors import DuetError

APPLICATION: Final = 0x44754574
"""SQLite's application id."""

VERSION: Final = 1
"""A file of another version is set aside."""

_TABLES: Final = """
CREATE TABLE tabs (tab TEXT PRIMARY KEY, saved REAL NOT NULL, head BLOB NOT NULL);
CREATE TABLE parts (
    tab TEXT NOT NULL REFERENCES tabs ON DELETE CASCADE, name TEXT NOT NULL, content BLOB NOT NULL, PRIMARY KEY (tab, name)
);
CREATE INDEX by_age ON tabs (saved);
"""

_SQLITE: Final = b"SQLite format 3\0"

_MODES: Final = (1, 2)
"""Valid write and read versions, the bytes 18 and 19."""

_PASSING: Final = (
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_LOCKED,
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_PROTOCOL,
)
"""Errors of the disk or of another process."""


_WRITING: Final = (
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_LOCKED,
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR_WRITE,
)
"""Errors of a connection that still reads; the last is a quota's."""


class StoreRefused(DuetError):
    """Another server's or program's file; the message names the remedy."""


class StoreTaken(StoreRefused):
    """Another server keeps its visitors in the file."""


class Unusable(Exception):
    """Damaged, or of another version; the message says which."""


class Change(NamedTuple):
    """Changes of one tab. `saved`: [s since 1970]; `gone`: names of unneeded parts."""

    tab: str
    saved: float
    head: bytes
    parts: Mapping[str, bytes]
    gone: Iterable[str]


def usual_path() -> Path:
    return platformdirs.user_state_path("lwr-duet") / "visitors.sqlite"


class StoreLock:
    """Holds a store for one server until it is released or its process dies. Workers do not need it.

    Raises:
        StoreTaken: another server holds it.
        StoreRefused: it is not a store.
        OSError: there can be no file.
    """

    def __init__(self, path: Path) -> None:
        if not _is_free_or_store(path):
            raise StoreRefused(
                f"{path} is not a store of Duet; name another file with --store, or keep nothing with --store memory."
            )
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._file = os.open(_lock_of(path), os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._file)
            raise StoreTaken(
                f"Another server keeps its visitors in {path}; give this one a file of its own with --store other.sqlite, "
                "or --store memory to keep nothing."
            ) from None

    def note_port(self, port: int) -> None:
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, f"{port}\n".encode(), 0)

    @staticmethod
    def last_port(path: Path) -> int | None:
        """Port of the store's present or last server, or None."""
        try:
            return int(_lock_of(path).read_bytes()[:6])
        except (OSError, ValueError):
            return None

    def release(self) -> None:
        os.close(self._file)


class StoreFile:
    """Records in a file. Each process opens it itself; one thread at a time may use it.

    Args:
        path: a new file is for the user alone; an existing one keeps its mode.
        most_bytes: beyond this the oldest tabs are deleted.

    Raises:
        Unusable: damaged, or of another version.
        sqlite3.Error, OSError: cannot be opened, or damaged; see `is_passing`.
    """

    def __init__(self, path: Path, most_bytes: int) -> None:
        self._path, self._most_bytes = path, most_bytes
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o600))
        self._number = path.stat().st_ino
        self.connection = sqlite3.connect(path, timeout=2.0, isolation_level=None, check_same_thread=False)
        try:
            self._prepare()
        except BaseException:
            self.connection.close()
            raise

    def _prepare(self) -> None:
        execute = self.connection.execute
        with self._path.open("rb") as file:
            head = file.read(20)
        if head and not (head.startswith(_SQLITE) and head[18] in _MODES and head[19] in _MODES):
            # With an unknown mode it could be read but never written.
            raise Unusable("its head is damaged")
        (tables,) = execute("SELECT count(*) FROM sqlite_master").fetchone()
        if not tables and self._pragma("page_count") <= 1:
            execute(f"PRAGMA page_size = {PAGE}")
            execute("PRAGMA auto_vacuum = INCREMENTAL")
            execute("PRAGMA journal_mode = WAL")
            self.connection.executescript(
                f"BEGIN; PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {VERSION}; {_TABLES} COMMIT;"
            )
        if self._pragma("application_id") != APPLICATION:
            raise Unusable("it is not of this program")
        version = self._pragma("user_version")
        if version != VERSION:
            raise Unusable(f"it is of version {version}, and this program reads {VERSION}")
        (state,) = execute("PRAGMA integrity_check(1)").fetchone()
        if state != "ok":
            raise Unusable(str(state))
        execute("PRAGMA journal_mode = WAL")
        # A killed server loses nothing; only a power failure may lose the last moments.
        execute("PRAGMA synchronous = NORMAL")
        execute("PRAGMA foreign_keys = ON")
        execute("PRAGMA secure_delete = ON")

    def is_replaced(self) -> bool:
        """True if another file has its name now."""
        try:
            return os.stat(self._path).st_ino != self._number
        except FileNotFoundError:
            return True

    def write(self, changes: Iterable[Change]) -> None:
        """Write all changes or none."""
        execute = self.connection.execute
        execute("BEGIN IMMEDIATE")
        try:
            for tab, saved, head, parts, gone in changes:
                execute(
                    "INSERT INTO tabs VALUES (?, ?, ?) ON CONFLICT (tab) DO UPDATE SET saved = excluded.saved, head = excluded.head",
                    (tab, saved, head),
                )
                self.connection.executemany(
                    "DELETE FROM parts WHERE tab = ? AND name = ?", ((tab, name) for name in gone)
                )
                rows = ((tab, name, content) for name, content in parts.items())
                self.connection.executemany("INSERT OR REPLACE INTO parts VALUES (?, ?, ?)", rows)
            execute("COMMIT")
        except BaseException:
            if self.connection.in_transaction:
                execute("ROLLBACK")
            raise

    def read(self, tab: str) -> tuple[float, bytes, dict[str, bytes]] | None:
        """Time [s since 1970], head and parts, or None."""
        execute = self.connection.execute
        found = execute("SELECT saved, head FROM tabs WHERE tab = ?", (tab,)).fetchone()
        return (
            None
            if found is None
            else (*found, dict(execute("SELECT name, content FROM parts WHERE tab = ?", (tab,))))
        )

    def has(self, tab: str) -> bool:
        return bool(self.connection.execute("SELECT 1 FROM tabs WHERE tab = ?", (tab,)).fetchone())

    def names(self, tab: str) -> list[str]:
        return [name for (name,) in self.connection.execute("SELECT name FROM parts WHERE tab = ?", (tab,))]

    def clean(self, now: float, keep: float) -> set[str]:
        """Delete the tabs saved before `now` − `keep` and the oldest beyond the limit; return these.

        A future time counts as now: the clock was set back.
        """
        execute, before = self.connection.execute, now - keep
        execute("UPDATE tabs SET saved = ? WHERE saved > ?", (now, now))
        gone = {
            tab for (tab,) in execute("DELETE FROM tabs WHERE saved < ? RETURNING tab", (before,)).fetchall()
        }
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
        pages, free, size = (self._pragma(name) for name in ("page_count", "freelist_count", "page_size"))
        return (pages - free) * size

    def _pragma(self, name: str) -> int:
        return self.connection.execute(f"PRAGMA {name}").fetchone()[0]

    def close(self) -> None:
        self.connection.close()


def _lock_of(path: Path) -> Path:
    return path.with_name(path.name + ".lock")


def is_passing(error: BaseException) -> bool:
    """True if the next attempt may succeed: the content is not at fault."""
    if isinstance(error, sqlite3.Error):
        code = getattr(error, "sqlite_errorcode", 0)
        return code & 0xFF in _PASSING and code != sqlite3.SQLITE_IOERR_SHORT_READ
    return isinstance(error, OSError | MemoryError | StoreRefused)


def still_reads(error: BaseException) -> bool:
    """True if only writing fails: the disk is full, or another process writes."""
    return getattr(error, "sqlite_errorcode", 0) in _WRITING


def _is_free_or_store(path: Path) -> bool:
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            return False
    except (FileNotFoundError, NotADirectoryError):
        return True
    pages = Pages(path)
    head = pages.page(1)
    sign, tables = head[68:72], head[103:105]
    if head[: len(_SQLITE)] == _SQLITE[: len(head)] and not any(sign + tables):
        # Just begun, or cut off.
        return True
    if b"\0" in head and (sign == APPLICATION.to_bytes(4, "big") or _TABLES[:40].strip().encode() in head):
        return True
    return any(isinstance(row[-1], bytes) and is_whole(row[-1]) for row in pages.rows())
