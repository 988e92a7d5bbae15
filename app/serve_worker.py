"""A worker of `lwr-duet serve`: serves the page on connections that the door hands over. Started by the door alone."""

import logging
import signal
import sys
import threading
from math import inf
from multiprocessing.connection import Connection
from time import monotonic
from typing import Any

from app.hosting.worker_link import WorkerLink
from app.hosting.worker_process import PULSE, AtWork, ClientCount, Failed, Ready, Relayed, Replaced, StartJobs, Stop, WorkerStart
from app.runtime.shared_jobs import JobClient
from app.session.input_sources import find_input_sources
from app.start import App, start_app
from app.web.handed_over import HandedOverListener
from controllers.errors import DuetError
from scenes.robots.robot_files import take_over


class Messages:
    """What a worker and the door say to each other. `send` may be called from any thread."""

    def __init__(self, control: "Connection[Any, Any]") -> None:
        self._control, self._lock = control, threading.Lock()

    def send(self, message: object) -> None:
        with self._lock:
            try:
                self._control.send(message)
            except OSError:
                # The door has ended, which `receive` notices.
                return

    def receive(self, until: float = inf) -> object:
        """Wait for the next message; `Stop` if the door has ended, None if there is none at a time [s]."""
        try:
            if until < inf and not self._control.poll(max(until - monotonic(), 0.0)):
                return None
            return self._control.recv()
        except (EOFError, OSError):
            return Stop(goes_on=True)


def main(channel: int, control: int) -> int:
    """Serve until the door says so, or has ended; return the exit code.

    Args:
        channel: descriptor from which connections are read.
        control: descriptor of the messages.
    """
    # The door says when to end, also when the signal is for all processes of a service.
    for ending in (signal.SIGINT, signal.SIGTERM):
        signal.signal(ending, signal.SIG_IGN)
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    messages = Messages(Connection(control))
    start = messages.receive()
    if not isinstance(start, WorkerStart):
        return 1
    try:
        link = WorkerLink(start.index, messages.send)
        app = _start(start, channel, messages, link)
    except DuetError as error:
        messages.send(Failed(str(error)))
        return 2
    goes_on = False
    try:
        messages.send(Ready(app.context.workload.places))
        goes_on = _obey(app, messages, link)
    finally:
        # The door may not listen any more.
        app.server.count_changed = lambda count: None
        app.close(goes_on)
    return 0


def _start(start: WorkerStart, channel: int, messages: Messages, link: WorkerLink) -> App:
    if start.given is not None:
        take_over(start.given)
    assert start.jobs is not None
    jobs = JobClient(start.jobs, lambda: messages.send(StartJobs()))
    sources = find_input_sources(*start.sources)
    try:
        app = start_app(
            start.host,
            start.port,
            sources=sources,
            listener=HandedOverListener(channel, (start.host, start.port)),
            run=start.run,
            jobs=jobs,
            link=link,
            **start.app,
        )
    except Exception:
        sources.close()
        raise
    app.server.count_changed = lambda count: messages.send(ClientCount(count))
    return app


def _obey(app: App, messages: Messages, link: WorkerLink) -> bool:
    """Do what the door says until the end; return whether a lecture goes on with the next server."""
    pulse = 0.0
    while True:
        if monotonic() >= pulse:
            pulse = monotonic() + PULSE
            if app.server.is_at_work():
                messages.send(AtWork())
        message = messages.receive(pulse)
        match message:
            case None:
                pass
            case Stop(goes_on):
                return goes_on
            case ClientCount(count):
                app.server.elsewhere = count
            case Relayed(content):
                link.put(content)
            case Replaced():
                link.put(message)
            case _:
                logging.getLogger("duet.worker").error("the door says %r", message)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
