"""Messages between the dispatcher and its workers. Imports nothing slow."""

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
"""Period of a worker's reports [s]."""


@dataclass(frozen=True)
class WorkerStart:
    """First message to a worker; the dispatcher sets `run`, `jobs` and `index`.

    Attributes:
        options: with the address of the dispatcher's socket.
        given: robots known only to the command line.
        features: each an `app.feature.Feature`.
        index: 0-based.
    """

    options: ServeOptions
    given: "GivenAtStart | None" = None
    features: tuple[Any, ...] = ()
    run: str = ""
    jobs: JobAddress | None = None
    index: int = 0


class Ready(NamedTuple):
    """A worker serves. `places`: sessions of all workers."""

    places: int


class Failed(NamedTuple):
    """A worker cannot start; the user can remove the reason."""

    message: str


class ClientCount(NamedTuple):
    """Browsers of a worker; sent to a worker, of all others."""

    browsers: int


class MakeRoom(NamedTuple):
    """Another worker takes waiting tabs. `share`: browsers that a worker keeps."""

    share: int


class LetGo(NamedTuple):
    """A worker has sent a tab away."""

    tab: str


class Announced(NamedTuple):
    """A worker has the session of a link's word `JOIN`; received: another worker has it."""

    word: str


class Load(NamedTuple):
    """Fields of a worker's `ServerLoad`, every `PULSE`. `draws`: it draws its pages, however slowly."""

    report: tuple[int, ...]
    draws: bool


class LoadElsewhere(NamedTuple):
    reports: tuple[tuple[int, ...], ...]


class StartJobs(NamedTuple):
    """A worker has a job, and the shared pool does not run."""


class ToFirst(NamedTuple):
    """For the process with the shared session; not read by the dispatcher."""

    content: bytes


class ForTab(NamedTuple):
    """For the process that gets a tab, the same for all tabs of a group."""

    tab: str
    group: str
    content: bytes


class ForAll(NamedTuple):
    """For all processes except the first, also later ones."""

    content: bytes


class ForgetTabs(NamedTuple):
    """All tabs return to the shared session when they reconnect."""


class Replaced(NamedTuple):
    """A process was replaced: sent to the first one, or to all others if that was the first."""

    worker: int


class Stop(NamedTuple):
    """Save everything and end. `goes_on`: a shared session continues on the next server."""

    goes_on: bool = False


class WorkerLink:
    """A process's end of the messages. Thread-safe, but only one thread may call `received`.

    Args:
        index: 0 has the shared session, if any.

    Attributes:
        wake: called when something has arrived.
    """

    def __init__(self, index: int, send: Callable[[object], None]) -> None:
        self.index, self.send = index, send
        self.wake: Callable[[], None] = lambda: None
        self._arrived: deque[Any] = deque()

    def to_first(self, message: object) -> None:
        self.send(ToFirst(pickle.dumps(message)))

    def to_tab(self, tab: str, group: str, message: object) -> None:
        self.send(ForTab(tab, group, pickle.dumps(message)))

    def to_all(self, message: object) -> None:
        self.send(ForAll(pickle.dumps(message)))

    def put(self, message: object) -> None:
        """Unpacks content from another process."""
        self._arrived.append(pickle.loads(message) if isinstance(message, bytes) else message)
        self.wake()

    def received(self) -> list[Any]:
        return [self._arrived.popleft() for _ in range(len(self._arrived))]
