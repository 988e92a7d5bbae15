"""Panels of controls, numbers and plots, made in the container that the caller has opened."""

from app.session.frame import Frame


class PagePanel:
    """Panel of an operator's page."""

    def show(self, frame: Frame) -> None:
        raise NotImplementedError

    @property
    def needs_controls(self) -> bool:
        """True while all controls must be shown, also to a playing visitor."""
        return False

    def close(self) -> None:
        """Drop unfinished work."""
