"""What all parts of the stage have in common."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import viser

from app.session.frame import Frame
from app.settings import PageSettings


class StagePart(ABC):
    """Something on the stage, drawn in the scene that it is made with.

    Attributes:
        nodes: what is drawn, and taken out of the scene together.
    """

    nodes: Sequence[viser.SceneNodeHandle] = ()

    def dress(self, page: PageSettings) -> None:  # noqa: B027 (some look the same in every theme)
        """Take on a theme and a profile."""

    @abstractmethod
    def show(self, frame: Frame) -> None:
        """Draw a frame."""

    def remove(self) -> None:
        """Take it out of the scene."""
        for node in self.nodes:
            node.remove()
