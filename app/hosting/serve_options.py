"""What a server is started with, from the command over the dispatcher to its workers. Imports nothing slow."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from app.settings import Settings

MOST_STUDENTS: Final = 2000
"""Students that can be expected in a lecture."""


@dataclass(frozen=True)
class ServeOptions:
    """How the page is served.

    Attributes:
        host, port: address to listen on; port 0 takes any free one.
        settings: of a link without a query.
        sessions: private sessions at once; None for as many as this machine carries.
        watchers: pages that may be open in a lecture at once; the teacher gets in besides.
        students: that are expected in a lecture, up to `MOST_STUDENTS`; 0 where it is not known.
        lecture: whether all see one plenary session.
        key: the teacher's, or None.
        allowed_origins: web addresses from which pages may connect besides our own.
        embed_origins: web addresses of pages that may show ours in a frame.
        bvh, camera, video, pose_model, law_file: see `app.session.input_source.find_input_sources`.
        edited_law: file of a law that the person who started the server may edit on the page; None for none.
        proof: what the notebook server adds to that person's requests, see `app.web.origin_policy.PROOF`; "" without one.
        lessons: folder of lessons beside our own; None for none.
        playlist: TOML file that names the lessons that are shown; None for all.
        ahead: whether to prepare what is slow the first time.
        store: file in which what visitors do outlives the server; None for memory alone.
        keep: how long it is kept after their last visit [s].
        most_bytes: of the file.
        loops: processes that share the sessions, each with a frame loop and a core of its own.
    """

    host: str = "127.0.0.1"
    port: int = 0
    settings: Settings = field(default_factory=Settings)
    sessions: int | None = None
    watchers: int = 200
    students: int = 0
    lecture: bool = False
    key: str | None = None
    allowed_origins: tuple[str, ...] = ()
    embed_origins: tuple[str, ...] = ()
    bvh: Path | None = None
    camera: int | None = None
    video: Path | None = None
    pose_model: Path | None = None
    law_file: Path | None = None
    edited_law: Path | None = None
    proof: str = field(default="", repr=False)
    lessons: Path | None = None
    playlist: Path | None = None
    ahead: bool = False
    store: Path | None = None
    keep: float = 24.0 * 3600.0
    most_bytes: int = 500_000_000
    loops: int = 1
