"""What every panel of controls can do."""

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
