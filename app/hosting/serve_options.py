"""Options of a server; imports nothing slow."""

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
        """Option by which all tabs share a session, such as `--exhibit`; "" if every tab has its own."""
        return ""

    @property
    def most_pages(self) -> int | None:
        """Limit of open pages; None for the number of private sessions."""
        return None

    @property
    def one_process(self) -> str:
        """Reason why one process must serve all pages; "" if several can."""
        return ""

    def check(self) -> None:
        """Check these options; raises `BadSetting`."""

    def held(self, port: int, until: ExitStack) -> Self:
        """Take resources, such as a file's lock; returns the options to serve with.

        Raises:
            DuetError: another server has them.
        """
        del port, until
        return self

    def fits(self, options: "ServeOptions") -> None:
        """Check the combination; raises `BadSetting`."""

    def said_at_start(self, host: str, port: int, places: int) -> tuple[str, ...]:
        """Lines printed at the start. `places`: private sessions."""
        del host, port, places
        return ()


@dataclass(frozen=True)
class ServeOptions:
    """How the page is served.

    Attributes:
        port: 0 for any free one.
        settings: of a link without a query.
        glides_as_usual: arms glide on a usual page.
        sessions: private sessions at once; None for this machine's capacity.
        allowed_origins: web addresses of other pages that may connect.
        embed_origins: web addresses of pages that may show ours in a frame.
        proof: of a notebook server, see `app.web.origin_policy.PROOF`, or "".
        ahead: prepare slow things at the start.
        loops: frame loops, a core each.
        features: at most one of each type.
    """

    host: str = "127.0.0.1"
    port: int = 0
    settings: Settings = field(default_factory=Settings)
    glides_as_usual: bool = True
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
        return next((one for one in self.features if one.shared_by), None)
