"""The store file of two workers: exactly what was saved is read after any end and any reopening."""

import math
import random
import sqlite3
from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import msgspec
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from app.features.store import record_writer
from app.features.store.record_bytes import record_from_bytes, record_to_bytes, split_record
from app.features.store.record_writer import AGAIN, CLEANING, RecordWriter
from app.features.store.session_store import SessionStore
from app.features.store.store_file import Change, StoreFile, StoreLock, StoreTaken
from app.hosting.visitor_record import VisitorRecord
from app.settings import Settings
from app.web.traffic_limits import remember
from scenes.settings import changed
from tests.app.features.store.store_model import (
    NAMED,
    Kept,
    begun_again,
    equal,
    file_content,
    is_of,
    one_piece_more,
    with_recording,
)
from tests.app.features.store.test_record_store import DAMAGES, DAY, asides, damaged, ruined
from tests.app.features.store.test_session_store import tab
from tests.app.stores import find

MOST_BYTES = 420_000
MOST_WAITING = 3

NAMES = (NAMED, *(tab(number) for number in range(4)))
TABS = st.sampled_from(NAMES)
WORKERS = st.integers(0, 1)
PARTS = st.sampled_from(("marks", "of another release"))
LARGE = 110_000
CONTENTS = st.binary(max_size=8) | st.integers(0, 9).map(lambda seed: random.Random(seed).randbytes(LARGE))
RECORDINGS = st.sampled_from(("study\tfirst", "study\tsecond"))
SEEDS = st.integers(0, 10**6)
TIMES = st.sampled_from((1.0, AGAIN + 1.0, CLEANING + 1.0, 0.5 * DAY, DAY + 1.0, -3600.0, -1500.0 * DAY))

UNKNOWN = {"resume": tab(9)}


class StoreMachine(RuleBasedStateMachine):
    """The model: tab → confirmed record, worker → records that wait while the file is locked."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = TemporaryDirectory()
        self.path = Path(self.folder.name) / "visitors.sqlite"
        self.now = 1.7e9
        self.patch = mock.patch.object(record_writer, "MOST_WAITING", MOST_WAITING)
        self.patch.start()
        self.server = StoreLock(self.path)
        self.kept: dict[str, Kept] = {}
        self.waiting: tuple[dict[str, VisitorRecord], ...] = ({}, {})
        # Tab → worker and present record.
        self.places: dict[str, tuple[int, VisitorRecord]] = {}
        self.earlier: dict[str, list[VisitorRecord]] = {}
        # Tabs with records in a damaged file, which may have unreadable parts.
        self.tattered: set[str] = set()
        self.other: sqlite3.Connection | None = None
        self.workers: tuple[SessionStore, ...] = ()
        self.open()

    # ---- the server --------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        self.workers = tuple(
            SessionStore(
                DAY, file=RecordWriter(self.path, DAY, MOST_BYTES, owned=False, clock=lambda: self.now)
            )
            for _ in range(2)
        )
        self.places.clear()
        self.date_back()

    def date_back(self) -> None:
        """Cleaning treats records saved in the future, before the clock was set back, as saved now."""
        self.kept = {name: replace(kept, saved=min(kept.saved, self.now)) for name, kept in self.kept.items()}

    def close(self) -> None:
        for worker in self.workers:
            worker.close()
        self.end_lock()
        for waiting in self.waiting:
            waiting.clear()

    def file_of(self, worker: int) -> RecordWriter:
        file = self.workers[worker].file
        assert file is not None
        return file

    def settle(self) -> None:
        """Wait until every worker has written its waiting records, or has failed to."""
        for worker, store in enumerate(self.workers):
            file = self.file_of(worker)
            while file.waiting and not file.problem:
                find(store, UNKNOWN)
            # Answers follow the writing of their turn.
            find(store, UNKNOWN)
        for worker, waiting in enumerate(self.waiting):
            file = self.file_of(worker)
            assert self.other is not None or not file.problem
            for name, record in list(waiting.items()):
                if self.other is None:
                    self.confirm(name, record)
                elif name in file.waiting:
                    continue
                else:
                    kept = self.kept.get(name)
                    assert kept is not None and equal(record, kept.record), (
                        "only an unchanged record needs no writing"
                    )
                del waiting[name]

    def confirm(self, name: str, record: VisitorRecord) -> None:
        self.kept[name] = Kept(record, self.now)
        self.earlier.setdefault(name, []).append(record)

    def read(self, worker: int, name: str) -> VisitorRecord | None:
        store = self.workers[worker]
        return store.named(name) if name == NAMED else find(store, {"resume": name})

    # ---- visitors ----------------------------------------------------------------------------------------------------------

    @rule(name=TABS, worker=WORKERS)
    def arrive(self, name: str, worker: int) -> None:
        """A tab gets its record at any worker; while the file is locked, at its last worker."""
        if self.other is not None and name in self.places:
            worker, _ = self.places[name]
        found = self.read(worker, name)
        waits, kept = self.waiting[worker].get(name), self.kept.get(name)
        if waits is not None:
            assert equal(found, waits), "a record that waits to be written must be found"
        elif kept is None or self.now - kept.saved > DAY:
            assert found is None, "no record saved, or too long ago"
        elif found is None:
            assert self.now - kept.earliest > DAY, "a saved record must be found"
        else:
            assert equal(found, kept.record), "the record must be unchanged"
        fresh = VisitorRecord({} if name == NAMED else {"resume": name}, Settings())
        self.places[name] = worker, found or fresh

    def present(self, name: str) -> tuple[int, VisitorRecord]:
        if name not in self.places:
            self.arrive(name, NAMES.index(name) % 2)
        return self.places[name]

    def put(self, name: str, record: VisitorRecord) -> None:
        worker, _ = self.present(name)
        store = self.workers[worker]
        limit = MOST_WAITING if self.file_of(worker).problem else 10**6
        if name == NAMED:
            store.save_named(name, record)
        else:
            store.save(record)
        remember(self.waiting[worker], name, record, limit)
        self.places[name] = worker, record

    @rule(name=TABS)
    def run_goes_on(self, name: str) -> None:
        self.put(name, one_piece_more(self.present(name)[1]))
        self.settle()

    @rule(name=TABS)
    def run_begins_again(self, name: str) -> None:
        self.put(name, begun_again(self.present(name)[1]))
        self.settle()

    @rule(name=TABS, part=PARTS, its=CONTENTS)
    def a_part_is_saved(self, name: str, part: str, its: bytes) -> None:
        _, record = self.present(name)
        parts = {key: value for key, value in record.parts.items() if key != part}
        self.put(name, replace(record, parts={**parts, **({part: its} if its else {})}))
        self.settle()

    @rule(name=TABS, part=RECORDINGS, number=st.none() | st.integers(0, 2))
    def a_recording_is_saved(self, name: str, part: str, number: int | None) -> None:
        self.put(name, with_recording(self.present(name)[1], part, number))
        self.settle()

    @rule(dm=st.sampled_from((0.11, 0.22)))
    def all_save_at_once(self, dm: float) -> None:
        for name in sorted(self.places):
            _, record = self.places[name]
            self.put(name, replace(record, settings=changed(Settings(), "dm", dm)))
            if self.other is not None:
                self.settle()
        self.settle()

    @precondition(lambda self: self.other is None)
    @rule(name=TABS)
    def the_others_fill_the_file(self, name: str) -> None:
        """Any worker deletes the oldest record; its visitor continues."""
        self.run_goes_on(name)
        for other in (one for one in NAMES if one != name):
            _, record = self.present(other)
            large = random.Random(other).randbytes(LARGE)
            self.put(other, replace(record, parts={**record.parts, "large": large}))
            self.settle()
        self.time_passes(CLEANING + 1.0)
        self.the_file_has_what_was_saved_and_nothing_else()
        self.run_goes_on(name)

    @rule(name=st.sampled_from(("", "short", "../../etc", "A" * 20)))
    def a_visitor_without_a_tab_saves(self, name: str) -> None:
        self.workers[0].save(VisitorRecord({"resume": name}, Settings()))
        assert find(self.workers[0], {"resume": name}) is None

    # ---- other programs ----------------------------------------------------------------------------------------------------

    @precondition(lambda self: self.other is None)
    @rule(name=TABS, value=st.integers(0, 9))
    def another_release_saves(self, name: str, value: int) -> None:
        """The other release's record has a field that this release does not know."""
        self.places.pop(name, None)
        kept = self.kept.get(name)
        query = {} if name == NAMED else {"resume": name}
        record = VisitorRecord(query, Settings()) if kept is None else kept.record
        others = {key: part for key, part in record.parts.items() if key != "of its own"}
        head, parts = split_record(replace(record, parts=others))
        plain = record_from_bytes(record_to_bytes(replace(head, state=None)), dict[str, Any])
        stored = {**plain, "of its own": value}
        run = parts.keys() - record.recordings.keys()
        with closing(StoreFile(self.path, 10**9)) as file:
            file.write([Change(name, self.now, record_to_bytes(stored), {}, run)])
        own = {**others, "of its own": msgspec.msgpack.encode(value)}
        self.confirm(name, replace(record, state=None, parts=own))

    @rule()
    def another_server_comes(self) -> None:
        with pytest.raises(StoreTaken):
            RecordWriter(self.path, DAY, MOST_BYTES)

    @precondition(lambda self: self.other is None)
    @rule(name=TABS)
    def another_process_locks_the_file(self, name: str) -> None:
        """A record waits until the file is free; its visitor finds it meanwhile."""
        for worker in range(2):
            self.wait_for_lock(worker, 0)
        self.other = sqlite3.connect(self.path, timeout=60.0, isolation_level=None)
        self.other.execute("BEGIN IMMEDIATE")
        self.run_goes_on(name)

    def wait_for_lock(self, worker: int, milliseconds: int) -> None:
        file = self.file_of(worker).file
        assert file is not None
        file.connection.execute(f"PRAGMA busy_timeout = {milliseconds}")

    def end_lock(self) -> None:
        if self.other is not None:
            self.other.close()
            self.other = None

    @precondition(lambda self: self.other is not None)
    @rule()
    def the_file_is_free_again(self) -> None:
        self.end_lock()
        for worker in range(2):
            self.wait_for_lock(worker, 2000)
        self.time_passes(AGAIN + 1.0)

    # ---- time and endings --------------------------------------------------------------------------------------------------

    @rule(seconds=TIMES)
    def time_passes(self, seconds: float) -> None:
        self.now += seconds
        self.settle()
        if self.other is None:
            self.date_back()
        if self.other is None and seconds > CLEANING:
            late = {name for name, kept in self.kept.items() if self.now - kept.saved > DAY}
            assert not late & file_content(self.path).keys(), "old records must be deleted"

    @rule()
    def server_ends_and_starts(self) -> None:
        self.close()
        self.open()

    @precondition(lambda self: self.other is None)
    @rule(name=TABS)
    def server_ends_while_a_tab_saves(self, name: str) -> None:
        self.put(name, one_piece_more(self.present(name)[1]))
        ((_, record),) = (self.places[name],)
        self.close()
        self.confirm(name, record)
        self.open()

    @precondition(lambda self: self.other is None)
    @rule()
    def server_is_killed(self) -> None:
        """The data that its processes wrote is in the file or in its log."""
        log = self.path.with_name(self.path.name + "-wal")
        left, beside = self.path.read_bytes(), log.read_bytes()
        self.close()
        self.path.write_bytes(left)
        log.write_bytes(beside)
        self.open()

    @precondition(lambda self: self.kept)
    @rule(kind=st.sampled_from(("head", "half", "schema", "unwritable", "newer")))
    def file_cannot_be_used(self, kind: str) -> None:
        """The file is set aside; all records continue, except after a cut file."""
        self.close()
        self.now += CLEANING + 1.0
        ruined(self.path, kind)
        left = self.path.read_bytes()
        self.open()
        assert left in [aside.read_bytes() for aside in asides(self.path)]
        assert all(worker.state.set_aside and not worker.state.problem for worker in self.workers)
        if kind == "half":
            self.take_what_is_left()

    @precondition(lambda self: self.kept)
    @rule(kind=st.sampled_from(DAMAGES), seed=SEEDS)
    def file_is_damaged(self, kind: str, seed: int) -> None:
        """A record equals a saved one or is lost."""
        log = self.path.with_name(self.path.name + "-wal")
        beside = log.read_bytes()
        left = self.path.read_bytes()
        self.close()
        self.now += CLEANING + 1.0
        chance = random.Random(seed)
        if kind == "log cut" and beside and self.other is None:
            self.path.write_bytes(left)
            log.write_bytes(damaged(beside, kind, chance))
        else:
            self.path.write_bytes(damaged(self.path.read_bytes(), kind, chance))
        self.open()
        self.take_what_is_left(whole=kind in ("head", "schema"))

    def take_what_is_left(self, whole: bool = False) -> None:
        """Read every record. `whole`: no record may be damaged."""
        if whole:
            # Opening cleans the file, and may delete old records.
            self.the_file_has_what_was_saved_and_nothing_else()
            for name in self.earlier:
                self.arrive(name, 0)
            return
        for name in self.earlier:
            found = self.read(0, name)
            kept = self.kept.pop(name, None)
            self.tattered.add(name)
            if found is not None:
                assert is_of(found, self.earlier[name]), "the record must equal a saved one"
                self.kept[name] = Kept(found, self.now if kept is None else kept.saved)

    # ---- invariants --------------------------------------------------------------------------------------------------------

    @invariant()
    def the_file_has_what_was_saved_and_nothing_else(self) -> None:
        content = file_content(self.path)
        if self.tattered:
            # No visitor can find a damaged name.
            content = {name: kept for name, kept in content.items() if name in NAMES}
        found = {name: (record, parts) for name, (record, parts) in content.items() if record is not None}
        assert content.keys() - found.keys() <= self.tattered, "only a damaged file has unreadable records"
        assert found.keys() <= self.kept.keys(), "the file has an unknown record"
        gone = {name: self.kept.pop(name) for name in self.kept.keys() - found.keys()}
        self.made_room({name: kept for name, kept in gone.items() if self.now - kept.earliest <= DAY})
        for name, (record, parts) in found.items():
            assert equal(record, self.kept[name].record), f"the record of {name}"
            expected = split_record(record)[1].keys()
            assert parts == expected or (name in self.tattered and parts > expected), (
                "old parts must be deleted"
            )

    def made_room(self, gone: Mapping[str, Kept]) -> None:
        """Check that the file was too large and the oldest records were deleted."""
        if not gone:
            return
        assert self.kept, "the newest must stay"
        # A damaged file may have lost the time of the last save.
        newest = max((kept.earliest for name, kept in gone.items() if name not in self.tattered), default=0.0)
        oldest = min(
            (kept.saved for name, kept in self.kept.items() if name not in self.tattered), default=math.inf
        )
        assert newest <= oldest, "the oldest must be deleted first"
        taken = max(kept.size for kept in gone.values()) + sum(
            kept.size + 8192 for kept in self.kept.values()
        )
        # Unreadable data in a damaged file needs room, too.
        assert self.tattered or taken > MOST_BYTES - 60_000, f"{gone.keys()} were deleted without need"

    @invariant()
    def a_trouble_is_said_while_it_lasts(self) -> None:
        for worker, waiting in enumerate(self.waiting):
            problem = self.workers[worker].state.problem
            assert (problem != "") >= bool(waiting)
            assert self.other is not None or not problem

    def teardown(self) -> None:
        self.close()
        self.server.release()
        self.patch.stop()
        self.folder.cleanup()


TestStoreMachine = StoreMachine.TestCase
StoreMachine.TestCase.settings = settings(max_examples=20, stateful_step_count=25)
