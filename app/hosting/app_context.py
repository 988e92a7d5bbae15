"""What a running app is made of, handed to every host and visitor as one object."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeVar

from app.hosting.opened_feature import OpenedFeature
from app.hosting.parking import Parking
from app.hosting.serve_options import ServeOptions
from app.hosting.server_part import ServerPart
from app.hosting.workload import Workload
from app.page.panel_context import PanelMaker
from app.page.panels.hotkeys import KeyHelp
from app.page.view import View, ViewPart
from app.runtime.job_pool import Jobs
from app.runtime.throttled_log import ThrottledLog
from app.session.late_law import LateLawMaker
from app.web.server import DuetServer

P = TypeVar("P", bound=ServerPart)
T = TypeVar("T")


@dataclass(frozen=True)
class AppContext:
    """The parts that all hosts and visitors share.

    Attributes:
        options: with which the server was started.
        jobs: computes in the background for all sessions.
        law: makes a law that may answer later, for each session.
        store: what visitors who are away left behind.
        workload: what the rounds take, and how many private sessions there may be at once.
        errors: logs what fails in the pages' frames.
        panels: makes the panels that features add to the page of a visitor who operates a session.
        key_help: rows of features for the page's table of keys.
        overlays: makes what features draw on a page that shows a session.
        started_with: objects for hosts and pages, at most one of each type: from who starts the app, see `given`.
        opened: what features have opened for the whole server; closed with it.
        frame_due: set to ask for a frame at once.
        parts: what features keep for the server.
    """

    server: DuetServer
    options: ServeOptions
    jobs: Jobs
    law: LateLawMaker
    store: Parking
    workload: Workload
    errors: ThrottledLog
    panels: tuple[PanelMaker, ...] = ()
    key_help: tuple[KeyHelp, ...] = ()
    overlays: tuple[Callable[[View], ViewPart], ...] = ()
    started_with: tuple[object, ...] = ()
    opened: tuple[OpenedFeature, ...] = ()
    frame_due: threading.Event = field(default_factory=threading.Event)
    parts: list[ServerPart] = field(default_factory=list)

    def given(self, kind: type[T]) -> T | None:
        """The object of a type among `started_with`; None if there is no such object."""
        return next((one for one in self.started_with if isinstance(one, kind)), None)

    def part(self, kind: type[P]) -> P:
        """The server's part of a class.

        Raises:
            LookupError: the server has none; no feature in use adds it.
        """
        for part in self.parts:
            if isinstance(part, kind):
                return part
        raise LookupError(f"no feature of this server adds a {kind.__name__}")

    def wake(self) -> None:
        """Ask for a frame at once; from any thread."""
        self.frame_due.set()

    @contextmanager
    def apart(self, what: str, client_id: int) -> Iterator[None]:
        """Log an exception of one browser's page: the others must not lose a frame. A tab that is just closing has no page any more."""
        try:
            yield
        except Exception as error:
            if client_id in self.server.get_clients():
                self.errors.exception(what, error, client_id)
