"""Guests in worker processes: they reach their host's worker, also after its replacement."""

from contextlib import ExitStack

import pytest

from app.features.second_person.second_place import SecondPlace
from app.hosting.visitor_record import VisitorRecord
from app.session.parts import SessionParts
from app.session.session import Session
from app.settings import JOIN, Settings
from tests.app.features.second_person.test_guests import INVITE, ON_STAGE, came_again, enter, see, word_on
from tests.app.features.store.kept import kept
from tests.app.features.workers.served import Serve
from tests.app.features.workers.test_workers import HOLD, come, pause, wait_for_second_worker, worker_of
from tests.app.page.helpers import click, shown

pytestmark = [pytest.mark.slow, pytest.mark.thorough]

HOST, GUEST_TAB = 10, 11


def word_in(record: VisitorRecord) -> str:
    """Word of the invitation in a record."""
    parts = SessionParts(Session(Settings()))
    parts.restore(record.parts)
    return parts.of(SecondPlace).word


def test_a_guest_reaches_the_hosts_worker_also_after_it_was_killed(serve: Serve) -> None:
    served = serve("--workers", "2", "--sessions", "4")
    with ExitStack() as opened:
        first = opened.enter_context(come(served, 0))
        second = opened.enter_context(come(served, 1))
        wait_for_second_worker(served)
        host = opened.enter_context(come(served, HOST, HOLD))
        # The newest tab is the host; it is not at the first tab's worker.
        place = worker_of(served, host)
        assert place != worker_of(served, first)
        second.close()
        pause(host)
        click(host, INVITE)
        word = word_on(host)
        guest = opened.enter_context(
            served.come(f"{JOIN}={word}&resume={GUEST_TAB:032d}", lambda v: ON_STAGE in shown(v))
        )
        assert worker_of(served, guest) == place
        host.wait_for(
            lambda _: (left := kept(served.store, f"{HOST:032d}")) is not None and word_in(left) == word
        )
        # The worker is killed; the guest reconnects before the host and gets in after the host.
        served.replace(place)
        guest = enter(opened, served.url, word, GUEST_TAB)
        see(guest, "This invitation is not open")
        host = opened.enter_context(come(served, HOST, HOLD))
        guest = came_again(opened, guest, served.url, word, GUEST_TAB)
        see(guest, ON_STAGE)
        see(host, "The second person is here")
        assert word_on(host) == word
        assert worker_of(served, guest) == worker_of(served, host) != place
