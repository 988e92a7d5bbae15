"""Expected content of a store file, for the store's state machine."""

from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from app.features.store.record_bytes import (
    DamagedRecord,
    joined_record,
    record_from_bytes,
    visitor_from_bytes,
)
from app.features.store.record_writer import CLEANING
from app.features.store.store_file import StoreFile
from app.hosting.visitor_record import VisitorRecord
from app.session.session import Session
from app.session.session_state import RunState, SessionState, state_of
from app.settings import Settings
from scenes.inputs import Recorded
from tests.app.features.store.test_session_store import content

PIECES = 6

NAMED = "lecture"
"""Name of a record without a tab."""


@cache
def states() -> tuple[SessionState, ...]:
    """States of one run; each has one recorded piece more than the previous one."""
    session, found = Session(Settings()), list[SessionState]()
    while len(found) <= PIECES:
        state = state_of(session)
        if len(state.run.pieces) == len(found):
            found.append(state)
        session.advance(0.05, 60.0)
    session.close()
    return tuple(found)


def one_piece_more(record: VisitorRecord) -> VisitorRecord:
    """The record after its run has continued: its own pieces, as read or saved, and a new one."""
    state = record.state or states()[0]
    steps = [one.run.snapshot.steps for one in states()]
    number = steps.index(state.run.snapshot.steps) + 1
    if number > PIECES:
        return record
    after = states()[number]
    # Older pieces may be missing after damage to the file.
    run = RunState(after.run.snapshot, (*state.run.pieces, after.run.pieces[-1]))
    return replace(record, state=replace(after, run=run))


def begun_again(record: VisitorRecord) -> VisitorRecord:
    return replace(record, state=states()[0])


def with_recording(record: VisitorRecord, name: str, number: int | None) -> VisitorRecord:
    others = {key: value for key, value in record.recordings.items() if key != name}
    added = {} if number is None else {name: states()[-1].run.pieces[number]}
    return replace(record, recordings={**others, **added})


@dataclass(frozen=True)
class Kept:
    """A record that was saved.

    Attributes:
        saved: time of the last save [s]; the file may have it up to `CLEANING` earlier.
    """

    record: VisitorRecord
    saved: float

    @property
    def earliest(self) -> float:
        return self.saved - CLEANING

    @property
    def size(self) -> int:
        head, parts = content(self.record)
        return len(head) + sum(map(len, parts.values()))


def file_content(path: Path) -> dict[str, tuple[VisitorRecord | None, set[str]]]:
    """Tab → record in a file (None if unreadable) with the names of its parts."""
    with closing(StoreFile(path, 10**9)) as file:
        tabs = [tab for (tab,) in file.connection.execute("SELECT tab FROM tabs ORDER BY tab")]
        strays = "SELECT count(*) FROM parts WHERE tab NOT IN (SELECT tab FROM tabs)"
        assert file.connection.execute(strays).fetchone() == (0,), "parts without a record"
        rows = {tab: row for tab in tabs if (row := file.read(tab)) is not None}
    return {tab: (_joined(head, parts), set(parts)) for tab, (_, head, parts) in rows.items()}


def _joined(head: bytes, parts: Mapping[str, bytes]) -> VisitorRecord | None:
    pieces: dict[str, Recorded] = {}
    for name, piece in parts.items():
        # A damaged part stays until its record is over.
        with suppress(DamagedRecord):
            pieces[name] = record_from_bytes(piece, Recorded)
    try:
        return joined_record(visitor_from_bytes(head), pieces)
    except DamagedRecord:
        return None


def _sorted(record: VisitorRecord) -> tuple[bytes, dict[str, bytes]]:
    """Content of a record with its parts sorted by name."""
    return content(replace(record, parts=dict(sorted(record.parts.items()))))


def equal(one: VisitorRecord | None, other: VisitorRecord | None) -> bool:
    return one is other or (one is not None and other is not None and _sorted(one) == _sorted(other))


def is_of(found: VisitorRecord, earlier: list[VisitorRecord]) -> bool:
    """True if the record equals a saved one, perhaps with more recorded pieces."""
    head, parts = _sorted(found)
    before = [_sorted(record) for record in earlier]
    return any(head == one for one, _ in before) and all(
        any(its.get(name) == piece for _, its in before) for name, piece in parts.items()
    )
