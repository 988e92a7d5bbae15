"""A moment of a replay in the place of the session."""

from dataclasses import replace

import numpy as np

from app.recording.replay import Replay
from app.session.clock import Pace
from app.session.safety_curves import SafetyCurves
from app.session.student_law import LawStatus
from app.session.trade_off import TradeOffMap
from app.settings import Settings
from controllers.kinematics import Array
from scenes.simulation import Simulation
from scenes.targets import Target


class Past:
    """A replay as a page reads it, see `app.session.shown.Shown`: nothing is held there, and nothing is computed beside it.

    Args:
        replay: where it stands.
        settings: of the live session; the page stays as it is, the run is that of the replay.
        trade_off, safety_curves: of the live session.
        file: name of the loaded file that is replayed; "" for the session's own run.
    """

    ghost = held = what_if = magnified = None
    student_law = LawStatus()

    def __init__(
        self,
        replay: Replay,
        settings: Settings,
        trade_off: TradeOffMap | None = None,
        safety_curves: SafetyCurves | None = None,
        file: str = "",
    ) -> None:
        self._replay, self._live, self.replayed_file = replay, settings, file
        self.trade_off, self.safety_curves = trade_off, safety_curves

    @property
    def simulation(self) -> Simulation:
        return self._replay.simulation

    @property
    def settings(self) -> Settings:
        """Those of the run then, with those of the page now."""
        return replace(self._live, run=self._replay.simulation.settings, page=replace(self._live.page, ghost="off"))

    @property
    def pace(self) -> Pace:
        return Pace(not self._replay.playing, self._replay.speed, False)

    @property
    def replay_time(self) -> float:
        return self._replay.time

    def target(self) -> Target | None:
        return self._replay.target

    def way(self, seconds: float) -> Array:
        """Return (0, 3): the replay goes where it is sent."""
        del seconds
        return np.zeros((0, 3))
