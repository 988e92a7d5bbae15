"""Starts the app: the server, its host (private sessions, or a lecture), and the frame loop."""

import logging
import socket
import threading
import warnings
from functools import partial
from pathlib import Path

from app.classroom.breakout_host import BreakoutHost
from app.classroom.lecture import LectureHost
from app.hosting.app_context import AppContext
from app.hosting.capacity import places, step_seconds
from app.hosting.frame_loop import FrameLoop
from app.hosting.preparation import Preparation
from app.hosting.private_host import PrivateHost
from app.hosting.record_writer import RecordWriter
from app.hosting.session_store import KEEP, SessionStore
from app.hosting.store_file import MOST_BYTES, StoreInUse
from app.hosting.teacher_key import Guesses
from app.hosting.worker_link import WorkerLink
from app.hosting.workload import Workload
from app.lessons.loading import load_lessons, load_notes
from app.page.page_scripts import loading_html, page_assets
from app.runtime.job_pool import JobPool, Jobs
from app.session.input_sources import NO_SOURCES, InputSources
from app.settings import Settings
from app.text.documents import DOCUMENTS, PREFIX, document_page
from app.web.server import DuetServer

log = logging.getLogger("duet.hosts")

# A tab may close in the middle of a frame; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)


Host = PrivateHost | LectureHost | BreakoutHost


class App:
    """A running server with its host and its frame loop; made by `start_app`.

    Args:
        host: what the server shows.
        preparation: of what is slow the first time; None for none.

    Attributes:
        server, url: the context's server, and the address of the page.
    """

    def __init__(self, context: AppContext, host: Host, preparation: Preparation | None) -> None:
        self.context, self.host, self.server, self.url = context, host, context.server, context.server.url
        self._preparation = preparation
        self._loop = FrameLoop(host.frame, context.frame_due, context.workload.note)
        self.server.is_at_work = self._loop.is_at_work
        self._loop.start()
        self._closed = threading.Event()

    def wait(self) -> None:
        """Block until `close` is called or Ctrl+C."""
        while not self._closed.wait(0.5):
            pass

    def close(self, goes_on: bool = False) -> None:
        """Stop the frames and all background jobs, close every connection and release the port.

        Args:
            goes_on: whether a lecture goes on with the next server.
        """
        if self._preparation is not None:
            self._preparation.close()
        self._loop.stop()
        if isinstance(self.host, LectureHost):
            self.host.close(goes_on)
        else:
            self.host.close()
        self.context.jobs.close()
        self.context.sources.close()
        self.server.stop()
        self._closed.set()


def start_app(
    host: str,
    port: int,
    settings: Settings,
    sessions: int | None = None,
    lecture: bool = False,
    key: str | None = None,
    allowed_origins: tuple[str, ...] = (),
    sources: InputSources = NO_SOURCES,
    lessons: Path | None = None,
    watchers: int = 200,
    ahead: bool = False,
    store: Path | None = None,
    keep: float = KEEP,
    most_bytes: int = MOST_BYTES,
    listener: socket.socket | None = None,
    run: str = "",
    jobs: Jobs | None = None,
    link: WorkerLink | None = None,
    loops: int = 1,
) -> App:
    """Start to serve the page.

    Args:
        host, port: address to listen on; port 0 takes any free one.
        settings: of a link without a query.
        sessions: private sessions at once; None for as many as this machine carries.
        lecture: whether all see one stage.
        key: the teacher's, or None.
        allowed_origins: web addresses from which pages may connect besides our own.
        sources: input sources beside the built-in ones; closed with the app.
        lessons: folder of lessons; None for our own.
        watchers: pages that may be open in a lecture at once; the teacher gets in besides.
        ahead: whether to prepare what is slow the first time.
        store: file in which what visitors do outlives the server; None for memory alone.
        keep: how long it is kept after their last visit [s].
        most_bytes: of the file.
        listener, run: see `DuetServer`; given in a worker, where the door holds the lock of the file.
        jobs: runs what takes longer than a frame; None for a pool of this process.
        link: to the other processes of a lecture.
        loops: processes that share the sessions, each with a frame loop and a core of its own.

    Raises:
        PortInUse, BadSetting: see `app.web.server.DuetServer`.
        StoreInUse: another server holds the file.
    """
    auto = sessions is None
    workload = Workload(places(step_seconds(), loops) if auto else sessions, loops, corrected=auto)
    server = DuetServer(
        host,
        port,
        allowed_origins=allowed_origins,
        max_clients=watchers if lecture else workload.places,
        turn_away=Guesses(key).turn_away,
        assets=page_assets(settings.page),
        body=loading_html(),
        documents={PREFIX + name: partial(document_page, name) for name in DOCUMENTS},
        listener=listener,
        run=run,
    )
    server.scene.world_axes.visible = False
    book = load_lessons() if lessons is None else load_lessons(lessons)
    for problem in book.problems:
        log.warning("a lesson was left out: %s", problem)
    # Without a key the notes are not even read.
    notes = {} if key is None else load_notes() if lessons is None else load_notes(lessons)
    try:
        file = None if store is None else RecordWriter(store, keep, most_bytes, owned=listener is None)
    except StoreInUse:
        server.stop()
        raise
    kept = SessionStore(keep, file=file)
    context = AppContext(server, settings, jobs or JobPool(), sources, book, key, notes, kept, workload, host, link)
    preparation = Preparation(book, context.jobs) if ahead else None
    return App(context, _host(context, lecture), preparation)


def _host(context: AppContext, lecture: bool) -> Host:
    if not lecture:
        return PrivateHost(context)
    if context.link is None or context.link.index == 0:
        return LectureHost(context)
    return BreakoutHost(context, context.link)
