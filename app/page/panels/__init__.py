"""The panels of controls, numbers and plots.

A panel is made by the visitor's `gui` in a container that the caller has opened, and operates their `session` by actions; it adds the
handlers of its own actions to those of the page. `show` draws a frame.
"""

from app.session.frame import Frame


class PagePanel:
    """A panel; it posts what a visitor does to the session, and draws what the frame says."""

    def show(self, frame: Frame) -> None:
        """Bring it up to date."""
        raise NotImplementedError

    @property
    def needs_controls(self) -> bool:
        """True while the page may not leave out the controls that a visitor who just plays does not need."""
        return False

    def close(self) -> None:
        """The page is operated no more: drop what is being made for it."""
