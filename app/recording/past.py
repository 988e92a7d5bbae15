"""A moment of the past in the place of the session: what a page reads from a session in order to draw it."""

from dataclasses import replace

from app.recording.replay import Replay
from app.session.clock import Pace
from app.session.session import Session
from app.session.trade_off import TradeOffMap
from app.settings import Settings
from scenes.simulation import Simulation
from scenes.targets import Target


class Past:
    """What can be seen of a session, at the moment where a replay stands. Nobody holds anything there, and nothing is computed beside it.

    Args:
        replay: where it stands.
        settings: of the live session; the page stays as it is, the run is that of the past.
        trade_off: of the live session.
    """

    ghost = held = what_if = smoothness = custom_law = own_ghost = custom_law_slow = None
    computing = custom_law_away = custom_law_waits = False
    study_message = custom_law_problem = ""

    def __init__(self, replay: Replay, settings: Settings, trade_off: TradeOffMap | None = None) -> None:
        self._replay, self._live, self.trade_off = replay, settings, trade_off

    @property
    def simulation(self) -> Simulation:
        """As it was."""
        return self._replay.simulation

    @property
    def settings(self) -> Settings:
        """Those of the run then, with those of the page now."""
        return replace(self._live, run=self._replay.simulation.settings, page=replace(self._live.page, ghost="off"))

    @property
    def paused(self) -> bool:
        """Whether the replay rests."""
        return not self._replay.playing

    @property
    def pace(self) -> Pace:
        """How fast the replay goes."""
        return Pace(self.paused, self._replay.speed, False)

    def target(self) -> Target | None:
        """Return what the person wanted then."""
        return self._replay.target

    @property
    def time(self) -> float:
        """The moment [s], on the clock of the run."""
        return self._replay.time


Shown = Session | Past
"""What a page draws: the live run, or a moment of the past."""
