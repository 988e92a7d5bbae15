"""The person who is imitated, taken hold of at an upper arm, a forearm or a hand."""

from typing import get_args

import numpy as np

from app.page.handles.grips import Grip
from app.session.session import Session
from app.stage.person_figure import FigureView, on_person
from controllers.kinematics import Array
from scenes.person.figure import Figure, Grasp
from scenes.settings import ArmName
from scenes.targets import AnglesTarget


class FigureGrip(Grip):
    """A pull makes the figure the person who is imitated; it stays as it was pulled."""

    def __init__(self, view: FigureView, session: Session) -> None:
        self._limbs: dict[str, tuple[ArmName, bool]] = {
            view.parts[f"{side}_{limb}"].name: (side, limb == "forearm")
            for side in get_args(ArmName)
            for limb in ("upper_arm", "forearm")
            if view.parts
        }
        super().__init__((part for part in view.parts.values() if part.name in self._limbs), session)
        self._session, self._view = session, view
        self._figure: Figure | None = None
        self._grasp: Grasp | None = None

    def _take(self, name: str, point: Array) -> None:
        session = self._session
        if session.settings.page.source != "figure":
            session.change("source", "figure")
            self._begin()
        assert self._figure is not None
        self._grasp = self._figure.grasp(*self._limbs[name], on_person(point))

    def _pull(self, place: Array) -> None:
        assert self._figure is not None and self._grasp is not None
        self._figure.pull(self._grasp, on_person(place))
        if not self._session.settings.page.autopilot:
            # A pull makes it the source again.
            self._session.set_source(self)

    def _let_go(self) -> None:
        self._grasp = None

    def _begin(self) -> None:
        """Become the source, standing as the person stands who is drawn."""
        drawn = self._view.angles
        self._figure = Figure(drawn) if np.isfinite(drawn).all() else Figure()
        self._session.set_source(self)

    def target(self, time: float) -> AnglesTarget:
        """Return how the figure's arms are, at any time."""
        return AnglesTarget(None if self._figure is None else self._figure.angles(time))

    def show(self) -> None:
        """Begin where the settings have made it the source, and end where they have chosen another one."""
        chosen = self._session.settings.page.source == "figure"
        if chosen and self._figure is None:
            self._begin()
        elif not chosen:
            self._figure = None

    def forget_drag(self) -> None:
        """Stand as at the start, with nothing pulled."""
        super().forget_drag()
        if self._figure is not None:
            self._figure.reset()

    def remove(self, nodes_stay: bool) -> None:
        """Make the figure plain again, and take it out of another experiment."""
        super().remove(nodes_stay)
        if self._figure is not None and self._session.settings.run.experiment.moves != "person":
            self._session.set_source(None)
