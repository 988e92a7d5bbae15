"""What the processes of a server say to each other: the listening one and its workers. With a shared session, through it, also the first
worker, which has that session, and the others, which have sessions of single tabs. Imports nothing slow."""

import pickle
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from app.features.workers.job_address import JobAddress
from app.hosting.serve_options import ServeOptions

if TYPE_CHECKING:
    from scenes.given_robots import GivenAtStart

PULSE: Final = 2.0
"""Time between two messages of a worker that say whether it is at work [s]."""


@dataclass(frozen=True)
class WorkerStart:
    """What a worker is to serve.

    Attributes:
        options: those of the server, with the address to which the dispatcher's socket is bound.
        given: what only the command line knows of robots; None for nothing.
        features: those of the server, each an `app.feature.Feature`.
        run: see `app.web.server.DuetServer`; chosen by the dispatcher.
        jobs: the pool of jobs that all workers share; chosen by the dispatcher.
        index: of the worker, from 0; chosen by the dispatcher.
    """

    options: ServeOptions
    given: "GivenAtStart | None" = None
    features: tuple[Any, ...] = ()
    run: str = ""
    jobs: JobAddress | None = None
    index: int = 0


class Ready(NamedTuple):
    """A worker serves.

    Attributes:
        places: sessions that all workers have at once.
    """

    places: int


class Failed(NamedTuple):
    """A worker cannot start, for a reason that the user can remove."""

    message: str


class ClientCount(NamedTuple):
    """How many browsers are connected to a worker; or, to a worker, how many to all others."""

    browsers: int


class MakeRoom(NamedTuple):
    """Another worker serves now: tabs that wait for their pages are to go there.

    Attributes:
        share: the browsers that a worker keeps.
    """

    share: int


class LetGo(NamedTuple):
    """A worker has sent a tab away; it is a newcomer again."""

    tab: str


class Announced(NamedTuple):
    """A worker has the session to which the word of a link leads; to a worker, that another one has it. See `app.settings.JOIN`."""

    word: str


class Load(NamedTuple):
    """How busy a worker is, sent every `PULSE`: the fields of its `ServerLoad`. `draws`: whether it draws its pages, however slowly."""

    report: tuple[int, ...]
    draws: bool


class LoadElsewhere(NamedTuple):
    """How busy the other workers are."""

    reports: tuple[tuple[int, ...], ...]


class StartJobs(NamedTuple):
    """A worker has a job, and the shared pool does not run."""


class ToFirst(NamedTuple):
    """For the first process, which has the session that all share; like the next two, opaque to the dispatcher, which passes it on."""

    content: bytes


class ForTab(NamedTuple):
    """For the process that gets a tab from now on, the same for all tabs of a group."""

    tab: str
    group: str
    content: bytes


class ForAll(NamedTuple):
    """For all processes but the first, also for those that start later."""

    content: bytes


class ForgetTabs(NamedTuple):
    """All tabs come to the shared session when they connect again."""


class Replaced(NamedTuple):
    """Beside a shared session another process has been replaced: the first one, to all others; another one, to the first."""

    worker: int


class Stop(NamedTuple):
    """A worker is to save everything and to end. `goes_on`: whether a shared session goes on with the next server."""

    goes_on: bool = False


class WorkerLink:
    """One process's end. All methods may be called from any thread, `received` from one alone.

    Args:
        index: of the process; 0 has the session that all share, if there is one.
        send: sends a message to the dispatcher.

    Attributes:
        send: as given.
        wake: called when something has arrived.
    """

    def __init__(self, index: int, send: Callable[[object], None]) -> None:
        self.index, self.send = index, send
        self.wake: Callable[[], None] = lambda: None
        self._arrived: deque[Any] = deque()

    def to_first(self, message: object) -> None:
        self.send(ToFirst(pickle.dumps(message)))

    def to_tab(self, tab: str, group: str, message: object) -> None:
        """Send a message to the process that gets a tab from now on; see `ForTab`."""
        self.send(ForTab(tab, group, pickle.dumps(message)))

    def to_all(self, message: object) -> None:
        """Send a message to all processes but the first, also to those that start later."""
        self.send(ForAll(pickle.dumps(message)))

    def put(self, message: object) -> None:
        """Take a message for this process; content that another process has packed is unpacked."""
        self._arrived.append(pickle.loads(message) if isinstance(message, bytes) else message)
        self.wake()

    def received(self) -> list[Any]:
        """Messages that have arrived since the last call."""
        return [self._arrived.popleft() for _ in range(len(self._arrived))]
