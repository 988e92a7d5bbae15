"""Visitors' records, written and read in a thread: no frame waits for the disk."""

import fcntl
import logging
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Final

from app.features.store.record_bytes import (
    DamagedRecord,
    joined_record,
    record_from_bytes,
    record_to_bytes,
    split_record,
    visitor_from_bytes,
)
from app.features.store.store_file import Change, StoreFile, StoreLock, is_passing, still_reads
from app.features.store.store_mending import is_usable, last_aside, mending, set_aside
from app.hosting.visitor_record import VisitorRecord, tab_id
from app.runtime.throttled_log import ThrottledLog
from app.web.traffic_limits import remember
from scenes.inputs import Recorded

log = logging.getLogger("duet.store")

BEAT: Final = 0.5
"""Period of writing [s]."""

AGAIN: Final = 5.0
"""Delay after a failed write [s]."""

CLEANING: Final = 60.0
"""Period of the removal of old records [s]."""

MOST_WAITING: Final = 32
"""Most records that wait for a disk; the oldest is dropped."""


@dataclass
class _Written:
    """File content of a tab: head as bytes, parts as their source objects."""

    head: bytes = b""
    parts: Mapping[str, Recorded | None] = field(default_factory=dict)
    saved: float = 0.0


class RecordWriter:
    """Keeps records in a file. `put` and `ask` are thread-safe and return at once.

    An unusable file is set aside, and its readable records are kept.

    Args:
        keep: time after a record's last change [s].
        owned: take the lock of the file; false if this process's server holds it.
        clock: time [s since 1970].

    Attributes:
        problem: why records cannot be written now, or "".
        aside: name and time [s since 1970] of the last damaged file; "" and 0 without one.

    Raises:
        StoreRefused: another server or program has the file.
    """

    def __init__(
        self,
        path: Path,
        keep: float,
        most_bytes: int,
        *,
        owned: bool = True,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self.path, self.problem, self.aside = path, "", ("", 0.0)
        self._retention, self._most_bytes, self._owned, self._clock = keep, most_bytes, owned, clock
        self._lock: StoreLock | None = None
        self.file: StoreFile | None = None
        self.waiting: dict[str, VisitorRecord] = {}
        self._asked: list[tuple[str, Future[VisitorRecord | None]]] = []
        self._written: dict[str, _Written] = {}
        # Tabs that may have an unreadable record: it is not overwritten.
        self._unread: set[str] = set()
        self._guard, self._wake, self._ended = threading.Lock(), threading.Event(), False
        self._failed_at = self._cleaned_at = self._replaced_at = -inf
        self._errors = ThrottledLog(log)
        if owned:
            # Without a lock there is no file, which is reported below.
            with suppress(OSError):
                self._lock = StoreLock(path)
        self._try(self._open)
        self._thread = threading.Thread(target=self._run, name="duet-store", daemon=True)
        self._thread.start()

    def put(self, tab: str, record: VisitorRecord) -> None:
        """Replaces the tab's earlier record."""
        with self._guard:
            remember(self.waiting, tab, record, MOST_WAITING if self.problem else inf)

    def ask(self, tab: str) -> "Future[VisitorRecord | None]":
        """None without a readable record."""
        answer: Future[VisitorRecord | None] = Future()
        with self._guard:
            self._asked.append((tab, answer))
        self._wake.set()
        return answer

    def close(self) -> None:
        self._ended = True
        self._wake.set()
        self._thread.join()

    # ---- in the thread -----------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._ended:
            self._wake.wait(BEAT)
            self._wake.clear()
            self._turn()
        for _ in range(2):
            # Also into a file that was replaced since the first time.
            self._failed_at = -inf
            self._turn()
        self._close_file()
        if self._lock is not None:
            self._lock.release()

    def _turn(self) -> None:
        now = self._clock()
        # The clock may have been set back.
        if abs(now - self._failed_at) >= AGAIN:
            self._try(self._write)
            if abs(now - self._cleaned_at) >= CLEANING:
                self._cleaned_at = now
                self._try(self._clean)
        with self._guard:
            asked, self._asked = self._asked, []
        for tab, answer in asked:
            answer.set_result(self._read(tab))

    def _try(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:
            self._failed(error)

    def _failed(self, error: Exception) -> None:
        """Set a damaged file aside; otherwise try again later."""
        if still_reads(error):
            # Visitors who return meanwhile must find their records.
            self._wait(error)
            return
        found_open = self.file is not None and not self.file.is_replaced()
        self._close_file()
        # A second fault so soon is not the old file's.
        if is_passing(error) or abs(self._clock() - self._replaced_at) < CLEANING:
            self._wait(error)
            return
        try:
            with mending(self.path):
                # Another worker may have done it meanwhile.
                if found_open or not is_usable(self.path, self._most_bytes):
                    self._replaced_at = self._clock()
                    aside, count = set_aside(self.path, self._most_bytes, self._replaced_at)
                    log.warning(
                        "the file of visitors %s is damaged (%s); it is now %s, and its %d readable records are in a new one",
                        *(self.path, error, aside.name, count),
                    )
            self._open()
        except Exception as trouble:
            self._wait(trouble)

    def _wait(self, error: Exception) -> None:
        self._failed_at = self._clock()
        if not self.problem:
            log.warning("visitors' records cannot be written to %s (%s); it is tried again", self.path, error)
        # Without the path: anybody may read it.
        self.problem = (error.strerror if isinstance(error, OSError) else None) or str(error)

    def _open(self) -> None:
        if self._lock is None and self._owned:
            self._lock = StoreLock(self.path)
        if self.file is not None and self.file.is_replaced():
            # Another worker has found it damaged.
            self._close_file()
        if self.file is None:
            with mending(self.path, fcntl.LOCK_SH):
                self.file = StoreFile(self.path, self._most_bytes)
            # By this process or another one.
            self.aside = last_aside(self.path)
            self.file.clean(self._clock(), self._retention)

    def _close_file(self) -> None:
        self._written.clear()
        if self.file is not None:
            self.file.close()
            self.file = None

    def _write(self) -> None:
        with self._guard:
            waiting, self.waiting = self.waiting, {}
        try:
            self._open()
            news = {
                tab: new for tab, record in waiting.items() if (new := self._news(tab, record)) is not None
            }
            if news:
                self._opened.write(change for change, _ in news.values())
        except Exception:
            with self._guard:
                # Records that arrived meanwhile are newer.
                self.waiting = {**waiting, **self.waiting}
            raise
        self._written |= {tab: written for tab, (_, written) in news.items()}
        if self.problem:
            log.info("visitors' records are written to %s again", self.path)
            self.problem = ""

    def _news(self, tab: str, record: VisitorRecord) -> tuple[Change, _Written] | None:
        """Change of a record and the file's content after it, or None."""
        before, now = self._written.get(tab), self._clock()
        if before is not None and not self._opened.has(tab):
            # Another worker has deleted it with its parts, to make room.
            before = None
        if before is None:
            # Not written lately: the names of its parts are read.
            if tab in self._unread and self._opened.read(tab) is not None:
                return None
            self._unread.discard(tab)
            before = _Written(parts=dict.fromkeys(self._opened.names(tab)))
        try:
            whole, parts = split_record(record)
            head = record_to_bytes(whole)
            new = {
                name: record_to_bytes(piece)
                for name, piece in parts.items()
                if before.parts.get(name) is not piece
            }
        except Exception as error:
            self._errors.exception("a visitor's record cannot be written", error)
            return None
        gone = before.parts.keys() - parts.keys()
        if head == before.head and not new and not gone and abs(now - before.saved) < CLEANING:
            return None
        return Change(tab, now, head, new, gone), _Written(head, parts, now)

    def _clean(self) -> None:
        now = self._clock()
        self._written = {
            tab: one for tab, one in self._written.items() if abs(now - one.saved) < 2.0 * CLEANING
        }
        if self.file is not None:
            for tab in self.file.clean(now, self._retention):
                self._written.pop(tab, None)

    def _read(self, tab: str) -> VisitorRecord | None:
        with self._guard:
            waiting = self.waiting.get(tab)
        if waiting is not None:
            return waiting
        try:
            found = self._found(tab)
            if found is None or found[0] < self._clock() - self._retention:
                return None
            record = visitor_from_bytes(found[1])
            if tab_id(record.query) != tab_id({"resume": tab}):
                raise DamagedRecord("it is of another tab")
            parts: dict[str, Recorded] = {}
            for name, content in found[2].items():
                try:
                    parts[name] = record_from_bytes(content, Recorded)
                except DamagedRecord as error:
                    log.warning("a part of a visitor's record in %s cannot be read (%s)", self.path, error)
            self._written[tab] = _Written(found[1], parts, found[0])
            return joined_record(record, parts)
        except Exception as error:
            log.warning("a visitor's record in %s cannot be read (%s)", self.path, error)
            return None

    def _found(self, tab: str) -> tuple[float, bytes, dict[str, bytes]] | None:
        self._unread.add(tab)
        try:
            found = self._opened.read(tab)
        except Exception as error:
            if is_passing(error):
                raise
            self._failed(error)
            found = self._opened.read(tab)
        self._unread.discard(tab)
        return found

    @property
    def _opened(self) -> StoreFile:
        if self.file is None:
            raise OSError(self.problem)
        return self.file
