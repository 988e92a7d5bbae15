"""A feature's state for a whole server, such as a device."""

from collections.abc import Sequence

from app.page.panel_context import PanelMaker
from app.session.late_law import LateLawMaker


class OpenedFeature:
    """A feature's state that all sessions of a server share.

    Attributes:
        panels: makers of panels that use this state.
        law: makes each session's late law, or None.
    """

    panels: Sequence[PanelMaker] = ()
    law: LateLawMaker | None = None

    def close(self) -> None:
        """Release what is open; may be called again."""
