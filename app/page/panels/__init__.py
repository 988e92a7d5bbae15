"""The panels of controls, numbers and plots.

A panel is made by the visitor's `gui` in a container that the caller has opened, and operates their `session`; `show` draws a frame.
"""

from app.session.actions import Action
from app.session.frame import Frame


class PagePanel:
    """A panel; it posts what a visitor does to the session, and draws what the frame says."""

    def take(self, action: Action) -> bool:
        """Do an action if it is about this panel; return whether it was."""
        del action
        return False

    def show(self, frame: Frame) -> None:
        """Bring it up to date."""
        raise NotImplementedError
