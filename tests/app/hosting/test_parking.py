"""Live sessions of absent visitors wait for their tab and link, limited in time and number."""

from collections.abc import Iterator

import pytest

from app.hosting.parking import AWAY, MOST_SESSIONS, Parking
from app.hosting.serve_options import ServeOptions
from app.hosting.visitor_record import same_tab
from app.runtime.job_pool import JobPool
from app.session.session import Session
from app.settings import Settings
from app.start import start_app
from tests.app.conftest import ByHand, private_of

TAB = "0123456789abcdef0123456789abcdef"
LINK = {"resume": TAB, "dm": "0.2", "window": "800x600"}


class NotedSession(Session):
    closed = False

    def close(self) -> None:
        self.closed = True


def test_a_parked_session_is_claimed_once_by_its_tab_and_link_in_time() -> None:
    now = 0.0
    parking = Parking(lambda: now)

    def park(query: dict[str, str]) -> NotedSession:
        session = NotedSession(Settings())
        parking.park(query, session)
        return session

    assert AWAY == 600.0
    session = park(LINK)
    now = AWAY
    claimed = parking.claim({**LINK, "window": "390x844"})
    assert claimed is session and not parking.parked and parking.claim(LINK) is None
    session = park(LINK)
    now += AWAY + 0.1
    assert parking.claim(LINK) is None and session.closed, "claimed too late"
    session = park(LINK)
    assert parking.claim({**LINK, "dm": "0.3"}) is None and session.closed, "claimed by another link"
    assert park({"dm": "0.2"}).closed and park({"resume": "short"}).closed and not parking.parked, (
        "parked without a valid tab"
    )
    sessions = []
    for number in range(MOST_SESSIONS + 2):
        now += 1.0
        sessions.append(park({"resume": f"{number:016d}"}))
    assert [one.closed for one in sessions] == [True] * 2 + [False] * MOST_SESSIONS
    again = park({"resume": f"{5:016d}"})
    assert sessions[5].closed and len(parking.parked) == MOST_SESSIONS
    now += AWAY - 5.5
    parking.tidy()
    assert [one.closed for one in sessions] == [True] * 4 + [False, True] + [False] * 4
    parking.close()
    assert not parking.parked and again.closed and all(one.closed for one in sessions)
    assert (
        same_tab(LINK, {**LINK, "window": "1x1"})
        and not same_tab({}, {})
        and not same_tab(LINK, {"resume": TAB})
    )


@pytest.fixture
def bare(jobs: JobPool) -> Iterator[ByHand]:
    """An app without any feature."""
    house = start_app(ServeOptions(sessions=8), jobs=jobs, features=())
    opened = ByHand(house)
    yield opened
    for visitor in opened.visitors:
        visitor.close()
    house.close()


@pytest.mark.slow
def test_a_reconnected_tab_has_its_session_without_any_feature(bare: ByHand) -> None:
    link, visitors = f"n=8&resume={TAB}", private_of(bare).visitors
    page = bare.let_in(link)
    (session,) = (one.session for one in visitors.values())
    session.change("dm", 0.2)
    bare.leave(page)
    bare.frames()
    assert not visitors and bare.house.context.store.alone_has({"resume": TAB})
    bare.let_in(link)
    assert [one.session for one in visitors.values()] == [session]
    for _ in range(32):
        bare.frame()
    steps = session.simulation.steps
    # The old connection is not known to be lost yet: a new session continues from its state.
    bare.let_in(link)
    later = list(visitors.values())[-1].session
    assert later is not session and later.settings == session.settings
    assert later.simulation.steps >= steps > 100
