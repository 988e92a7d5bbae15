"""`lwr-duet serve`: the page."""

import os
import signal
import socket
import webbrowser
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, make_dataclass, replace
from pathlib import Path
from typing import Final, Literal
from urllib.parse import quote

import tyro

from app.cli.options import AllOptions, Flat, settings_of_options
from app.feature import Feature
from app.hosting.dispatcher import Dispatcher
from app.hosting.serve_options import FeatureOptions, ServeOptions
from app.hosting.store_choice import chosen_store
from app.hosting.store_file import StoreLock, usual_path
from app.hosting.teacher_key import AUTO, chosen_key
from app.hosting.worker_messages import WorkerStart
from app.runtime.progress import cores
from app.runtime.temporary_folder import remove_abandoned
from app.runtime.terminal import INTERRUPTED, ending_at_once, terminated
from app.settings import Settings
from app.web.listening import listen, listen_near, url_of
from app.web.origin_policy import OriginPolicy
from controllers.errors import BadSetting
from scenes.files import readable
from scenes.setting_spec import added_choices

PROOF_VARIABLE: Final = "DUET_PROOF"
"""Environment variable by which the tile of a notebook server hands over its secret, see `app.web.origin_policy.PROOF`."""

EDITED: Final = Path("my_law.py")
"""What is edited where no file is named."""

KEY_VARIABLE: Final = "DUET_KEY"
"""Environment variable with the teacher's key."""

USUAL_PORT: Final = 8080
"""Port of a server that is not told one, unless another program has it."""

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

    host: str = ServeOptions.host
    """Address to listen on; 0.0.0.0 lets the whole network in."""
    port: int | Literal["auto"] = "auto"
    """Port to listen on; `auto`: 8080, or the next free one, which the start says."""
    open: bool = True
    """Open the browser."""
    sessions: int | Literal["auto"] = "auto"
    """Most tabs with a session of their own at once. `auto`: as many as this machine carries at 20 frames a second; the start says
    about how many that is."""
    workers: int | Literal["auto"] = "auto"
    """Processes that share the visitors, started as they are needed; `auto` for as many as the machine has cores."""
    key: str | None = None
    """Visitors who open the page with ?key=KEY are teachers: they see the notes to the lessons. 12 characters or more; `auto` makes one
    and prints the link. Without this option, the environment variable DUET_KEY, which the list of processes does not show."""
    allow_origin: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A further web address under which the page may be opened, such as https://duet.example.org behind a proxy; may be given several
    times."""
    embed_origin: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """The web address of a page that may show this one in a frame, such as https://moodle.example.org; may be given several times."""
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
    edit_law: bool = False
    """Edit that file, or my_law.py of this folder, on the page: in lesson 10 and in Compare, on this computer only."""
    store: str | None = None
    """File that keeps what visitors do when the server ends, or `memory` to keep it no longer than the server runs; without this
    option a file in your home folder, or one beside it while another server has that."""
    keep: float = ServeOptions.keep / 3600.0
    """How long a visitor's work is kept after the last visit [hours]."""
    store_size: float = ServeOptions.most_bytes / 1e6
    """Largest size of that file [MB]; beyond it the work of those who left first is deleted."""
    settings: Flat[AllOptions] = field(default_factory=AllOptions)  # type: ignore[valid-type]
    """What the page shows at first."""


def serve_with(features: Sequence[Feature]) -> type[Serve]:
    """Options of the command with those of the features, each a field of the feature's name."""
    added = [(one.name, Flat[one.options()], field(default_factory=one.options())) for one in features if one.options is not None]
    return make_dataclass("Serve", added, bases=(Serve,), frozen=True, namespace={"__doc__": Serve.__doc__})


def serve(command: Serve, features: Sequence[Feature]) -> int:
    """Serve the page until Ctrl+C or SIGTERM; return the exit code.

    Args:
        command: an object of `serve_with` the features.
        features: beside the core.

    Raises:
        BadSetting, BadInputFile, PortInUse, StoreRefused: before anything is served.
    """
    if isinstance(command.sessions, int) and command.sessions < 1:
        raise BadSetting("--sessions must be at least 1, or auto.")
    of_features: tuple[FeatureOptions, ...] = tuple(getattr(command, one.name) for one in features if one.options is not None)
    for one in of_features:
        one.check()
    if not 0.0 < command.keep <= LONGEST_KEEP:
        raise BadSetting(f"--keep = {command.keep:g} h is not possible; give hours up to {LONGEST_KEEP:g}, or --store memory.")
    if not command.store_size >= SMALLEST_STORE:
        raise BadSetting(f"--store-size must be at least {SMALLEST_STORE:g} MB.")
    settings = settings_of_options(command.settings, Settings())
    _draw_given_robots()
    given = command.key or os.environ.get(KEY_VARIABLE)
    key = chosen_key(None if given is None else readable(given))
    workers = _workers(command)
    options = ServeOptions(
        host=command.host,
        port=USUAL_PORT if command.port == "auto" else command.port,
        settings=settings,
        sessions=None if command.sessions == "auto" else command.sessions,
        key=key,
        allowed_origins=command.allow_origin,
        embed_origins=command.embed_origin,
        bvh=command.bvh,
        camera=command.camera,
        video=command.video,
        pose_model=command.pose_model,
        law_file=command.law_file,
        edited_law=_edited_law(command, of_features),
        # The processes of laws inherit the environment.
        proof=os.environ.pop(PROOF_VARIABLE, ""),
        ahead=True,
        store=None if command.store in (None, MEMORY) else Path(command.store),
        keep=3600.0 * command.keep,
        most_bytes=round(1e6 * command.store_size),
        loops=min(workers, cores()),
        features=of_features,
    )
    remove_abandoned()
    try:
        with ExitStack() as held:
            listener = (listen_near if command.port == "auto" else listen)(options.host, options.port)
            held.callback(listener.close)
            options = replace(options, port=listener.getsockname()[1])
            options = _with_store(command, options, held)
            if workers == 1:
                _serve_alone(command, options, listener, features)
            else:
                _serve_with_workers(command, options, listener, features, workers)
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0


def _with_store(command: Serve, options: ServeOptions, held: ExitStack) -> ServeOptions:
    """Return the options with the file of the visitors, which is locked until `held` ends.

    Raises:
        StoreRefused: another server has the file that is named, or it is not a store.
    """
    # Where there can be no lock there can be no file, which the workers say.
    with suppress(OSError):
        if options.store is not None:
            held.callback(StoreLock(options.store).release)
        elif command.store is None:
            options = replace(options, store=usual_path())
            path, lock = chosen_store(usual_path(), options.port)
            held.callback(lock.release)
            options = replace(options, store=path)
    return options


def _draw_given_robots() -> None:
    """Build what is drawn of robots from files, so that a fault in a file is said now and not on a visitor's page.

    Raises:
        BadInputFile: one of them cannot be drawn.
    """
    if added_choices().get("robot"):
        with ending_at_once():
            from scenes.robots.drawing import draw_file

            for name in added_choices()["robot"]:
                draw_file(name)


def _edited_law(command: Serve, of_features: Sequence[FeatureOptions]) -> Path | None:
    """Return the file that is edited on the page; None for none.

    Raises:
        BadSetting: others could reach the page, and what is written there is a program.
    """
    if not command.edit_law:
        return None
    shared = {
        f"--host {readable(command.host)}": not OriginPolicy(command.host, USUAL_PORT).is_private,
        "--allow-origin": command.allow_origin,
        **{one.shared_by: True for one in of_features if one.shared_by},
        "--embed-origin": command.embed_origin,
    }
    for option, given in shared.items():
        if given:
            raise BadSetting(
                f"--edit-law is not possible with {option}: a law is a program, and only you may write it. Leave out one of the two; "
                "students edit theirs on their own computer, or in the tile of a notebook server."
            )
    return (command.law_file or EDITED).absolute()


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


def _serve_alone(command: Serve, options: ServeOptions, listener: socket.socket, features: Sequence[Feature]) -> None:
    """Serve the page in this process until Ctrl+C."""
    if hasattr(signal, "SIGUSR1"):
        # There are no workers to replace.
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    with ending_at_once():
        from app.start import start_app

        app = start_app(options, features, listener)
    try:
        _announce(command, options, app.context.workload.places)
        app.wait()
    finally:
        app.close(terminated())


def _serve_with_workers(
    command: Serve, options: ServeOptions, listener: socket.socket, features: Sequence[Feature], most: int
) -> None:
    """Serve the page in worker processes until Ctrl+C."""
    # The robots that were read from files are known to this process only.
    given = None
    if added_choices():
        from scenes.robots.robot_files import given_at_start

        given = given_at_start()
    dispatcher = Dispatcher(listener, WorkerStart(options, given, tuple(features)), most)
    try:
        dispatcher.run(lambda places: _announce(command, options, places))
    except BaseException as error:
        # After a fault a shared session goes on with the next server, as it does after SIGTERM.
        dispatcher.close(isinstance(error, Exception) or terminated())
        raise


def _announce(command: Serve, options: ServeOptions, places: int) -> None:
    key, port = options.key, options.port
    made = (command.key or os.environ.get(KEY_VARIABLE)) == AUTO
    link = url_of(command.host, port) + (f"/?key={quote(key, safe='')}" if key else "")
    # The output of a service is its log: it has no key but the one that only it can tell.
    print(f"Duet is at {link if made or not key else link.partition('=')[0] + '=KEY'}   (Ctrl+C ends it)", flush=True)
    if command.port == "auto" and port != USUAL_PORT:
        print(f"Port {USUAL_PORT} is taken by another program, so this Duet has port {port}.", flush=True)
    if command.store is None and options.store is not None and options.store != usual_path():
        print(f"This Duet keeps its visitors in {options.store}: others have their own files there.", flush=True)
    for line in (line for one in options.features for line in one.said_at_start(command.host, port, places)):
        print(line, flush=True)
    if command.sessions == "auto":
        print(f"This machine carries about {places} sessions at once.", flush=True)
    if command.open:
        webbrowser.open(link)
