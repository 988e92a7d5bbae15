"""Starts the app: the server, its host, and the frame loop."""

import logging
import socket
import threading
import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial

from app.feature import Feature
from app.hosting.app_context import AppContext
from app.hosting.frame_loop import FrameLoop
from app.hosting.host import Host
from app.hosting.preparation import Preparation
from app.hosting.private_host import PrivateHost
from app.hosting.record_writer import RecordWriter
from app.hosting.serve_options import ServeOptions
from app.hosting.session_store import SessionStore
from app.hosting.teacher_key import Guesses, is_teacher
from app.hosting.worker_messages import WorkerLink
from app.hosting.workload import Workload, places, step_seconds
from app.page.page_assets import loading_html, page_assets
from app.runtime.job_pool import JobPool, Jobs
from app.runtime.throttled_log import ThrottledLog
from app.session.input_source import find_input_sources
from app.text.document_list import DOCUMENTS
from app.text.documents import PREFIX, document_page
from app.web.server import DuetServer

log = logging.getLogger("duet.hosts")

# A tab may close in the middle of a frame; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)


class App:
    """A running server with its host and its frame loop; made by `start_app`.

    Args:
        host: what the server shows.
        preparation: of what is slow the first time; None for none.

    Attributes:
        server, url: the context's server, and the address of the page.
        hangs: see `FrameLoop`.
    """

    def __init__(self, context: AppContext, host: Host, preparation: Preparation | None) -> None:
        self.context, self.host, self.server, self.url = context, host, context.server, context.server.url
        self._preparation = preparation
        self._loop = FrameLoop(host.frame, context.frame_due, context.workload.note)
        self.server.is_at_work, self.hangs = self._loop.is_at_work, self._loop.hangs
        self._loop.start()
        self._closed = threading.Event()

    def wait(self) -> None:
        """Block until `close` is called or Ctrl+C."""
        while not self._closed.wait(0.5):
            pass

    def close(self, goes_on: bool = False) -> None:
        """Stop the frames and all background jobs, close every connection and release the port.

        Args:
            goes_on: whether the next server goes on with what this one shows.
        """
        if self._preparation is not None:
            self._preparation.close()
        self._loop.stop()
        self.host.close(goes_on)
        for part in self.context.parts:
            part.close()
        self.context.jobs.close()
        self.context.sources.close()
        self.server.stop()
        self._closed.set()


def start_app(
    options: ServeOptions,
    features: Sequence[Feature],
    listener: socket.socket | None = None,
    run: str = "",
    jobs: Jobs | None = None,
    link: WorkerLink | None = None,
) -> App:
    """Start to serve the page.

    Args:
        features: beside the core; () for the core alone.
        listener, run: see `DuetServer`; given in a worker, where the dispatcher holds the lock of the file.
        jobs: runs what takes longer than a frame; None for a pool of this process.
        link: to the other processes of the server.

    Raises:
        PortInUse, BadSetting: see `app.web.server.DuetServer`.
        BadSetting, BadInputFile, MissingPackage: see `find_input_sources`.
        StoreRefused: another server or program has the file.
    """
    shared, added = options.shared, (one.assets() for one in features if one.assets is not None)
    with ExitStack() as opened:
        sources = find_input_sources(options.bvh, options.camera, options.video, options.pose_model, options.law_file)
        opened.callback(sources.close)
        sessions = places(step_seconds(), options.loops) if options.sessions is None else options.sessions
        workload = Workload(sessions, options.loops, corrected=options.sessions is None)
        server = DuetServer(
            options.host,
            options.port,
            allowed_origins=options.allowed_origins,
            embed_origins=options.embed_origins,
            max_clients=workload.places if shared is None else shared.most_pages,
            delay=Guesses(options.key).delay,
            assets=sum(added, page_assets(options.settings.page, shared is not None)),
            body=loading_html(),
            documents={PREFIX + name: partial(document_page, name) for name in DOCUMENTS},
            listener=listener,
            run=run,
        )
        opened.callback(server.stop)
        server.scene.world_axes.visible = False
        owned = listener is None
        file = None if options.store is None else RecordWriter(options.store, options.keep, options.most_bytes, owned=owned)
        kept = SessionStore(options.keep, file=file)
        server.app_state = lambda: {"store": kept.state._asdict(), **workload.everywhere._asdict()}
        server.may_measure = partial(is_teacher, options.key)
        server.proof = options.proof
        errors = ThrottledLog(log)
        panels = tuple(made for one in reversed(features) if one.panels is not None for made in one.panels())
        keys = tuple(row for one in reversed(features) if one.key_help is not None for row in one.key_help())
        overlays = tuple(made for one in reversed(features) if one.overlays is not None for made in one.overlays())
        context = AppContext(server, options, jobs or JobPool(), sources, kept, workload, errors, panels, keys, overlays, link)
        for feature in reversed(features):
            if feature.server is not None:
                part = feature.server(context)
                opened.callback(part.close)
                context.parts.append(part)
        preparation = Preparation(context.parts, context.jobs) if options.ahead else None
        app = App(context, _host(context, features), preparation)
        opened.pop_all()
    return app


def _host(context: AppContext, features: Sequence[Feature]) -> Host:
    """Return the host of the first feature that has one for these options; else one of private sessions."""
    hosts = (one.host(context) for one in features if one.host is not None)
    found = next((host for host in hosts if host is not None), None)
    return found or PrivateHost(context, [one.joining for one in features if one.joining is not None])
