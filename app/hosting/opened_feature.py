"""Shared state of a feature."""

from collections.abc import Sequence

from app.page.panel_context import PanelMaker
from app.session.late_law import LateLawMaker


class OpenedFeature:
    """State that all sessions of a server share, such as a device; `panels` make panels that use it."""

    panels: Sequence[PanelMaker] = ()
    law: LateLawMaker | None = None

    def close(self) -> None:
        """Release it; may be called again."""
