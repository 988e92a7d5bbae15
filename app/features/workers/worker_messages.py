"""Messages between the listening process and its workers, and between workers. Imports nothing slow."""

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
"""Time between two reports of a worker [s]."""


@dataclass(frozen=True)
class WorkerStart:
    """What a worker serves.

    Attributes:
        options: with the address of the dispatcher's socket.
        given: robots known only to the command line, or None.
        features: each an `app.feature.Feature`.
        run: see `app.web.server.DuetServer`; chosen by the dispatcher.
        jobs: shared pool; chosen by the dispatcher.
        index: from 0; chosen by the dispatcher.
    """

    options: ServeOptions
    given: "GivenAtStart | None" = None
    features: tuple[Any, ...] = ()
    run: str = ""
    jobs: JobAddress | None = None
    index: int = 0


class Ready(NamedTuple):
    """A worker serves. `places`: sessions of all workers at once."""

    places: int


class Failed(NamedTuple):
    """A worker cannot start, for a reason that the user can remove."""

    message: str


class ClientCount(NamedTuple):
    """Browsers of a worker; sent to a worker, of all others."""

    browsers: int


class MakeRoom(NamedTuple):
    """Another worker serves now: waiting tabs must go there. `share`: browsers that a worker keeps."""

    share: int


class LetGo(NamedTuple):
    """A worker has sent a tab away, which is now a new tab."""

    tab: str


class Announced(NamedTuple):
    """A worker has the session of a link's word; sent to a worker, another one has it. See
    `app.settings.JOIN`."""

    word: str


class Load(NamedTuple):
    """Sent every `PULSE`: the fields of a worker's `ServerLoad`. `draws`: whether it draws its pages, however
    slowly."""

    report: tuple[int, ...]
    draws: bool


class LoadElsewhere(NamedTuple):
    reports: tuple[tuple[int, ...], ...]


class StartJobs(NamedTuple):
    """A worker has a job, and the shared pool does not run."""


class ToFirst(NamedTuple):
    """For the process with the shared session; like the next two, passed on unread by the dispatcher."""

    content: bytes


class ForTab(NamedTuple):
    """For the process that has a tab from now on, the same for all tabs of a group."""

    tab: str
    group: str
    content: bytes


class ForAll(NamedTuple):
    """For all processes except the first, also those that start later."""

    content: bytes


class ForgetTabs(NamedTuple):
    """All tabs return to the shared session when they reconnect."""


class Replaced(NamedTuple):
    """With a shared session, a process was replaced: news of the first go to all others, of another to the
    first."""

    worker: int


class Stop(NamedTuple):
    """A worker must save everything and end. `goes_on`: whether a shared session continues on the next
    server."""

    goes_on: bool = False


class WorkerLink:
    """One process's end. All methods may be called from any thread, `received` from one alone.

    Args:
        index: of the process; 0 has the shared session, if any.
        send: to the dispatcher.

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
        """See `ForTab`."""
        self.send(ForTab(tab, group, pickle.dumps(message)))

    def to_all(self, message: object) -> None:
        """See `ForAll`."""
        self.send(ForAll(pickle.dumps(message)))

    def put(self, message: object) -> None:
        """Accept a message for this process; unpacks content from another."""
        self._arrived.append(pickle.loads(message) if isinstance(message, bytes) else message)
        self.wake()

    def received(self) -> list[Any]:
        return [self._arrived.popleft() for _ in range(len(self._arrived))]
