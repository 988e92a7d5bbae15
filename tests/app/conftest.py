"""Apps and visitors that are closed at the end, and questions to a session between two frames."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

import pytest

from app.features import FEATURES
from app.hosting.private_host import PrivateHost
from app.hosting.serve_options import ServeOptions
from app.hosting.visitor import Visitor
from app.i18n.speaking import set_language
from app.runtime.job_pool import JobPool
from app.session import run_control
from app.session.session import Session
from app.settings import Settings
from app.start import App, start_app
from tests.app.posted_call import post_call
from tests.app.runtime.processes import until
from tests.app.served import has_arms
from tests.blocking_client import BlockingClient

T = TypeVar("T")
FRAME = 1.0 / 32.0
HAND, ELBOW = "/gizmo/hand", "/gizmo/elbow"


def live_sessions(house: App) -> dict[int, Session]:
    """Sessions of an app by client id; −1 is the only shared session of a host."""
    shared = getattr(house.host, "session", None)
    if isinstance(shared, Session):
        return {-1: shared}
    while True:
        # The frame thread may add a session during the iteration.
        with suppress(RuntimeError):
            return {number: visitor.session for number, visitor in private_of(house).visitors.items()}


def private_of(house: "App | ByHand") -> PrivateHost:
    assert isinstance(house.host, PrivateHost)
    return house.host


def visitor_of(house: "App | ByHand") -> Visitor:
    """The only visitor."""
    (visitor,) = private_of(house).visitors.values()
    return visitor


def ask(session: Session, question: Callable[[Session], T], timeout: float = 60.0) -> T:
    """Answer to a question, evaluated in the session's thread between two frames."""
    answer: Future[T] = Future()

    def reply() -> None:
        try:
            answer.set_result(question(session))
        except BaseException as error:
            answer.set_exception(error)

    post_call(session, reply)
    return answer.result(timeout)


@dataclass(frozen=True)
class Guest:
    """A visitor without a browser, with its session on the server."""

    visitor: BlockingClient
    session: Session
    number: int

    def ask(self, question: Callable[[Session], T]) -> T:
        return ask(self.session, question)

    def wait(self, predicate: Callable[[Session], object], timeout: float = 60.0) -> None:
        """Wait until `predicate` holds. Only for single attributes of the session, else use `ask`."""
        self.visitor.wait_for(lambda _: predicate(self.session), timeout)

    def run_on(self, seconds: float, timeout: float = 60.0) -> None:
        """Wait until `seconds` more have been simulated."""
        until = self.session.simulation.time + seconds
        self.wait(lambda s: s.simulation.time >= until, timeout)


@pytest.fixture(autouse=True)
def english() -> Iterator[None]:
    """Every test begins in English."""
    yield
    set_language("en")


@pytest.fixture
def fast_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps take no measured time, also on a busy machine."""
    monkeypatch.setattr(run_control, "perf_counter", lambda: 0.0)


OpenHouse = Callable[..., App]
Arrive = Callable[..., Guest]
Join = Callable[..., BlockingClient]


class LastingPool(JobPool):
    """Pool that keeps its processes for the next app, as they take a second to start."""

    def close(self) -> None:
        with self._lock:
            for job in [*self._waiting, *self._running.values()]:
                self._drop(job)


@pytest.fixture(scope="module")
def jobs() -> Iterator[JobPool]:
    pool = LastingPool()
    yield pool
    JobPool.close(pool)


def _opener(request: pytest.FixtureRequest, pool: JobPool) -> OpenHouse:
    def make(
        settings: Settings | None = None,
        started_with: Sequence[object] = (),
        sessions: int | None = 24,
        jobs: JobPool = pool,
        **options: Any,
    ) -> App:
        given = ServeOptions(settings=settings or Settings(), sessions=sessions, **options)
        opened = start_app(given, jobs=jobs, started_with=started_with, features=FEATURES)
        request.addfinalizer(opened.close)
        return opened

    return make


@pytest.fixture
def house(request: pytest.FixtureRequest, jobs: JobPool) -> OpenHouse:
    """`house(settings, sessions=…, features=…, key=…)` opens an app with fixed places."""
    return _opener(request, jobs)


@pytest.fixture(scope="module")
def lasting_house(request: pytest.FixtureRequest, jobs: JobPool) -> OpenHouse:
    """`house` for all tests of a file."""
    return _opener(request, jobs)


@pytest.fixture
def join(request: pytest.FixtureRequest) -> Join:
    """`join(house, query="dm=0.1")` is a visitor who sees the arms or was disconnected before."""

    def make(house: App, query: str = "", **options: Any) -> BlockingClient:
        visitor = BlockingClient(house.url, query=query, **options)
        request.addfinalizer(visitor.close)
        visitor.wait_for(lambda v: v.closed or has_arms(v))
        return visitor

    return make


@pytest.fixture
def arrive(join: Join) -> Arrive:
    """`arrive(house, query="dm=0.1")` is a visitor with a private session and all its controls."""

    def make(house: App, query: str = "") -> Guest:
        visitor = join(house, query)
        # A lesson may move the arms, so that nothing can be dragged.
        visitor.wait_for(
            lambda v: len(v.mirror.commands) >= 14 and (v.mirror.grabbable or "lesson=" in query)
        )
        if "gizmo=1" in query:
            visitor.wait_for(lambda v: HAND in v.mirror.nodes)
        number = next(int(node["owner"]) for node in list(visitor.mirror.nodes.values()) if node.get("owner"))
        visitor.wait_for(lambda _: number in live_sessions(house))
        return Guest(visitor, live_sessions(house)[number], number)

    return make


class ByHand:
    """An app without a frame loop: the test makes every frame."""

    def __init__(self, house: App) -> None:
        house.loop.stop()
        # On a busy machine the first frame may take longer than `stop` waits.
        house.loop.thread.join(60.0)
        assert not house.loop.thread.is_alive()
        self.house, self.host, self.now = house, house.host, 0.0
        self.visitors: list[BlockingClient] = []

    def frame(self) -> None:
        self.now += FRAME
        self.host.frame(self.now, FRAME)
        self.house.context.workload.note(0.0, FRAME)

    def come(self, query: str = "") -> BlockingClient:
        """A connected browser, known to the next frame."""
        before = self.house.server.get_clients().keys()
        self.visitors.append(BlockingClient(self.house.url, query=query))
        self.visitors[-1].wait_for(lambda _: self.house.server.get_clients().keys() - before)
        return self.visitors[-1]

    def leave(self, visitor: BlockingClient) -> None:
        """Disconnect a browser; the next frame knows it."""
        before = self.house.server.get_clients().keys()
        visitor.close()
        until(lambda: before - self.house.server.get_clients().keys())

    def frames(self) -> None:
        self.frame()
        while self.host.admission.busy:
            self.frame()
        self.frame()

    def let_in(self, query: str = "") -> BlockingClient:
        visitor = self.come(query)
        self.frames()
        visitor.wait_for(has_arms)
        return visitor


Made = Callable[..., ByHand]


@pytest.fixture
def by_hand(house: OpenHouse, request: pytest.FixtureRequest) -> Made:
    def make(**options: Any) -> ByHand:
        one = ByHand(house(**options))
        request.addfinalizer(lambda: [visitor.close() for visitor in one.visitors])
        return one

    return make
