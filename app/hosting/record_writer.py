"""Writes and reads visitors' records in a thread of its own, so that no frame waits for the disk."""

import logging
import sqlite3
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Final

from app.hosting.record_bytes import DamagedRecord, joined, packed, split, unpacked
from app.hosting.store_file import Change, StoreFile, StoreInUse, StoreLock, Unusable, is_damage, is_usable, mending, set_aside
from app.hosting.visitor_record import VisitorRecord
from app.runtime.throttled_log import ThrottledLog
from scenes.inputs import Recorded

log = logging.getLogger("duet.store")

BEAT: Final = 0.5
"""Time between two looks at what is to be written [s]."""

AGAIN: Final = 5.0
"""Time after which writing is tried again when it has failed [s]."""

CLEANING: Final = 60.0
"""Time between two looks for what is too old or too much [s]."""

MOST_WAITING: Final = 32
"""Records that wait for a disk that cannot be written; the oldest makes room."""


@dataclass
class _Written:
    """What the file holds of a tab: its head as bytes, and its parts as the objects that they were made from."""

    head: bytes = b""
    parts: Mapping[str, Recorded | None] = field(default_factory=dict)
    saved: float = 0.0


class RecordWriter:
    """Keeps records in a file. `put` and `ask` return at once, from any thread.

    A file that cannot be used is renamed; one that cannot be written is tried again every `AGAIN`.

    Args:
        path: of the file.
        keep: how long a record is kept after its last change [s].
        most_bytes: of the file.
        owned: whether this process takes the lock of the file, or belongs to a server that holds it.
        clock: returns the time [s since 1970].

    Attributes:
        problem: why records cannot be written now; "" if they can.

    Raises:
        StoreInUse: another server holds the file.
    """

    def __init__(
        self, path: Path, keep: float, most_bytes: int, *, owned: bool = True, clock: Callable[[], float] = time.time
    ) -> None:
        self.path, self.problem = path, ""
        self._keep, self._most_bytes, self._owned, self._clock = keep, most_bytes, owned, clock
        self._lock: StoreLock | None = None
        self._file: StoreFile | None = None
        self._waiting: dict[str, VisitorRecord] = {}
        self._asked: list[tuple[str, Future[VisitorRecord | None]]] = []
        self._written: dict[str, _Written] = {}
        self._guard, self._wake, self._ended = threading.Lock(), threading.Event(), False
        self._retry_at = self._clean_at = 0.0
        self._errors = ThrottledLog(log)
        if owned:
            # Where there can be no lock there can be no file, which is said below.
            with suppress(OSError):
                self._lock = StoreLock(path)
        self._try(self._open)
        self._thread = threading.Thread(target=self._run, name="duet-store", daemon=True)
        self._thread.start()

    def put(self, tab: str, record: VisitorRecord) -> None:
        """Have a record written instead of the tab's earlier one."""
        with self._guard:
            self._waiting.pop(tab, None)
            self._waiting[tab] = record
            if self.problem and len(self._waiting) > MOST_WAITING:
                del self._waiting[next(iter(self._waiting))]

    def ask(self, tab: str) -> "Future[VisitorRecord | None]":
        """Have a tab's record read; None comes out if there is none, or none that can be read."""
        answer: Future[VisitorRecord | None] = Future()
        with self._guard:
            self._asked.append((tab, answer))
        self._wake.set()
        return answer

    def close(self) -> None:
        """Write everything that waits, and close the file."""
        self._ended = True
        self._wake.set()
        self._thread.join()

    # ---- in the thread -----------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._ended:
            self._wake.wait(BEAT)
            self._wake.clear()
            self._turn()
        self._retry_at = 0.0
        self._turn()
        if self._file is not None:
            self._file.close()
        if self._lock is not None:
            self._lock.release()

    def _turn(self) -> None:
        now = self._clock()
        if now >= self._retry_at:
            self._try(self._write)
            if now >= self._clean_at:
                self._clean_at = now + CLEANING
                self._try(self._clean)
        with self._guard:
            asked, self._asked = self._asked, []
        for tab, answer in asked:
            answer.set_result(self._read(tab))

    def _try(self, work: Callable[[], None]) -> None:
        """Do something with the file; what goes wrong is said and tried again."""
        try:
            work()
        except (sqlite3.Error, OSError, Unusable, StoreInUse) as error:
            found_open = self._file is not None and not self._file.is_replaced()
            self._close_file()
            if is_damage(error) or isinstance(error, Unusable):
                self._set_aside(error, found_open)
                return
            self._retry_at = self._clock() + AGAIN
            if not self.problem:
                log.warning("visitors' records cannot be written to %s (%s); it is tried again", self.path, error)
            self.problem = str(error)
        except Exception as error:
            # Of one record; the next one may be better.
            self._errors.exception("visitors' records were not written", error)

    def _open(self) -> None:
        if self._lock is None and self._owned:
            self._lock = StoreLock(self.path)
        if self._file is not None and self._file.is_replaced():
            # Another worker has found it damaged.
            self._close_file()
        if self._file is None:
            self._file = StoreFile(self.path, self._most_bytes)
            self._file.clean(self._clock() - self._keep)

    def _close_file(self) -> None:
        self._written.clear()
        if self._file is not None:
            self._file.close()
            self._file = None

    def _set_aside(self, reason: BaseException, certain: bool) -> None:
        try:
            with mending(self.path):
                # Another worker may have done it meanwhile.
                if certain or not is_usable(self.path):
                    aside = set_aside(self.path, datetime.fromtimestamp(self._clock()))
                    log.warning(
                        "the file of visitors %s %s; it is now %s, and a new one was begun", self.path, reason, aside.name
                    )
                self._open()
        except (OSError, sqlite3.Error, Unusable, StoreInUse) as error:
            self._retry_at, self.problem = self._clock() + AGAIN, str(error)

    def _write(self) -> None:
        with self._guard:
            waiting, self._waiting = self._waiting, {}
        changes: list[Change] = []
        after: dict[str, _Written] = {}
        try:
            self._open()
            assert self._file is not None
            for tab, record in waiting.items():
                self._add(tab, record, changes, after)
            if changes:
                self._file.write(changes)
        except (sqlite3.Error, OSError, Unusable, StoreInUse):
            with self._guard:
                # What has come meanwhile is newer.
                self._waiting = {**waiting, **self._waiting}
            raise
        self._written |= after
        if self.problem:
            log.info("visitors' records are written to %s again", self.path)
            self.problem = ""

    def _add(self, tab: str, record: VisitorRecord, changes: list[Change], after: dict[str, _Written]) -> None:
        """Add what is new of a record."""
        before, now = self._written.get(tab), self._clock()
        if before is None:
            before = self._known(tab)
        try:
            whole, parts = split(record)
            head = packed(whole)
            new = {name: packed(piece) for name, piece in parts.items() if before.parts.get(name) is not piece}
        except Exception as error:
            self._errors.exception("a visitor's record cannot be written", error)
            return
        gone = before.parts.keys() - parts.keys()
        if head == before.head and not new and not gone and now - before.saved < CLEANING:
            return
        changes.append(Change(tab, now, None if head == before.head else head, new, gone))
        after[tab] = _Written(head, parts, now)

    def _known(self, tab: str) -> _Written:
        """Return what the file holds of a tab that was not written lately: the names of its parts."""
        assert self._file is not None
        return _Written(parts=dict.fromkeys(self._file.names(tab)))

    def _clean(self) -> None:
        now = self._clock()
        self._written = {tab: one for tab, one in self._written.items() if now - one.saved < 2.0 * CLEANING}
        if self._file is not None:
            for tab in self._file.clean(now - self._keep):
                self._written.pop(tab, None)

    def _read(self, tab: str) -> VisitorRecord | None:
        with self._guard:
            waiting = self._waiting.get(tab)
        if waiting is not None:
            return waiting
        try:
            found = None if self._file is None else self._file.read(tab)
            if found is None or found[0] < self._clock() - self._keep:
                return None
            record: VisitorRecord = unpacked(found[1], VisitorRecord)
        except (sqlite3.Error, DamagedRecord) as error:
            log.warning("a visitor's record in %s cannot be read (%s)", self.path, error)
            return None
        parts: dict[str, Recorded] = {}
        for name, content in found[2].items():
            try:
                parts[name] = unpacked(content, Recorded)
            except DamagedRecord as error:
                log.warning("a part of a visitor's record in %s cannot be read (%s)", self.path, error)
        self._written[tab] = _Written(found[1], parts, found[0])
        return joined(record, parts)
