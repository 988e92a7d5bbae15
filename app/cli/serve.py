"""`lwr-duet serve`: the page."""

import os
import signal
import socket
import webbrowser
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal
from urllib.parse import quote

import tyro

from app.cli.options import AllOptions, Flat, chosen
from app.cli.sweep import cores
from app.hosting.door import Door
from app.hosting.store_file import StoreLock, usual_path
from app.hosting.teacher_key import chosen_key
from app.hosting.worker_process import WorkerStart
from app.runtime.terminal import INTERRUPTED, ending_at_once, terminated
from app.settings import Settings
from app.web.listening import listen, url_of
from controllers.errors import BadSetting
from scenes.files import readable
from scenes.given_choices import added_choices

KEY_VARIABLE: Final = "DUET_KEY"
"""Environment variable with the teacher's key."""

MEMORY: Final = "memory"
"""In place of a file: visitors' work is kept no longer than the server runs."""

MOST_WORKERS: Final = 8
"""Processes that `--workers auto` starts at most."""

LONGEST_KEEP: Final = 24.0 * 366.0
"""[hours]"""

SMALLEST_STORE: Final = 1.0
"""[MB]"""


@dataclass(frozen=True)
class Serve:
    """Open the page: two arms in the browser, one is yours, the other keeps clear."""

    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets the whole network in."""
    port: int = 8080
    """Port to listen on."""
    open: bool = True
    """Open the browser."""
    sessions: int | Literal["auto"] = "auto"
    """Most tabs with a session of their own at once; in a lecture, most students who explore by themselves. `auto`: as many as this
    machine carries at 20 frames a second; the start says about how many that is."""
    watchers: int = 200
    """Most pages open in a lecture at once; visitors with the key always get in."""
    workers: int | Literal["auto"] = "auto"
    """Processes that share the visitors, started as they are needed; `auto` for as many as the machine has cores."""
    lecture: bool = False
    """A class: all tabs see one stage, students answer on their own; the first tab, or the one with the key, leads."""
    key: str | None = None
    """Visitors who open the page with ?key=KEY are teachers: they see the notes to the lessons, and lead the class in a lecture.
    8 characters or more; `auto` makes one and prints the link. Without this option, the environment variable DUET_KEY, which the list of
    processes does not show."""
    allow_origin: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A further web address under which the page may be opened, such as https://duet.example.org behind a proxy; may be given several
    times."""
    bvh: Path | None = None
    """A person's recorded motion to imitate, as BVH; used when `source` is `file`."""
    camera: int | None = None
    """Number of a camera at this computer; its person is imitated when `source` is `camera` (needs the extra `camera`)."""
    video: Path | None = None
    """A video file instead of a camera."""
    pose_model: Path | None = None
    """MediaPipe's model that finds the person, a pose_landmarker .task file."""
    law_file: Path | None = None
    """A law of your own, see `new-law`: it runs instead of ours, and is loaded again whenever it is saved."""
    store: str | None = None
    """File that keeps what visitors do when the server ends, or `memory` to keep it no longer than the server runs; without this
    option a file in your home folder."""
    keep: float = 24.0
    """How long a visitor's work is kept after the last visit [hours]."""
    store_size: float = 500.0
    """Largest size of that file [MB]; beyond it the work of those who left first is deleted."""
    lessons: Path | None = None
    """Folder of lessons instead of our own ten; see app/lessons/README.md."""
    settings: Flat[AllOptions] = field(default_factory=AllOptions)  # type: ignore[valid-type]
    """What the page shows at first."""


def serve(command: Serve) -> int:
    """Serve the page until Ctrl+C or SIGTERM; return the exit code.

    Raises:
        BadSetting, BadInputFile, PortInUse, StoreInUse: before anything is served.
    """
    for name, count in (("sessions", command.sessions), ("watchers", command.watchers)):
        if isinstance(count, int) and count < 1:
            raise BadSetting(f"--{name} must be at least 1{', or auto' if name == 'sessions' else ''}.")
    if not 0.0 < command.keep <= LONGEST_KEEP:
        raise BadSetting(f"--keep = {command.keep:g} h is not possible; give hours up to {LONGEST_KEEP:g}, or --store memory.")
    if not command.store_size >= SMALLEST_STORE:
        raise BadSetting(f"--store-size must be at least {SMALLEST_STORE:g} MB.")
    if command.lessons is not None and not command.lessons.is_dir():
        raise BadSetting(f"lessons = {command.lessons}: there is no such folder; name one with lesson files.")
    settings = chosen(command.settings, Settings())
    given = command.key or os.environ.get(KEY_VARIABLE)
    key = chosen_key(None if given is None else readable(given))
    served: dict[str, Any] = {
        "settings": settings,
        "sessions": None if command.sessions == "auto" else command.sessions,
        "lecture": command.lecture,
        "key": key,
        "allowed_origins": command.allow_origin,
        "lessons": command.lessons,
        "watchers": command.watchers,
        "ahead": True,
        "store": usual_path() if command.store is None else None if command.store == MEMORY else Path(command.store),
        "keep": 3600.0 * command.keep,
        "most_bytes": round(1e6 * command.store_size),
    }
    sources = command.bvh, command.camera, command.video, command.pose_model, command.law_file
    try:
        workers = _workers(command)
        served["loops"] = min(workers, cores())
        if workers == 1:
            _serve_alone(command, key, served, sources)
        else:
            _serve_with_workers(command, key, served, sources, workers)
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0


def _workers(command: Serve) -> int:
    """Return how many processes may share the visitors.

    Raises:
        BadSetting: the option is not a number of processes, or there can be one only.
    """
    reason = (
        "one process reads the camera"
        if command.camera is not None or command.video is not None
        else "this system cannot hand connections over"
        if not hasattr(socket, "send_fds")
        else ""
    )
    if command.workers == "auto":
        return 1 if reason else min(cores(), MOST_WORKERS)
    if command.workers < 1 or (reason and command.workers > 1):
        raise BadSetting(f"--workers must be 1 here: {reason}." if reason else "--workers must be at least 1.")
    return command.workers


def _serve_alone(command: Serve, key: str | None, served: Mapping[str, Any], named: tuple[Any, ...]) -> None:
    """Serve the page in this process until Ctrl+C."""
    if hasattr(signal, "SIGUSR1"):
        # There are no workers to replace.
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    with ending_at_once():
        from app.session.input_sources import find_input_sources
        from app.start import start_app

        sources = find_input_sources(*named)
        try:
            app = start_app(command.host, command.port, sources=sources, **served)
        except Exception:
            sources.close()
            raise
    try:
        _announce(command, key, app.server.get_port(), app.context.workload.places)
        app.wait()
    finally:
        app.close(terminated())


def _serve_with_workers(command: Serve, key: str | None, served: Mapping[str, Any], named: tuple[Any, ...], most: int) -> None:
    """Serve the page in worker processes until Ctrl+C."""
    store: Path | None = served["store"]
    with ExitStack() as held:
        listener = listen(command.host, command.port)
        port = listener.getsockname()[1]
        held.callback(listener.close)
        if store is not None:
            # Where there can be no lock there can be no file, which the workers say.
            with suppress(OSError):
                held.callback(StoreLock(store).release)
        # The robots that were read from files are known to this process only.
        given = None
        if added_choices():
            from scenes.robots.robot_files import given_at_start

            given = given_at_start()
        door = Door(listener, WorkerStart(command.host, port, served, named, given), most)
        try:
            door.run(lambda places: _announce(command, key, port, places))
        except Exception:
            # A lecture goes on with the next server.
            door.close(True)
            raise
        except BaseException:
            door.close(terminated())
            raise


def _announce(command: Serve, key: str | None, port: int, places: int) -> None:
    link = url_of(command.host, port) + (f"/?key={quote(key, safe='')}" if key else "")
    print(f"Duet is at {link}   (Ctrl+C ends it)", flush=True)
    if command.lecture:
        from app.classroom.address import find_address

        print(f"The class opens {find_address('', command.host, port).url}", flush=True)
    if command.sessions == "auto":
        print(f"This machine carries about {places} sessions at once.", flush=True)
    if command.open:
        webbrowser.open(link)
