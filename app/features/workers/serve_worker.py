"""A worker of `lwr-duet serve`, started by the dispatcher."""

import logging
import signal
import sys
import threading
from math import inf
from multiprocessing.connection import Connection
from time import monotonic
from typing import TYPE_CHECKING, Any

from app.features.workers import worker_messages as messages
from app.features.workers.handed_over import HandedOverListener
from app.features.workers.worker_messages import PULSE, WorkerLink, WorkerStart
from app.runtime.terminal import write_log
from controllers.errors import DuetError
from controllers.system_libraries import naming_missing_library

if TYPE_CHECKING:
    from app.start import App


class MessagePipe:
    """Messages to and from the dispatcher; `send` is thread-safe."""

    def __init__(self, control: "Connection[Any, Any]") -> None:
        self._control, self._lock = control, threading.Lock()

    def send(self, message: object) -> None:
        with self._lock:
            try:
                self._control.send(message)
            except OSError:
                # The dispatcher has ended, which `receive` notices.
                return

    def receive(self, until: float = inf) -> object:
        """Next message; `Stop` if the dispatcher has ended, None at the time `until` [s]."""
        try:
            if until < inf and not self._control.poll(max(until - monotonic(), 0.0)):
                return None
            return self._control.recv()
        except (EOFError, OSError):
            return messages.Stop(goes_on=True)


def main() -> int:
    """Arguments: descriptors of the connections and of the dispatcher's messages."""
    channel, control = map(int, sys.argv[1:])
    # The dispatcher decides when to end, also if all processes of a service get the signal.
    for ending in (signal.SIGINT, signal.SIGTERM):
        signal.signal(ending, signal.SIG_IGN)
    write_log()
    pipe = MessagePipe(Connection(control))
    start = pipe.receive()
    if not isinstance(start, WorkerStart):
        return 1
    try:
        link = WorkerLink(start.index, pipe.send)
        with naming_missing_library():
            app = _start(start, channel, pipe, link)
    except DuetError as error:
        pipe.send(messages.Failed(str(error)))
        return 2
    goes_on = False
    try:
        pipe.send(messages.Ready(app.context.workload.places))
        goes_on = _obey(app, pipe, link)
    finally:
        # The dispatcher may no longer listen.
        app.server.count_changed = lambda count: None
        app.close(goes_on)
    return 0


def _start(start: WorkerStart, channel: int, pipe: MessagePipe, link: WorkerLink) -> "App":
    # Imported here, so that a missing system library is reported to the dispatcher.
    from app.features.workers.shared_jobs import JobClient
    from app.start import start_app
    from scenes.given_robots import take_over

    if start.given is not None:
        take_over(start.given)
    assert start.jobs is not None
    jobs = JobClient(start.jobs, lambda: pipe.send(messages.StartJobs()))
    listener = HandedOverListener(channel, (start.options.host, start.options.port))
    app = start_app(start.options, start.features, listener, start.run, jobs, (link,))
    app.server.count_changed = lambda count: pipe.send(messages.ClientCount(count))
    return app


def _obey(app: "App", pipe: MessagePipe, link: WorkerLink) -> bool:
    from app.features.workers.shared_load import LoadOfAll

    load = LoadOfAll(app)
    pulse = 0.0
    while True:
        if monotonic() >= pulse:
            pulse = monotonic() + PULSE
            pipe.send(messages.Load(tuple(app.context.workload.report), draws=not app.hangs()))
        message = pipe.receive(pulse)
        match message:
            case None:
                pass
            case messages.Stop(goes_on):
                return goes_on
            case messages.LoadElsewhere(reports):
                load.note(reports)
            case messages.ClientCount(count):
                app.server.elsewhere = count
            case bytes() | messages.Replaced() | messages.MakeRoom() | messages.Announced():
                link.put(message)
            case _:
                logging.getLogger("duet.worker").error("the dispatcher says %r", message)
