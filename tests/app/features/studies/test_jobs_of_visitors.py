"""A server's computations for its visitors end with them."""

import multiprocessing

import pytest

from app.features.studies.background_studies import BackgroundStudies
from app.runtime.job_pool import JobPool
from app.session.session import Session
from tests.app.conftest import Join, OpenHouse, ask, live_sessions
from tests.app.runtime.processes import until
from tests.app.runtime.test_job_pool import load
from tests.blocking_client import BlockingClient


def compute_for(session: Session, visitor: BlockingClient) -> None:
    """Request two studies in a session; the second is still running at the end."""

    def move(s: Session) -> None:
        s.change("whatif", True)
        for _ in range(40):
            s.advance(0.05)
        s.change("dm", 0.12)

    ask(session, move)
    visitor.wait_for(lambda _: session.parts.of(BackgroundStudies).questions.what_if is not None)
    answer = session.parts.of(BackgroundStudies).questions.what_if
    assert answer is not None and answer.settings.law.critical_distance == 0.12
    # A visitor who leaves must leave no job behind.
    ask(session, lambda s: s.parts.of(BackgroundStudies).measure_smoothness())


@pytest.mark.thorough
def test_jobs_of_a_visitor_end_with_the_visit(house: OpenHouse, join: Join) -> None:
    jobs = JobPool()
    opened = house(jobs=jobs)
    others = set(multiprocessing.active_children())
    visitor = join(opened)
    until(lambda: live_sessions(opened))
    (session,) = live_sessions(opened).values()
    compute_for(session, visitor)
    visitor.close()
    until(lambda: not live_sessions(opened))
    until(lambda: load(jobs) == (0, 0))
    opened.close()
    assert set(multiprocessing.active_children()) == others
    assert load(jobs)[1] == 0
