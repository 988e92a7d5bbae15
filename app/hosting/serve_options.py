"""What a server is started with, from the command over the dispatcher to its workers. Imports nothing slow."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from app.settings import Settings

T = TypeVar("T", bound="FeatureOptions")


@dataclass(frozen=True)
class FeatureOptions:
    """What `lwr-duet serve` is told of one feature: its dataclass adds fields that have a default. It is pickled to the workers."""

    @property
    def shared_by(self) -> str:
        """Option by which all tabs see one session, such as `--exhibit`; "" while every tab has a session of its own."""
        return ""

    @property
    def most_pages(self) -> int | None:
        """Pages that may be open at once; None for as many as there are private sessions."""
        return None

    def check(self) -> None:
        """Refuse what is not possible, before anything is served.

        Raises:
            BadSetting: of an option.
        """

    def said_at_start(self, host: str, port: int, places: int) -> tuple[str, ...]:
        """Lines that the start prints. `places`: private sessions at once."""
        del host, port, places
        return ()


@dataclass(frozen=True)
class ServeOptions:
    """How the page is served.

    Attributes:
        host, port: address to listen on; port 0 takes any free one.
        settings: of a link without a query.
        sessions: private sessions at once; None for as many as this machine carries.
        key: the teacher's, or None.
        allowed_origins: web addresses from which pages may connect besides our own.
        embed_origins: web addresses of pages that may show ours in a frame.
        bvh, camera, video, pose_model, law_file: see `app.session.input_source.find_input_sources`.
        edited_law: file of a law that the person who started the server may edit on the page; None for none.
        proof: what the notebook server adds to that person's requests, see `app.web.origin_policy.PROOF`; "" without one.
        ahead: whether to prepare what is slow the first time.
        store: file in which what visitors do outlives the server; None for memory alone.
        keep: how long it is kept after their last visit [s].
        most_bytes: of the file.
        loops: processes that share the sessions, each with a frame loop and a core of its own.
        features: what is asked of features, at most one of each type.
    """

    host: str = "127.0.0.1"
    port: int = 0
    settings: Settings = field(default_factory=Settings)
    sessions: int | None = None
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
    ahead: bool = False
    store: Path | None = None
    keep: float = 24.0 * 3600.0
    most_bytes: int = 500_000_000
    loops: int = 1
    features: tuple[FeatureOptions, ...] = ()

    def of(self, kind: type[T]) -> T:
        """Options of a feature; its defaults if it was asked for nothing."""
        return next((one for one in self.features if isinstance(one, kind)), None) or kind()

    @property
    def shared(self) -> FeatureOptions | None:
        """Options of the feature by which all tabs see one session; None if every tab has a session of its own."""
        return next((one for one in self.features if one.shared_by), None)
