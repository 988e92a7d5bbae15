"""Absent visitors' live sessions and records."""

from collections.abc import Callable, Generator, Mapping
from concurrent.futures import wait
from dataclasses import replace
from time import monotonic, time
from typing import Final, NamedTuple

from app.features.store.record_writer import RecordWriter
from app.features.store.store_options import StoreOptions
from app.hosting.app_context import AppContext
from app.hosting.parking import AWAY, MOST_SESSIONS, Parking
from app.hosting.visitor_record import VisitorRecord, tab_id
from app.i18n.speaking import N_

MOST_RECORDS: Final = 300
"""Most records in memory; the oldest is dropped."""

LOOK: Final = 0.002
"""Longest wait of a frame for a record [s]."""


_NOT_SAVED: Final = (
    N_("This cannot be saved now"),
    N_("The server's disk cannot be written. You can continue; saving is tried again."),
)
_DAMAGED: Final = (
    N_("Earlier work may be missing"),
    N_("The server's file was damaged. What could be read of it is here, and what you do now is saved."),
)


class StoreState(NamedTuple):
    """Public state of the records. `lasting`: they outlive the server; for the others see `RecordWriter`."""

    lasting: bool
    problem: str
    set_aside: str


class SessionStore(Parking):
    """Keeps visitors' records, and absent visitors' live sessions. Belongs to the frame loop's thread.

    A tab gets its live session back by the same link, and its record by any link. Nothing is kept without a
    valid tab id.

    Args:
        keep: of a record [s]; a live session is kept for `AWAY`.
        file: None to keep records in memory only.
    """

    def __init__(
        self,
        keep: float = StoreOptions().seconds,
        clock: Callable[[], float] = monotonic,
        file: RecordWriter | None = None,
    ) -> None:
        super().__init__(clock)
        self.keep, self.file = keep, file
        self._records: dict[str, tuple[VisitorRecord, float]] = {}

    @property
    def lasting(self) -> bool:
        return self.file is not None

    @property
    def state(self) -> StoreState:
        file = self.file
        return StoreState(False, "", "") if file is None else StoreState(True, file.problem, file.aside[0])

    @property
    def health(self) -> Mapping[str, object]:
        return {"store": self.state._asdict()}

    @property
    def trouble(self) -> tuple[str, str] | None:
        if self.file is None:
            return None
        lately = abs(time() - self.file.aside[1]) < AWAY
        return _NOT_SAVED if self.file.problem else _DAMAGED if lately else None

    def alone_has(self, query: Mapping[str, str]) -> bool:
        return self.file is None and (tab_id(query) in self._records or super().alone_has(query))

    def save(self, record: VisitorRecord) -> None:
        tab = tab_id(record.query)
        if tab is None:
            return
        if self.file is not None:
            self.file.put(tab, record)
            return
        self._records.pop(tab, None)
        self._records[tab] = record, self._clock()
        self.tidy()

    def save_named(self, name: str, record: VisitorRecord) -> None:
        """Keep a record in the file only. `name`: too short for a tab's id."""
        if self.file is not None:
            self.file.put(name, record)

    def named(self, name: str) -> VisitorRecord | None:
        """Waits for the disk."""
        return None if self.file is None else self.file.ask(name).result()

    def recall(self, query: Mapping[str, str]) -> Generator[None, None, VisitorRecord | None]:
        tab = tab_id(query) or ""
        if self.awaits(query):
            return None
        if tab and self.file is not None:
            answer = self.file.ask(tab)
            while not wait((answer,), LOOK).done:
                yield
            return answer.result()
        self.tidy()
        found = self._records.get(tab)
        return None if found is None else found[0]

    def tidy(self) -> None:
        super().tidy()
        now = self._clock()
        # The oldest first.
        for tab, (_, since) in list(self._records.items()):
            if now - since <= self.keep and len(self._records) <= MOST_RECORDS:
                break
            del self._records[tab]
        if len(self._records) > MOST_SESSIONS:
            # Only the newest ones hold minutes of inputs.
            tab = list(self._records)[-MOST_SESSIONS - 1]
            record, since = self._records[tab]
            if record.state is not None:
                self._records[tab] = replace(record, state=None), since

    def close(self) -> None:
        super().close()
        if self.file is not None:
            self.file.close()


def store_of(context: AppContext) -> SessionStore:
    assert isinstance(context.store, SessionStore)
    return context.store
