"""The file in which visitors' records outlive the server: content, limits and faults."""

import errno
import logging
import os
import random
import sqlite3
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.features.store.record_writer import AGAIN, RecordWriter
from app.features.store.session_store import SessionStore
from app.features.store.sqlite_pages import PAGE
from app.features.store.store_file import VERSION, Change, StoreFile, StoreLock, StoreRefused
from app.hosting.visitor_record import VisitorRecord
from app.settings import Settings
from scenes.settings import changed
from tests.app.features.store.test_session_store import content, record_of, session_of, tab
from tests.app.stores import find

DAY = 86_400.0


class Clock:
    def __init__(self) -> None:
        self.now = 1.7e9

    def __call__(self) -> float:
        return self.now


Open = Callable[..., SessionStore]


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "new" / "visitors.sqlite"


@pytest.fixture
def opened(path: Path, clock: Clock) -> Iterator[Open]:
    """`opened()` is a store on the file; it replaces the previous one."""
    stores: list[SessionStore] = []

    def make(most_bytes: int = 50_000_000) -> SessionStore:
        for store in stores:
            store.close()
        stores[:] = [SessionStore(DAY, file=RecordWriter(path, DAY, most_bytes, clock=clock))]
        return stores[0]

    yield make
    for store in stores:
        store.close()


def small(number: int, dm: float = 0.11) -> VisitorRecord:
    return VisitorRecord({"resume": tab(number)}, changed(Settings(), "dm", dm), None)


def test_a_record_outlives_the_server_for_a_day_and_is_private(
    opened: Open, path: Path, clock: Clock
) -> None:
    session = session_of(0.5)
    store = opened()
    store.save(record_of(session, 1))
    store.save(VisitorRecord({"dm": "0.2"}, Settings(), None))
    store.save(VisitorRecord({"resume": "../../etc"}, Settings(), None))
    assert find(store, {"resume": tab(2)}) is None
    clock.now += DAY - 1.0
    store = opened()
    back = find(store, {"resume": tab(1), "lesson": "4"})
    assert back is not None and content(back) == content(record_of(session, 1))
    with sqlite3.connect(path) as file:
        assert file.execute("SELECT tab FROM tabs").fetchall() == [(tab(1),)]
    assert {stat.S_IMODE(one.stat().st_mode) for one in path.parent.iterdir()} == {0o600}
    clock.now += 2.0
    assert find(store, {"resume": tab(1)}) is None
    opened()
    with sqlite3.connect(path) as file:
        assert file.execute(
            "SELECT (SELECT count(*) FROM tabs) + (SELECT count(*) FROM parts)"
        ).fetchone() == (0,)


def test_only_new_parts_are_written_and_old_ones_are_deleted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writes: list[Change] = []
    write = StoreFile.write

    def noted(file: StoreFile, changes: Iterable[Change]) -> None:
        given = list(changes)
        writes.extend(given)
        write(file, given)

    monkeypatch.setattr(StoreFile, "write", noted)
    store = SessionStore(DAY, file=RecordWriter(tmp_path / "store", DAY, 50_000_000))
    session = session_of(0.5)

    def save() -> Change | None:
        writes.clear()
        store.save(record_of(session, 1))
        assert store.file is not None
        # Answers follow the turn's writing; a question for this tab would make the read data the newest.
        while store.file.waiting:
            find(store, {"resume": tab(2)})
        find(store, {"resume": tab(2)})
        return writes[0] if writes else None

    first = save()
    assert first is not None and len(first.parts) > 3
    session.advance(0.05, 60.0)
    second = save()
    assert (
        second is not None and list(second.parts) == [max([*first.parts, *second.parts])] and not second.gone
    )
    assert save() is None
    session.reset()
    third = save()
    assert third is not None and set(third.gone) == {*first.parts, *second.parts} and not third.parts
    store.close()


def test_the_oldest_records_are_deleted_to_make_room(tmp_path: Path) -> None:
    file = StoreFile(tmp_path / "store", 1_000_000)
    for number in range(12):
        file.write([Change(tab(number), 100.0 + number, b"head", {"part": bytes([number]) * 200_000}, ())])
    file.write([Change(tab(0), 200.0, b"head", {}, ())])
    gone = file.clean(204.0, 100.0)
    assert gone == {tab(number) for number in range(1, 9)}
    assert file.read(tab(0)) == (200.0, b"head", {"part": bytes([0]) * 200_000}) and file.names(tab(8)) == []
    assert (tmp_path / "store").stat().st_size <= 1_000_000
    file.close()


def ruined(path: Path, kind: str) -> None:
    content = bytearray(path.read_bytes())
    match kind:
        case "head":
            content[:100] = bytes(100)
        case "half":
            del content[len(content) // 2 :]
        case "schema":
            # The error message contains the invalid text.
            content = content.replace(b"PRIMARY KEY (tab, name)", b"PRIMARY \xffEY (tab, name)")
        case "unwritable":
            content[18] = 3
        case _:
            content[60:64] = (VERSION + 1).to_bytes(4, "big")
    path.write_bytes(content)


def asides(path: Path) -> list[Path]:
    return [
        one
        for one in path.parent.iterdir()
        if ".damaged-20" in one.name and not one.name.endswith(("-wal", "-shm"))
    ]


@pytest.mark.parametrize("kind", ["head", "half", "schema", "unwritable", "newer"])
def test_an_unusable_file_is_renamed_and_named(
    kind: str, opened: Open, path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store = opened()
    store.save(record_of(session_of(0.5), 1))
    store.close()
    ruined(path, kind)
    before = path.read_bytes()
    with caplog.at_level(logging.WARNING):
        store = opened()
    (aside,) = asides(path)
    assert (
        aside.read_bytes() == before and aside.name in caplog.text and store.state == (True, "", aside.name)
    )
    store.save(small(2))
    assert find(store, {"resume": tab(2)}) is not None
    store = opened()
    assert find(store, {"resume": tab(2)}) is not None and find(store, {"resume": tab(1)}) is not None
    assert asides(path) == [aside]


def test_two_files_damaged_within_a_second_are_both_kept(opened: Open, path: Path) -> None:
    before = []
    for number in (1, 2):
        store = opened()
        store.save(small(number))
        store.close()
        ruined(path, "head")
        before.append(path.read_bytes())
        store = opened()
        assert store.state.set_aside == max(asides(path)).name
        store.close()
    assert [one.read_bytes() for one in sorted(asides(path))] == before


def test_a_compressed_damaged_file_beside_a_sound_one_is_not_reported(opened: Open, path: Path) -> None:
    store = opened()
    store.save(small(1))
    store.close()
    path.with_name(f"{path.name}.damaged-20260101-101010.gz").touch()
    store = opened()
    assert find(store, {"resume": tab(1)}) is not None and store.state == (True, "", "")
    assert len(asides(path)) == 1


DAMAGES = ("cut", "log cut", "head", "schema", "rows", "any", "zero")


def damaged(whole: bytes, kind: str, chance: random.Random) -> bytes:
    """The file's bytes with the end cut off, with a block of zeros, or with some wrong bytes."""
    size, found = len(whole), bytearray(whole)
    if kind.endswith("cut"):
        return whole[: chance.randrange(size)]
    if kind == "zero":
        begin = 512 * chance.randrange(size // 512)
        found[begin : begin + PAGE] = bytes(min(PAGE, size - begin))
        return bytes(found)
    begin, end = {"head": (0, 100), "schema": (100, PAGE), "rows": (PAGE, size)}.get(kind, (0, size))
    for _ in range(chance.choice((1, 1, 3, 20))):
        found[chance.randrange(begin, end)] ^= chance.randrange(1, 256)
    return bytes(found)


@pytest.fixture(scope="module")
def records() -> dict[int, VisitorRecord]:
    session = session_of(1.0)
    return {number: record_of(session, number) if number % 4 == 0 else small(number) for number in range(12)}


@pytest.mark.parametrize("kind", DAMAGES)
@pytest.mark.parametrize("seed", range(8))
def test_after_any_damage_saving_continues_and_intact_records_are_found(
    kind: str, seed: int, records: dict[int, VisitorRecord], opened: Open, path: Path
) -> None:
    log = path.with_name(path.name + "-wal")
    store = opened()
    for record in records.values():
        store.save(record)
    if kind == "log cut":
        # As after a kill: everything is still in the log.
        find(store, {"resume": tab(0)})
        left, beside = path.read_bytes(), log.read_bytes()
        store.close()
        path.write_bytes(left)
        log.write_bytes(damaged(beside, kind, random.Random(seed)))
    else:
        store.close()
        left = damaged(path.read_bytes(), kind, random.Random(f"{kind} {seed}"))
        path.write_bytes(left)
    store = opened()
    back = {
        number: found for number in records if (found := find(store, {"resume": tab(number)})) is not None
    }
    heads = {number: content(record)[0] for number, record in records.items()}
    assert all(content(found)[0] == heads[number] for number, found in back.items())
    if kind == "cut":
        assert {number for number, head in heads.items() if head in left} == back.keys()
    elif kind in ("head", "schema"):
        assert back.keys() == records.keys()
    elif kind in ("rows", "zero"):
        assert len(back) >= 6
    store.save(small(99))
    store = opened()
    assert find(store, {"resume": tab(99)}) is not None and not store.state.problem
    assert all(find(store, {"resume": tab(number)}) is not None for number in back)


def test_devices_folders_and_foreign_files_are_refused_as_a_store(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, foreign, folder, pipe = (tmp_path / name for name in ("text", "foreign", "folder", "pipe"))
    text.write_text("CREATE TABLE tabs (tab TEXT PRIMARY KEY\n" * 400)
    with closing(sqlite3.connect(foreign)) as file:
        file.execute("CREATE TABLE mine (word TEXT)")
    folder.mkdir()
    os.mkfifo(pipe)
    for path in (text, foreign, folder, pipe, Path(os.devnull)):
        before = path.stat()
        assert main(["serve", "--no-open", "--port", "0", "--store", str(path)]) == 2
        line = capsys.readouterr().err
        assert line.count("\n") == 1 and str(path) in line and "--store" in line
        assert (path.stat().st_mode, path.stat().st_mtime_ns) == (before.st_mode, before.st_mtime_ns)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["folder", "foreign", "pipe", "text"]


def test_the_mode_of_a_file_is_kept(path: Path) -> None:
    StoreFile(path, 10**9).close()
    path.chmod(0o640)
    StoreFile(path, 10**9).close()
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_full_disk_is_reported_and_saving_resumes_when_there_is_room(
    path: Path, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    writer = RecordWriter(path, DAY, 50_000_000, clock=clock)
    store, session = SessionStore(DAY, file=writer), session_of(1.0)

    def wait(condition: Callable[[], object]) -> None:
        while not condition():
            find(store, {"resume": tab(9)})

    store.save(small(3))
    wait(lambda: not writer.waiting)
    assert writer.file is not None
    file = writer.file.connection
    file.execute("PRAGMA max_page_count = 1")
    with caplog.at_level(logging.INFO):
        store.save(record_of(session, 1))
        wait(lambda: store.state.problem)
        assert "full" in store.state.problem
        # Sessions continue: waiting records are found,
        assert find(store, {"resume": tab(1)}) is not None
        # and so are written ones.
        assert find(store, {"resume": tab(3)}) is not None
        file.execute("PRAGMA max_page_count = 1000000")
        clock.now += AGAIN + 1.0
        wait(lambda: not store.state.problem)
    assert caplog.text.count("cannot be written") == 1 and "again" in caplog.text
    store.close()
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 50_000_000, clock=clock))
    assert find(store, {"resume": tab(1)}) is not None
    store.close()


def test_a_record_unreadable_on_arrival_is_not_overwritten(
    opened: Open, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: StoreFile) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    opened().save(small(1))
    with monkeypatch.context() as patch:
        patch.setattr(StoreFile, "_prepare", full)
        store = opened()
        for number in (1, 2):
            assert find(store, {"resume": tab(number)}) is None
            store.save(small(number, 0.2))
        assert store.state.problem == "No space left on device"
    clock.now += AGAIN + 1.0
    store = opened()
    found = [find(store, {"resume": tab(number)}) for number in (1, 2)]
    assert [record and record.settings.run.law.critical_distance for record in found] == [0.11, 0.2]
    # After it has been read, the visitor may overwrite it.
    store.save(small(1, 0.3))
    store = opened()
    again = find(store, {"resume": tab(1)})
    assert again is not None and again.settings.run.law.critical_distance == 0.3


def test_two_servers_do_not_share_a_file(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    dispatcher = StoreLock(path)
    with pytest.raises(StoreRefused, match=r"--store other\.sqlite"):
        RecordWriter(path, DAY, 1_000_000)
    assert main(["serve", "--no-open", "--port", "0", "--store", str(path)]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "--store other.sqlite" in line and str(path) in line
    dispatcher.release()
    RecordWriter(path, DAY, 1_000_000).close()


def test_a_record_deleted_by_another_worker_is_written_again_completely(path: Path, clock: Clock) -> None:
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 50_000_000, owned=False, clock=clock))
    session = session_of(0.3)
    assert find(store, {"resume": tab(1)}) is None
    store.save(record_of(session, 1))
    find(store, {"resume": tab(2)})
    with closing(StoreFile(path, 0)) as other:
        assert other.clean(clock.now, DAY) == {tab(1)}
    session.advance(0.05, 60.0)
    record = record_of(session, 1)
    store.save(record)
    store.close()
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 50_000_000, clock=clock))
    found = find(store, {"resume": tab(1)})
    assert found is not None and content(found) == content(record)
    store.close()


def test_workers_that_find_a_damaged_file_continue_in_one_new_file(path: Path, clock: Clock) -> None:
    StoreFile(path, 10**9).close()
    ruined(path, "newer")
    writers = [RecordWriter(path, DAY, 50_000_000, owned=False, clock=clock) for _ in range(2)]
    # The file is also renamed by hand while both have it open.
    path.rename(path.with_name("renamed"))
    stores = [SessionStore(DAY, file=writer) for writer in writers]
    for number, store in enumerate(stores):
        store.save(small(number))
        store.close()
    assert len(asides(path)) == 1
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 50_000_000, clock=clock))
    assert all(find(store, {"resume": tab(number)}) for number in range(2))
    store.close()
