"""The file in which visitors' records outlive the server: what comes back from it, its bounds, and what may happen to it."""

import logging
import sqlite3
import stat
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.cli.main import main
from app.hosting.record_bytes import DamagedRecord, joined, packed, split, unpacked
from app.hosting.record_writer import AGAIN, RecordWriter
from app.hosting.resume import open_link, run_again
from app.hosting.session_store import SessionStore
from app.hosting.store_file import VERSION, Change, StoreFile, StoreInUse, StoreLock
from app.hosting.visitor_record import VisitorRecord, tab_id
from app.lessons.loading import load_lessons
from app.lessons.phases import Phase
from app.lessons.session.lesson_actions import Choose, StartOrPause
from app.lessons.session.lesson_session import LessonSession
from app.lessons.session.saved import SavedLesson
from app.session.frame import make_frame
from app.session.session import Session
from app.settings import Settings
from scenes.inputs import Recorded, RecordedPerson
from scenes.rerun import rerun
from scenes.settings import changed
from tests.app.stores import find

DAY = 86_400.0


def tab(number: int) -> str:
    return f"{number:016d}"


def session_of(seconds: float = 1.5, **keys: object) -> Session:
    """A session that has run so long, in parts as if it had been stored in between."""
    tree = Settings()
    for key, value in keys.items():
        tree = changed(tree, key, value)
    session = Session(tree)
    while session.simulation.time < seconds:
        session.advance(0.05, 60.0)
        session.state()
    return session


def record_of(session: Session, number: int = 0, lessons: SavedLesson | None = None) -> VisitorRecord:
    return VisitorRecord({"resume": tab(number)}, session.settings, lessons, session.state())


def again(record: VisitorRecord) -> VisitorRecord:
    """The record after a way through its bytes."""
    head, parts = split(record)
    stored = {name: unpacked(packed(piece), Recorded) for name, piece in parts.items()}
    return joined(unpacked(packed(head), VisitorRecord), stored)


def content(record: VisitorRecord) -> tuple[bytes, dict[str, bytes]]:
    head, parts = split(record)
    return packed(head), {name: packed(piece) for name, piece in parts.items()}


@pytest.fixture(scope="module")
def short() -> Session:
    return session_of(0.6, ghost="unprotected")


WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
NAMES = st.from_regex(r"[a-z0-9-]{1,12}", fullmatch=True)
STEPS = st.tuples(NAMES, NAMES)


@given(
    query=st.dictionaries(NAMES, WORDS, max_size=3),
    progress=WORDS,
    said=st.dictionaries(STEPS, st.lists(st.none() | st.floats(allow_nan=False), max_size=3).map(tuple), max_size=3),
    names=st.lists(STEPS, max_size=2, unique=True),
    dm=st.floats(0.03, 0.3),
    flags=st.tuples(*[st.booleans()] * 3),
)
@settings(max_examples=25, deadline=None)
def test_a_record_comes_back_as_it_was(short: Session, query, progress, said, names, dm, flags) -> None:
    own, piece = changed(Settings(), "dm", dm), short.state().run.pieces[0]
    lessons = SavedLesson(
        progress,
        own,
        flags[0],
        dict.fromkeys(names, piece),
        own if flags[1] else None,
        {name: RecordedPerson(piece) for name, _ in names},
        said,
        flags[2],
    )
    record = VisitorRecord({"resume": tab(1), **query}, own, lessons, short.state())
    back = again(record)
    assert content(back) == content(record)
    assert back.settings == own and back.lessons is not None
    assert replace(back.lessons, seen={}, kept={}) == replace(lessons, seen={}, kept={})
    assert back.lessons.seen.keys() == set(names) and "key" not in back.query


RUNS = {
    "hold, a ghost": {"ghost": "unprotected"},
    "hold, a slow robot": {"dead": 0.02, "fps": 20.0},
    "ball": {"scene": "ball", "ball": "cross"},
    "master and slave": {"scene": "master_slave"},
    "imitation": {"scene": "imitation", "law": "potential_field"},
}


@pytest.mark.parametrize("history", [0.0, 60.0])
@pytest.mark.parametrize("keys", RUNS.values(), ids=list(RUNS))
def test_a_session_goes_on_to_the_same_bits(keys: dict[str, object], history: float) -> None:
    session = session_of(2.2, **keys)
    session.change("dm", 0.13)
    session.halt.set("visitor")
    back = again(record_of(session))
    assert back.state is not None
    other = Session(back.settings)
    list(other.go_on_from(back.state, history))
    assert other.paused and other.inputs.seconds == pytest.approx(session.inputs.seconds)
    if history:
        assert other.simulation.history.table().tobytes() == session.simulation.history.table().tobytes()
    for one in (session, other):
        one.toggle_pause()
        for _ in range(10):
            one.advance(0.05, 60.0)
    pairs = [(session.simulation, other.simulation), (session.ghost, other.ghost)]
    for mine, theirs in [pair for pair in pairs if pair[0] is not None]:
        assert theirs is not None and mine is not None and mine.steps > 500
        assert (mine.steps, mine.time, mine.positions.tobytes()) == (theirs.steps, theirs.time, theirs.positions.tobytes())
    recorded = other.recorded()
    assert recorded is not None and recorded.begin == 0.0 and recorded.steps == other.simulation.steps
    assert rerun(recorded).table[-1].tobytes() == other.simulation.history.table()[-1].tobytes()


def test_where_a_piece_is_missing_only_the_newer_ones_count_and_what_is_damaged_is_noticed() -> None:
    session = session_of(1.0)
    record = record_of(session)
    head, parts = split(record)
    assert len(parts) > 10
    names = sorted(parts)
    del parts[names[3]]
    back = joined(head, parts)
    assert back.state is not None and back.state.run.pieces == tuple(parts[name] for name in names[4:])
    data = packed(head)
    for damaged in (b"", data[:-5], data[:9] + bytes([data[9] ^ 1]) + data[10:], packed({"query": 1})):
        with pytest.raises(DamagedRecord):
            unpacked(damaged, VisitorRecord)


# ---- the file ------------------------------------------------------------------------------------------------------------------


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
    """`opened()` is a store with the file, which replaces the one before."""
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


def test_a_record_outlives_the_server_for_a_day_and_belongs_to_the_user_alone(opened: Open, path: Path, clock: Clock) -> None:
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
        assert file.execute("SELECT (SELECT count(*) FROM tabs) + (SELECT count(*) FROM parts)").fetchone() == (0,)


def test_only_what_is_new_is_written_and_what_is_over_is_deleted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    writes: list[Change] = []
    write = StoreFile.write
    monkeypatch.setattr(StoreFile, "write", lambda self, changes: [writes.extend(changes), write(self, changes)])
    store = SessionStore(DAY, file=RecordWriter(tmp_path / "store", DAY, 50_000_000))
    session = session_of(0.5)

    def save() -> Change | None:
        writes.clear()
        store.save(record_of(session, 1))
        assert store._file is not None
        # A question is answered after the writing of its turn; the tab's own would make what was read the newest.
        while store._file._waiting:
            find(store, {"resume": tab(2)})
        find(store, {"resume": tab(2)})
        return writes[0] if writes else None

    first = save()
    assert first is not None and first.head is not None and len(first.parts) > 3
    session.advance(0.05, 60.0)
    second = save()
    assert second is not None and list(second.parts) == [max([*first.parts, *second.parts])] and not second.gone
    assert save() is None
    session.reset()
    third = save()
    assert third is not None and set(third.gone) == {*first.parts, *second.parts} and not third.parts
    store.close()


def test_the_oldest_make_room(tmp_path: Path) -> None:
    file = StoreFile(tmp_path / "store", 1_000_000)
    for number in range(12):
        file.write([Change(tab(number), 100.0 + number, b"head", {"part": bytes([number]) * 200_000}, ())])
    file.write([Change(tab(0), 200.0, None, {}, ())])
    gone = file.clean(104.0)
    assert gone == {tab(number) for number in range(1, 9)}
    assert file.read(tab(0)) == (200.0, b"head", {"part": bytes([0]) * 200_000}) and file.names(tab(8)) == []
    assert (tmp_path / "store").stat().st_size <= 1_000_000
    file.close()


def ruined(path: Path, kind: str) -> None:
    match kind:
        case "text":
            path.write_bytes(b"no database, but a text of some length" * 40)
        case "half":
            path.write_bytes(path.read_bytes()[:9_000])
        case "foreign":
            path.unlink()
            with sqlite3.connect(path) as file:
                file.execute("CREATE TABLE mine (word TEXT)")
        case _:
            with sqlite3.connect(path) as file:
                file.execute(f"PRAGMA user_version = {VERSION + 1}")


@pytest.mark.parametrize("kind", ["text", "half", "foreign", "newer"])
def test_a_file_that_cannot_be_used_is_renamed_and_named(
    kind: str, opened: Open, path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store = opened()
    store.save(record_of(session_of(0.5), 1))
    store.close()
    ruined(path, kind)
    before = path.read_bytes()
    with caplog.at_level(logging.WARNING):
        store = opened()
    (aside,) = [one for one in path.parent.iterdir() if ".damaged-20" in one.name and not one.name.endswith(("-wal", "-shm"))]
    assert aside.read_bytes() == before and aside.name in caplog.text and not store.problem
    store.save(small(2))
    assert find(store, {"resume": tab(2)}) is not None and find(store, {"resume": tab(1)}) is None
    store = opened()
    assert find(store, {"resume": tab(2)}) is not None


def test_a_full_disk_is_said_and_saving_goes_on_when_there_is_room(
    path: Path, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    writer = RecordWriter(path, DAY, 50_000_000, clock=clock)
    store, session = SessionStore(DAY, file=writer), session_of(1.0)

    def wait(condition: Callable[[], object]) -> None:
        while not condition():
            find(store, {"resume": tab(9)})

    assert writer._file is not None
    writer._file.connection.execute("PRAGMA max_page_count = 1")
    with caplog.at_level(logging.INFO):
        store.save(record_of(session, 1))
        wait(lambda: store.problem)
        assert "full" in store.problem
        # Sessions live on: what waits is found.
        assert find(store, {"resume": tab(1)}) is not None
        clock.now += AGAIN + 1.0
        wait(lambda: not store.problem)
    assert caplog.text.count("cannot be written") == 1 and "again" in caplog.text
    store.close()
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 50_000_000, clock=clock))
    assert find(store, {"resume": tab(1)}) is not None
    store.close()


def test_a_place_that_cannot_be_written_is_no_reason_not_to_start(tmp_path: Path, clock: Clock) -> None:
    (tmp_path / "file").write_text("")
    store = SessionStore(DAY, file=RecordWriter(tmp_path / "file" / "store", DAY, 1_000_000, clock=clock))
    assert store.problem
    store.save(small(1))
    assert find(store, {"resume": tab(1)}) is not None
    store.close()


def test_two_servers_do_not_share_a_file_but_the_workers_of_one_do(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    door = StoreLock(path)
    with pytest.raises(StoreInUse, match=r"--store other\.sqlite"):
        RecordWriter(path, DAY, 1_000_000)
    assert main(["serve", "--no-open", "--port", "0", "--store", str(path)]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "--store other.sqlite" in line and str(path) in line
    workers = [SessionStore(DAY, file=RecordWriter(path, DAY, 1_000_000, owned=False)) for _ in range(2)]
    for number, worker in enumerate(workers):
        worker.save(small(number))
        worker.close()
    door.release()
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 1_000_000))
    assert all(find(store, {"resume": tab(number)}) for number in range(2))
    store.close()


def test_workers_that_find_a_damaged_file_go_on_in_one_new_file(path: Path, clock: Clock) -> None:
    StoreFile(path, 10**9).close()
    ruined(path, "text")
    writers = [RecordWriter(path, DAY, 50_000_000, owned=False, clock=clock) for _ in range(2)]
    # One more is renamed by hand while both have it open.
    path.rename(path.with_name("renamed"))
    stores = [SessionStore(DAY, file=writer) for writer in writers]
    for number, store in enumerate(stores):
        store.save(small(number))
        store.close()
    assert (
        len([one for one in path.parent.iterdir() if ".damaged-20" in one.name and not one.name.endswith(("-wal", "-shm"))]) == 1
    )
    store = SessionStore(DAY, file=RecordWriter(path, DAY, 50_000_000, clock=clock))
    assert all(find(store, {"resume": tab(number)}) for number in range(2))
    store.close()


def test_only_a_tab_has_a_name() -> None:
    assert tab_id({"resume": tab(1)}) == tab(1) and tab_id({"resume": "short"}) is tab_id({}) is None


@pytest.mark.parametrize("ghost", ["off", "unprotected"])
def test_a_lessons_run_that_breaks_off_comes_to_the_same_outcome(ghost: str) -> None:
    book, link = load_lessons(), {"resume": tab(1), "lesson": "3", "step": "2"}

    def run(session: Session, lessons: LessonSession, until: Callable[[], bool]) -> None:
        while not until():
            make_frame(session, lessons.decide, 0.0, 0.05, 60.0)

    session = Session(Settings())
    lessons = LessonSession(session, book)
    open_link(lessons, link, None)
    lessons.act(Choose(1))
    session.change("ghost", ghost)
    lessons.act(StartOrPause())
    run(session, lessons, lambda: session.simulation.time > 1.0)
    record = again(VisitorRecord(link, session.settings, lessons.saved(), session.state()))
    other = Session(record.settings)
    back = LessonSession(other, book)
    assert open_link(back, link, record) == ()
    list(run_again(other, back, record))
    assert other.simulation.time == session.simulation.time and not other.paused
    for one, way in ((session, lessons), (other, back)):
        run(one, way, lambda way=way: way.walk.phase is Phase.OBSERVE)
    assert back.walk.done.outcome == lessons.walk.done.outcome is not None
    assert other.simulation.positions.tobytes() == session.simulation.positions.tobytes()
    # Once measured, it is not measured again.
    record = again(VisitorRecord(link, other.settings, back.saved(), other.state()))
    third = Session(record.settings)
    last = LessonSession(third, book)
    open_link(last, link, record)
    list(run_again(third, last, record))
    assert record.lessons is not None and record.lessons.measured and third.paused
    assert (last.walk.phase, last.walk.to_json()) == (Phase.OBSERVE, back.walk.to_json())
