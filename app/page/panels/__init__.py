"""Panels of controls, numbers and plots.

A panel uses the visitor's `gui` in a container that the caller has opened, operates the `session` by actions,
and adds their handlers to the page's.
"""

from app.session.frame import Frame


class PagePanel:
    """Posts a visitor's actions to the session, and draws frames."""

    def show(self, frame: Frame) -> None:
        raise NotImplementedError

    @property
    def needs_controls(self) -> bool:
        """True while all controls must be shown, also to a playing visitor."""
        return False

    def close(self) -> None:
        """Drop unfinished work: the page is no longer operated."""
