"""`lwr-duet serve`: the page."""

import webbrowser
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal
from urllib.parse import quote

import tyro

from app.cli.options import AllOptions, Flat, chosen
from app.runtime.terminal import INTERRUPTED, ending_at_once
from app.settings import Settings
from controllers.errors import BadSetting
from scenes.files import readable

MEMORY: Final = "memory"
"""In place of a file: visitors' work is kept no longer than the server runs."""

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
    lecture: bool = False
    """A class: all tabs see one stage, students answer on their own; the first tab, or the one with the key, leads."""
    key: str | None = None
    """Visitors who open the page with ?key=KEY are teachers: they see the notes to the lessons, and lead the class in a lecture.
    8 characters or more; `auto` makes one and prints the link."""
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
    """Serve the page until Ctrl+C; return the exit code.

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
    with ending_at_once():
        from app.classroom.address import find_address
        from app.hosting.store_file import usual_path
        from app.hosting.teacher_key import chosen_key
        from app.session.input_sources import find_input_sources
        from app.start import start_app

        key = chosen_key(command.key if command.key is None else readable(command.key))
        sources = find_input_sources(command.bvh, command.camera, command.video, command.pose_model, command.law_file)
        try:
            app = start_app(
                command.host,
                command.port,
                settings,
                None if command.sessions == "auto" else command.sessions,
                command.lecture,
                key,
                command.allow_origin,
                sources,
                command.lessons,
                command.watchers,
                ahead=True,
                store=usual_path() if command.store is None else None if command.store == MEMORY else Path(command.store),
                keep=3600.0 * command.keep,
                most_bytes=round(1e6 * command.store_size),
            )
        except Exception:
            sources.close()
            raise
    try:
        link = app.url + (f"/?key={quote(key, safe='')}" if key else "")
        print(f"Duet is at {link}   (Ctrl+C ends it)", flush=True)
        if command.lecture:
            print(f"The class opens {find_address('', command.host, app.server.get_port()).url}", flush=True)
        if command.sessions == "auto":
            print(f"This machine carries about {app.context.workload.places} sessions at once.", flush=True)
        if command.open:
            webbrowser.open(link)
        app.wait()
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        app.close()
    return 0
