"""Serves the page in worker processes; this process only listens. Imports nothing slow."""

import signal
import socket
from collections.abc import Callable, Sequence
from dataclasses import replace

from app.feature import Feature
from app.features.workers.dispatcher import Dispatcher
from app.features.workers.worker_messages import WorkerStart
from app.features.workers.worker_options import WorkerOptions
from app.hosting.serve_options import ServeOptions
from app.runtime.progress import cores
from app.runtime.terminal import terminated
from scenes.given_robots import given_at_start


def serve_with_workers(
    options: ServeOptions,
    listener: socket.socket,
    features: Sequence[Feature],
    announce: Callable[[int], None],
) -> bool:
    """Serve until Ctrl+C; False at once if this process must serve. `announce`: see `Dispatcher.run`.

    Raises:
        BadSetting: see `WorkerOptions.count`.
    """
    most = options.of(WorkerOptions).count(options)
    if most == 1:
        if hasattr(signal, "SIGUSR1"):
            # There are no workers to replace.
            signal.signal(signal.SIGUSR1, signal.SIG_IGN)
        return False
    # Only this process knows the robots from files.
    options = replace(options, loops=min(most, cores()))
    dispatcher = Dispatcher(listener, WorkerStart(options, given_at_start(), tuple(features)), most)
    try:
        dispatcher.run(announce)
    except BaseException as error:
        # After a fault a shared session continues on the next server, as after SIGTERM.
        dispatcher.close(isinstance(error, Exception) or terminated())
        raise
    return True
