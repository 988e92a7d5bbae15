"""Starts the app: server, host and frame loop."""

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
from app.hosting.joining_pages import Joining
from app.hosting.opened_feature import OpenedFeature
from app.hosting.parking import Parking
from app.hosting.preparation import Preparation
from app.hosting.private_host import PrivateHost
from app.hosting.serve_options import ServeOptions
from app.hosting.teacher_key import Guesses, is_teacher
from app.hosting.workload import Workload, places, step_seconds
from app.page.page_assets import loading_html, page_assets
from app.page.panel_context import PanelMaker
from app.runtime.job_pool import JobPool, Jobs
from app.runtime.throttled_log import ThrottledLog
from app.session.late_law import no_law
from app.text.document_list import DOCUMENTS
from app.text.documents import PREFIX, document_page
from app.web.server import DuetServer

log = logging.getLogger("duet.hosts")

# A tab may close in the middle of a frame; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)


class App:
    """A running server, made by `start_app`; `hangs`: see `FrameLoop`."""

    def __init__(self, context: AppContext, host: Host, preparation: Preparation | None) -> None:
        self.context, self.host, self.server, self.url = context, host, context.server, context.server.url
        self._preparation = preparation
        self.loop = FrameLoop(host.frame, context.frame_due, context.workload.note)
        self.server.is_at_work, self.hangs = self.loop.is_at_work, self.loop.hangs
        self.loop.start()
        self._closed = threading.Event()

    def wait(self) -> None:
        while not self._closed.wait(0.5):
            pass

    def close(self, goes_on: bool = False) -> None:
        """Stop frames and background jobs, close every connection and release the port. `goes_on`: the next
        server continues the sessions.
        """
        if self._preparation is not None:
            self._preparation.close()
        self.loop.stop()
        self.host.close(goes_on)
        for part in self.context.parts:
            part.close()
        self.context.jobs.close()
        for one in self.context.opened:
            one.close()
        self.server.stop()
        self._closed.set()


def start_app(
    options: ServeOptions,
    features: Sequence[Feature],
    listener: socket.socket | None = None,
    run: str = "",
    jobs: Jobs | None = None,
    started_with: Sequence[object] = (),
) -> App:
    """Start to serve the page.

    Args:
        features: () for the core alone.
        listener, run: see `DuetServer`.
        jobs: runs what takes longer than a frame; None for a pool of this process.
        started_with: see `AppContext.given`.

    Raises:
        PortInUse, BadSetting: see `DuetServer`.
        BadSetting, BadInputFile, MissingPackage: what the options name cannot be opened.
        DuetError: see `Feature.store`.
    """
    shared, added = options.shared, (one.assets() for one in features if one.assets is not None)
    with ExitStack() as opened:
        panels: list[PanelMaker] = []
        of_server: list[OpenedFeature] = []
        for feature in reversed(features):
            panels += () if feature.panels is None else feature.panels()
            if feature.opened is not None:
                of_server.append(feature.opened(options))
                opened.callback(of_server[-1].close)
                panels += of_server[-1].panels
        law = next((one.law for one in of_server if one.law is not None), no_law)
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
        kept = next((one.store(options) for one in features if one.store is not None), None) or Parking()
        server.app_state = lambda: {**kept.health, **workload.report._asdict()}
        server.may_measure = partial(is_teacher, options.key)
        server.proof = options.proof
        errors = ThrottledLog(log)
        keys = tuple(row for one in reversed(features) if one.key_help is not None for row in one.key_help())
        overlays = tuple(
            made for one in reversed(features) if one.overlays is not None for made in one.overlays()
        )
        given = Joining(tuple(one.joining for one in features if one.joining is not None)), *started_with
        context = AppContext(
            server,
            options,
            jobs or JobPool(),
            law,
            kept,
            workload,
            errors,
            tuple(panels),
            key_help=keys,
            overlays=overlays,
            started_with=given,
            opened=tuple(of_server),
        )
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
    hosts = (one.host(context) for one in features if one.host is not None)
    found = next((host for host in hosts if host is not None), None)
    return found or PrivateHost(context)
