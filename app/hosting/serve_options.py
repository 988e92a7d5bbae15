"""Options of a server. Imports nothing slow."""

from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import ClassVar, Self, TypeVar

from app.settings import Settings

T = TypeVar("T", bound="FeatureOptions")


@dataclass(frozen=True)
class FeatureOptions:
    """What `lwr-duet serve` is told of one feature: its dataclass adds fields that have a default. It can be pickled.

    Attributes:
        in_brief: fields that `serve --help` shows; `--help-all` shows the others, too.
    """

    in_brief: ClassVar[tuple[str, ...]] = ()

    @property
    def shared_by(self) -> str:
        """Option by which all tabs see one session, such as `--exhibit`; "" if every tab has its own."""
        return ""

    @property
    def most_pages(self) -> int | None:
        """Pages that may be open at once; None for the number of private sessions."""
        return None

    @property
    def one_process(self) -> str:
        """Why one process has to serve all pages, such as "one process reads the camera"; "" if several can."""
        return ""

    def check(self) -> None:
        """Raises `BadSetting` before anything is served."""

    def held(self, port: int, until: ExitStack) -> Self:
        """Take what the server holds while it runs, such as a file's lock; return the options to serve with.

        Raises:
            DuetError: another server has it.
        """
        del port, until
        return self

    def fits(self, options: "ServeOptions") -> None:
        """Check the combination with the other options; raises `BadSetting` before anything is served."""

    def said_at_start(self, host: str, port: int, places: int) -> tuple[str, ...]:
        """Lines printed at the start. `places`: private sessions at once."""
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
        allowed_origins: web addresses of other pages that may connect.
        embed_origins: web addresses of pages that may show ours in a frame.
        proof: of a notebook server, see `app.web.origin_policy.PROOF`, or "".
        ahead: whether to prepare what is slow the first time.
        loops: frame loops that share the sessions, each with its own core.
        features: at most one of each type.
    """

    host: str = "127.0.0.1"
    port: int = 0
    settings: Settings = field(default_factory=Settings)
    sessions: int | None = None
    key: str | None = None
    allowed_origins: tuple[str, ...] = ()
    embed_origins: tuple[str, ...] = ()
    proof: str = field(default="", repr=False)
    ahead: bool = False
    loops: int = 1
    features: tuple[FeatureOptions, ...] = ()

    def of(self, kind: type[T]) -> T:
        return next((one for one in self.features if isinstance(one, kind)), None) or kind()

    @property
    def shared(self) -> FeatureOptions | None:
        """Options of the feature by which all tabs see one session; None if every tab has its own."""
        return next((one for one in self.features if one.shared_by), None)
