"""An absent visitor's session waits for the same link, and the record for any link, both for a while."""

from dataclasses import dataclass

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from app.features.store.session_store import MOST_RECORDS, SessionStore
from app.hosting.parking import AWAY, MOST_SESSIONS
from app.hosting.visitor_record import VisitorRecord
from app.session.session import Session
from app.session.session_state import state_of
from app.settings import OPENED, Settings
from scenes.settings import changed
from tests.app.features.store.test_session_store import tab
from tests.app.stores import find

KEEP = 3.0 * AWAY
LINKS = st.sampled_from(("0.2", "0.3"))
TABS = st.integers(0, 2 * MOST_SESSIONS)
INVALID = st.sampled_from(("", "short", "../../etc", "A" * 20))
RUN = state_of(Session(Settings()))


class ClosedOnce(Session):
    """A session that counts how often it was closed."""

    closed = 0

    def close(self) -> None:
        self.closed += 1
        super().close()


@dataclass(frozen=True)
class Waiting:
    dm: str
    opened: str
    session: ClosedOnce
    since: float


class ResumeMachine(RuleBasedStateMachine):
    """The model: tab → `Waiting`, tab → (record, time), both oldest first, and the sessions in use."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.store = SessionStore(KEEP, lambda: self.now)
        self.waiting: dict[int, Waiting] = {}
        self.records: dict[int, tuple[VisitorRecord, float]] = {}
        self.used: list[ClosedOnce] = []
        self.over: list[ClosedOnce] = []

    def query(self, number: int, dm: str, opened: str = "1") -> dict[str, str]:
        return {"resume": tab(number), "dm": dm, "window": opened * 3, OPENED: opened}

    def forget(self, number: int) -> None:
        if number in self.waiting:
            self.over.append(self.waiting.pop(number).session)

    def tidy(self) -> None:
        """Remove the oldest if they are too old or too many."""
        for number, one in list(self.waiting.items()):
            if self.now - one.since > AWAY or len(self.waiting) > MOST_SESSIONS:
                self.forget(number)
        for number, (_, since) in list(self.records.items()):
            if self.now - since > KEEP or len(self.records) > MOST_RECORDS:
                del self.records[number]

    @rule(number=TABS, dm=LINKS, opened=st.sampled_from("12"))
    def leave(self, number: int, dm: str, opened: str) -> None:
        session = self.used.pop() if self.used else ClosedOnce(Settings())
        self.forget(number)
        self.waiting[number] = Waiting(dm, opened, session, self.now)
        self.tidy()
        self.store.park(self.query(number, dm, opened), session)

    @rule(word=INVALID)
    def leave_without_a_tab(self, word: str) -> None:
        session = ClosedOnce(Settings())
        self.over.append(session)
        self.store.park({"resume": word}, session)
        self.store.save(VisitorRecord({"resume": word}, Settings()))
        assert find(self.store, {"resume": word}) is None and not self.store.alone_has({"resume": word})

    @rule(number=TABS, dm=LINKS, opened=st.sampled_from("12"))
    def return_to_session(self, number: int, dm: str, opened: str) -> None:
        query = self.query(number, dm, opened)
        one = self.waiting.get(number)
        assert self.store.is_reload(query) == (one is not None and one.opened != opened)
        self.tidy()
        one = self.waiting.get(number)
        session = self.store.claim(query)
        if one is None or one.dm != dm:
            assert session is None
            self.forget(number)
        else:
            assert session is one.session
            self.used.append(self.waiting.pop(number).session)
            assert self.store.claim(query) is None, "a session must be claimed only once"

    @rule(number=TABS, dm=st.sampled_from((0.11, 0.22)))
    def save(self, number: int, dm: float) -> None:
        saved = VisitorRecord({"resume": tab(number)}, changed(Settings(), "dm", dm), RUN)
        self.records.pop(number, None)
        self.records[number] = saved, self.now
        self.tidy()
        self.store.save(saved)

    @rule(number=TABS, dm=LINKS)
    def recall(self, number: int, dm: str) -> None:
        query = self.query(number, dm)
        awaited = number in self.waiting and self.waiting[number].dm == dm
        assert self.store.awaits(query) == awaited
        found = find(self.store, query)
        if awaited:
            assert found is None, "the live session waits, so no record is found"
            return
        self.tidy()
        expected, _ = self.records.get(number, (None, 0.0))
        assert (found is None) == (expected is None)
        if found is not None and expected is not None:
            assert found.settings == expected.settings and found.query == expected.query
            newest = list(self.records)[-MOST_SESSIONS:]
            assert found.state is (RUN if number in newest else None), "only the newest must keep their runs"

    @rule(seconds=st.sampled_from((1.0, 0.5 * AWAY, AWAY, AWAY + 0.1, KEEP + 0.1)))
    def time_passes(self, seconds: float) -> None:
        self.now += seconds
        self.tidy()
        self.store.tidy()

    @rule(first=st.integers(0, MOST_SESSIONS))
    def a_class_leaves(self, first: int) -> None:
        for number in range(first, first + MOST_SESSIONS):
            self.save(number, 0.11)
            self.leave(number, "0.2", "1")

    @rule()
    def many_records(self) -> None:
        for number in range(1000, 1000 + MOST_RECORDS):
            self.save(number, 0.22)

    @rule()
    def server_ends(self) -> None:
        self.store.close()
        for number in list(self.waiting):
            self.forget(number)

    @invariant()
    def same_sessions_wait(self) -> None:
        assert [parked.session for parked in self.store.parked.values()] == [
            one.session for one in self.waiting.values()
        ]
        for number in range(2 * MOST_SESSIONS + 1):
            there = number in self.waiting or number in self.records
            assert self.store.alone_has({"resume": tab(number)}) == there

    @invariant()
    def each_session_is_closed_once(self) -> None:
        assert all(one.closed == 1 for one in self.over)
        assert not any(one.closed for one in self.used)
        assert not any(one.session.closed for one in self.waiting.values())

    def teardown(self) -> None:
        self.store.close()
        for session in self.used:
            session.close()


TestResumeMachine = ResumeMachine.TestCase
ResumeMachine.TestCase.settings = settings(max_examples=15, stateful_step_count=20)
