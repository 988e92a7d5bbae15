"""Shared parts of an app."""

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
    """What all hosts and visitors share.

    Attributes:
        panels: makers of panels on operators' pages.
        key_help: features' rows of the table of keys.
        overlays: makers of features' drawings on pages with a session.
        started_with: at most one object of each type.
        frame_due: set to ask for a frame at once.
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
        """Object of this type in `started_with`."""
        return next((one for one in self.started_with if isinstance(one, kind)), None)

    def part(self, kind: type[P]) -> P:
        """Part of this class.

        Raises:
            LookupError: no feature in use adds it.
        """
        for part in self.parts:
            if isinstance(part, kind):
                return part
        raise LookupError(f"no feature of this server adds a {kind.__name__}")

    def wake(self) -> None:
        """Ask for a frame at once, from any thread."""
        self.frame_due.set()

    @contextmanager
    def guarded(self, what: str, client_id: int) -> Iterator[None]:
        """Log an exception of one page, so that the others lose no frame."""
        try:
            yield
        except Exception as error:
            if client_id in self.server.get_clients():
                self.errors.exception(what, error, client_id)
