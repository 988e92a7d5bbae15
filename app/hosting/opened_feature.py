"""What a feature opens once for a whole server, such as a device."""

from collections.abc import Sequence

from app.page.panel_context import PanelMaker


class OpenedFeature:
    """State of a feature that all sessions of one server share.

    Attributes:
        panels: makers of panels that use this state.
    """

    panels: Sequence[PanelMaker] = ()

    def close(self) -> None:
        """Release what is open; may be called again."""
