"""What a page can show: the live session, or a moment of a replay in its place."""

from typing import Protocol

from app.session.clock import Pace
from app.session.studies import Smoothness
from app.session.trade_off import TradeOffMap
from app.settings import Settings
from scenes.rerun import WhatIf
from scenes.simulation import Simulation
from scenes.targets import Target


class Shown(Protocol):
    """A run as a page reads it."""

    @property
    def simulation(self) -> Simulation:
        """The run, with its history."""
        ...

    @property
    def ghost(self) -> Simulation | None:
        """The second run beside it."""
        ...

    @property
    def settings(self) -> Settings:
        """Of the run that is shown, and of the page."""
        ...

    @property
    def pace(self) -> Pace:
        """How fast it goes."""
        ...

    @property
    def held(self) -> Target | None:
        """What the visitor holds."""
        ...

    @property
    def replay_time(self) -> float | None:
        """The moment that is replayed, on the clock of the run [s]; None while live."""
        ...

    @property
    def replayed_file(self) -> str:
        """Name of the loaded file that is replayed; "" for the session's own run."""
        ...

    @property
    def custom_law(self) -> str | None:
        """Name of the file of the law that runs instead of the settings' law."""
        ...

    @property
    def own_ghost(self) -> str | None:
        """Name of the file of the ghost's law."""
        ...

    @property
    def custom_law_problem(self) -> str:
        """Why the student's law is not in force; "" if all is well."""
        ...

    @property
    def custom_law_away(self) -> bool:
        """Whether the file of the student's law is gone."""
        ...

    @property
    def custom_law_waits(self) -> bool:
        """Whether the run waits for the student's law."""
        ...

    @property
    def custom_law_slow(self) -> tuple[float, float] | None:
        """How long a call of the student's law takes, and how long it may in real time [s]; None unless it slows down the run."""
        ...

    @property
    def what_if(self) -> WhatIf | None:
        """How the last part would have gone with the present settings."""
        ...

    @property
    def smoothness(self) -> Smoothness | None:
        """What was measured of the steps of q̇."""
        ...

    @property
    def trade_off(self) -> TradeOffMap | None:
        """Distance against error over n and v."""
        ...

    def target(self) -> Target | None:
        """Return the active source's target, or None."""
        ...


class Player(Protocol):
    """Replays a recorded run in the place of the live one."""

    @property
    def past(self) -> Shown | None:
        """The moment that is replayed; None while live."""
        ...

    def advance(self, elapsed: float) -> bool:
        """Play for `elapsed` [s] of wall time; return whether another moment is shown."""
        ...

    def leave(self) -> None:
        """Go back to live."""
        ...
