"""What a running app is made of, handed to every host and visitor as one object."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from app.hosting.serve_options import ServeOptions
from app.hosting.session_store import SessionStore
from app.hosting.worker_messages import WorkerLink
from app.hosting.workload import Workload
from app.lessons.lesson import LessonBook
from app.lessons.library import Library
from app.page.panel_context import PanelMaker
from app.page.view import View, ViewPart
from app.runtime.job_pool import Jobs
from app.runtime.throttled_log import ThrottledLog
from app.session.input_source import InputSources
from app.web.server import DuetServer


@dataclass(frozen=True)
class AppContext:
    """The parts that all hosts and visitors share.

    Attributes:
        options: with which the server was started.
        jobs: computes in the background for all sessions.
        sources: input sources beside the built-in ones.
        library: of the lessons and of the teacher's notes, which are not read where there is no key.
        store: what visitors who have gone left behind.
        workload: what the rounds take, and how many private sessions there may be at once.
        errors: logs what fails in the pages' frames.
        panels: makes the panels that features add to the page of a visitor who operates a session.
        overlays: makes what features draw on a page that shows a session.
        link: to the other processes of the server; None where there is one process.
        frame_due: set to ask for a frame at once.
    """

    server: DuetServer
    options: ServeOptions
    jobs: Jobs
    sources: InputSources
    library: Library
    store: SessionStore
    workload: Workload
    errors: ThrottledLog
    panels: tuple[PanelMaker, ...] = ()
    overlays: tuple[Callable[[View], ViewPart], ...] = ()
    link: WorkerLink | None = None
    frame_due: threading.Event = field(default_factory=threading.Event)

    @property
    def book(self) -> LessonBook:
        """Return the lessons, in English."""
        return self.library.book

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
