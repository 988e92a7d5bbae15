"""One frame of a session, from what the visitor asked for to what the page draws."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from app.session.clock import BUDGET, Pace
from app.session.contact import Contact, contact
from app.session.session import Session
from app.session.shown import Shown
from app.settings import Settings
from scenes.history import Sample
from scenes.simulation import Simulation
from scenes.targets import Target


@dataclass(frozen=True, eq=False)
class Frame:
    """What every panel and every part of the stage draws at one moment.

    Attributes:
        now: wall time [s].
        shown: the live session, or a moment of a replay.
        simulation, ghost: its run and the second one, for plots that need their histories.
        sample: the newest step.
        settings: of the run that is shown, and of the page.
        pace: how fast it goes.
    """

    now: float
    shown: Shown
    simulation: Simulation
    ghost: Simulation | None
    sample: Sample
    settings: Settings
    pace: Pace

    @property
    def replayed(self) -> bool:
        """Whether this is no live run."""
        return self.shown.replay_time is not None

    @cached_property
    def state(self) -> tuple[object, ...]:
        """All that words and numbers are made of, to compare: two frames of the same state read the same."""
        shown, simulation, ghost = self.shown, self.simulation, self.ghost
        steps = simulation.history.count, ghost is not None and ghost.history.count
        run = simulation, ghost, *steps, self.sample.positions.tobytes(), self.settings, self.pace
        return *run, shown.student_law, shown.replay_time, shown.held is None

    @cached_property
    def contact(self) -> Contact:
        """The line of contact, computed when the first panel asks for it."""
        return contact(self.simulation, self.sample)

    @cached_property
    def target(self) -> Target | None:
        """The target of the source that is active, asked for once."""
        return self.shown.target()


def make_frame(session: Session, decide: Callable[[], None], now: float, elapsed: float, budget: float = BUDGET) -> Frame:
    """Advance a session by one frame, and return what the page draws.

    Args:
        session: what is advanced.
        decide: begins, stops or measures the run where a lesson asks for it.
        now: wall time [s].
        elapsed: wall time since the last frame [s].
        budget: wall time after which no further step is made [s].
    """
    session.take_actions(elapsed)
    decide()
    session.step(elapsed, budget)
    shown: Shown = session
    if session.player is not None:
        session.player.advance(elapsed)
        shown = session.player.past or session
    return freeze(shown, now)


def freeze(shown: Shown, now: float) -> Frame:
    """Return the present moment of a run as a frame. `now`: wall time [s]."""
    simulation = shown.simulation
    return Frame(now, shown, simulation, shown.ghost, simulation.sample(), shown.settings, shown.pace)
