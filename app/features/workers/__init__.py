import socket
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.features.workers.worker_options import WorkerOptions
    from app.hosting.app_context import AppContext
    from app.hosting.host import Host
    from app.hosting.serve_options import ServeOptions


def _options() -> "type[WorkerOptions]":
    from app.features.workers.worker_options import WorkerOptions

    return WorkerOptions


def _start(
    options: "ServeOptions",
    listener: socket.socket,
    features: Sequence[Feature],
    announce: Callable[[int], None],
) -> bool:
    from app.features.workers.start import serve_with_workers

    return serve_with_workers(options, listener, features, announce)


def _host(context: "AppContext") -> "Host | None":
    from app.features.workers.worker_host import WorkerHost
    from app.features.workers.worker_messages import WorkerLink

    link = context.given(WorkerLink)
    return None if link is None else WorkerHost(context, link)


ONE_PROCESS: Final = ("--workers", "1")

WORKERS: Final = Feature("workers", options=_options, start=_start, host=_host)
