"""Records of visitors: kept per tab, for a while, in a limited number; a run continues bit for bit."""

from dataclasses import replace
from typing import Any, NamedTuple

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.features.store.record_bytes import (
    DamagedRecord,
    joined_record,
    record_from_bytes,
    record_to_bytes,
    split_record,
    visitor_from_bytes,
)
from app.hosting.visitor_record import VisitorRecord, part_of, with_part
from app.session.session import Session
from app.session.session_state import go_on_from, state_of
from app.settings import Settings
from scenes.inputs import Recorded
from scenes.rerun import rerun
from scenes.settings import changed
from tests.scenes.helpers import with_values

TAB = "0123456789abcdef0123456789abcdef"


def tab(number: int) -> str:
    return f"{number:016d}"


def session_of(seconds: float = 1.5, **keys: object) -> Session:
    """A session that has run for `seconds`, in parts as if it had been stored in between."""
    session = Session(with_values(Settings(), **keys))
    while session.simulation.time < seconds:
        session.advance(0.05, 60.0)
        state_of(session)
    return session


def record_of(session: Session, number: int = 0) -> VisitorRecord:
    return VisitorRecord({"resume": tab(number)}, session.settings, state_of(session))


def again(record: VisitorRecord) -> VisitorRecord:
    """The record after conversion to bytes and back."""
    head, parts = split_record(record)
    stored = {name: record_from_bytes(record_to_bytes(piece), Recorded) for name, piece in parts.items()}
    return joined_record(visitor_from_bytes(record_to_bytes(head)), stored)


def content(record: VisitorRecord) -> tuple[bytes, dict[str, bytes]]:
    head, parts = split_record(record)
    return record_to_bytes(head), {name: record_to_bytes(piece) for name, piece in parts.items()}


@pytest.fixture(scope="module")
def short() -> Session:
    return session_of(0.6, ghost="unprotected")


WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)


NAMES = st.from_regex(r"[a-z0-9-]{1,12}", fullmatch=True)


@given(
    query=st.dictionaries(NAMES, WORDS, max_size=3),
    stored=st.dictionaries(NAMES, st.binary(max_size=20), max_size=3),
    names=st.lists(st.tuples(NAMES, NAMES).map("\t".join), max_size=2, unique=True),
    dm=st.floats(0.03, 0.3),
)
@settings(max_examples=25, deadline=None)
def test_a_record_is_restored_unchanged(short: Session, query, stored, names, dm) -> None:
    own, piece = changed(Settings(), "dm", dm), state_of(short).run.pieces[0]
    record = VisitorRecord(
        {"resume": tab(1), **query}, own, state_of(short), stored, dict.fromkeys(names, piece)
    )
    back = again(record)
    assert content(back) == content(record)
    assert back.settings == own and back.parts == stored
    assert back.recordings.keys() == set(names) and "key" not in back.query


RUNS = {
    "hold, a ghost": {"ghost": "unprotected"},
    "hold, a slow robot": {"dead": 0.02, "fps": 20.0},
    "ball": {"scene": "ball", "ball": "cross"},
    "master and slave": {"scene": "master_slave"},
    "imitation": {"scene": "imitation", "law": "potential_field"},
}


def test_a_session_in_the_opening_continues_in_it_and_an_older_record_does_not() -> None:
    session = Session(Settings())
    session.hand.source.opens = True
    while session.simulation.time < 1.5:
        session.advance(0.05, 60.0)
    back = again(record_of(session))
    assert back.state is not None and back.state.opening
    other = Session(back.settings)
    list(go_on_from(other, back.state))
    for one in (session, other):
        one.advance(0.05, 60.0)
    assert other.simulation.positions.tobytes() == session.simulation.positions.tobytes()
    head, _ = split_record(record_of(session))
    stored = record_from_bytes(record_to_bytes(head), dict[str, Any])
    del stored["state"]["opening"]
    older = visitor_from_bytes(record_to_bytes(stored))
    assert older.state is not None and not older.state.opening and older.state.source is not None


@pytest.mark.parametrize("history", [0.0, 60.0])
@pytest.mark.parametrize("keys", RUNS.values(), ids=list(RUNS))
def test_a_session_continues_bit_for_bit(keys: dict[str, object], history: float) -> None:
    session = session_of(2.2, **keys)
    session.change("dm", 0.13)
    session.control.halt.set("visitor")
    back = again(record_of(session))
    assert back.state is not None
    other = Session(back.settings)
    list(go_on_from(other, back.state, history))
    logged, kept = other.inputs.window(), session.inputs.window()
    assert (
        other.paused
        and logged is not None
        and kept is not None
        and logged.seconds == pytest.approx(kept.seconds)
    )
    if history:
        assert other.simulation.history.table().tobytes() == session.simulation.history.table().tobytes()
    for one in (session, other):
        one.control.toggle_pause()
        for _ in range(10):
            one.advance(0.05, 60.0)
    pairs = [(session.simulation, other.simulation), (session.ghost, other.ghost)]
    for mine, theirs in [pair for pair in pairs if pair[0] is not None]:
        assert theirs is not None and mine is not None and mine.steps > 500
        assert (mine.steps, mine.time, mine.positions.tobytes()) == (
            theirs.steps,
            theirs.time,
            theirs.positions.tobytes(),
        )
    recorded = other.inputs.window()
    assert recorded is not None and recorded.begin == 0.0 and recorded.steps == other.simulation.steps
    assert rerun(recorded).table[-1].tobytes() == other.simulation.history.table()[-1].tobytes()


def test_pieces_before_a_missing_one_are_dropped_and_damage_is_noticed() -> None:
    session = session_of(1.0)
    record = record_of(session)
    head, parts = split_record(record)
    assert len(parts) > 10
    names = sorted(parts)
    del parts[names[3]]
    back = joined_record(head, parts)
    assert back.state is not None and back.state.run.pieces == tuple(parts[name] for name in names[4:])
    data = record_to_bytes(head)
    for damaged in (
        b"",
        data[:-5],
        data[:9] + bytes([data[9] ^ 1]) + data[10:],
        record_to_bytes({"query": 1}),
    ):
        with pytest.raises(DamagedRecord):
            visitor_from_bytes(damaged)


class Marks(NamedTuple):
    """Example of a feature's data about a visitor."""

    points: int
    names: tuple[str, ...] = ()


def test_a_record_keeps_the_parts_of_features_by_name(caplog: pytest.LogCaptureFixture) -> None:
    plain = VisitorRecord({"resume": TAB}, Settings())
    record = again(with_part(with_part(plain, "marks", Marks(3, ("Ann",))), "other", Marks(1)))
    assert part_of(record, "marks", Marks) == Marks(3, ("Ann",)) and part_of(record, "other", Marks) == Marks(
        1
    )
    assert part_of(record, "none", Marks) is None and caplog.text == ""
    assert part_of(record, "marks", int) is None and "“marks”" in caplog.text
    assert again(with_part(with_part(record, "marks", None), "other", None)) == plain


def test_parts_stored_as_fields_by_an_earlier_release_are_found() -> None:
    plain = VisitorRecord({"resume": TAB}, Settings())
    stored = {**msgspec.to_builtins(plain), "marks": Marks(3), "empty": None}
    del stored["parts"]
    record = visitor_from_bytes(record_to_bytes(stored))
    assert part_of(record, "marks", Marks) == Marks(3) and record.parts.keys() == {"marks"}
    assert replace(record, parts={}) == plain
    # A part of this release has priority over a field of the same name.
    both = {**stored, "parts": with_part(plain, "marks", Marks(5)).parts}
    assert part_of(visitor_from_bytes(record_to_bytes(both)), "marks", Marks) == Marks(5)
