"""The visitor's hand on a run."""

from dataclasses import replace
from typing import Protocol

from app.session.actions import Action
from app.session.input_source import InputSource, nudged
from app.settings import Settings
from controllers.kinematics import Arm, Array
from scenes.roles import TargetSource
from scenes.run_text import on_grid
from scenes.simulation import Simulation
from scenes.targets import HandTarget, HeldTarget, LinkTarget, PairTarget, Target


class Held(Protocol):
    settings: Settings
    simulation: Simulation

    def post(self, action: Action) -> None: ...

    def change(self, key: str, value: object) -> None: ...


class VisitorHand:
    """The visitor as a holder of handles, see `app.page.handles.holder.Holder`.

    Attributes:
        other: target of the arm that keeps its place, or None.
        on_grid: True rounds held points to the grid of `scenes.run_text`, so that the run fits into a link.
    """

    def __init__(self, session: Held) -> None:
        self._session = session
        self.source = InputSource()
        self.other: HeldTarget | None = None
        self.on_grid = False

    @property
    def settings(self) -> Settings:
        return self._session.settings

    @property
    def simulation(self) -> Simulation:
        return self._session.simulation

    @property
    def arm(self) -> Arm:
        return self._session.simulation.guided

    @property
    def held(self) -> Target | None:
        return self.source.held

    def hold(self, target: Target | None) -> None:
        """Hold a target, which stops the autopilot; None releases it."""
        if target is not None:
            self._let_autopilot(False)
        self.source.held = on_grid(target) if self.on_grid else target

    def nudge(self, way: Array) -> None:
        """Move the point at which the person holds the hand, or the ball.

        `way`: (3,), world [m]; ignored if a person is imitated.
        """
        held = nudged(self.simulation, self.arm, self.held, way)
        if held is not None:
            self.hold(held)

    def post(self, action: Action) -> None:
        self._session.post(action)

    def set_source(self, source: TargetSource | None) -> None:
        """Take the target from a file or a camera; None for the experiment's own source."""
        self.source.set_source(source)
        if source is not None:
            self._let_autopilot(True)

    def choose_source(self, name: str) -> None:
        self._session.change("source", name)

    def let_go(self) -> None:
        self.source.let_go()
        self.other = None

    def target(self) -> Target | None:
        """Target of the source and of the other arm; None for no change."""
        target = self.source.target(self.simulation, self.settings.page.autopilot)
        if self.other is None or not self.settings.run.experiment.for_two:
            return target
        return PairTarget(target if isinstance(target, (HandTarget, LinkTarget)) else None, self.other)

    def way(self, seconds: float) -> Array:
        """See `InputSource.way`."""
        return self.source.way(self.simulation, self.settings.page.autopilot, seconds)

    def _let_autopilot(self, on: bool) -> None:
        settings = self._session.settings
        if settings.page.autopilot is not on:
            self._session.settings = replace(settings, page=replace(settings.page, autopilot=on))
