"""One frame of a session."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple, TypeVar

from app.session.clock import BUDGET, FRAME, Pace
from app.session.parts import SessionPart
from app.session.session import Session
from app.session.shown import Shown
from app.settings import Settings
from controllers.kinematics import Array
from scenes.history import Sample
from scenes.simulation import Simulation
from scenes.targets import Target


class Contact(NamedTuple):
    """Avoidance row of the arm that keeps clear, or of both arms if they share a row.

    Attributes:
        row: J_d (n,) [m/rad].
        distance: distance that the law acts on [m].
        pull, approach: u and w along that row [m/s].
        square: |J_d|² [m²/rad²].
        second_square: |J_d|² of the second arm's own row; else 0.
        rate: J_d q̇ [m/s].
        change: ḋ of the law's distance, from everything that moves [m/s].
        true_change: ḋ of the closest pair's true distance [m/s].
    """

    row: Array
    distance: float
    pull: float
    approach: float
    square: float
    second_square: float
    rate: float
    change: float
    true_change: float


def contact(simulation: Simulation, sample: Sample) -> Contact:
    """Contact in the newest step, `sample`; positions are not moved."""
    run = simulation.settings
    near = simulation.near or simulation.detector.detect(*run.law.proximity)
    own, *others = [mover.joints for mover in simulation.roles.avoiders(run.avoid)]
    second_square = 0.0
    if run.one_row:
        own = slice(min(own.start, others[0].start), max(own.stop, others[0].stop))
    elif others:
        second_row = near.row[others[0]]
        second_square = float(second_row.dot(second_row))
    row = near.row[own]
    return Contact(
        row,
        sample.law_distance,
        sample.pull,
        sample.law_approach,
        float(row.dot(row)),
        second_square,
        float(row.dot(sample.velocities[own])),
        float(near.row.dot(sample.velocities)),
        float(near.pair_row.dot(sample.velocities)),
    )


P = TypeVar("P", bound=SessionPart)

LATEST: Final = 3.0
"""Longest wait of a panel [periods]."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Everything that a page draws at one moment.

    Attributes:
        now: wall time [s].
        shown: the live session, or a moment of a replay.
        live: the live session, also during a replay.
        settings: of the shown run, and of the page.
        elapsed: wall time since the last frame [s]; 0 for the first one.
    """

    now: float
    shown: Shown
    live: Shown
    simulation: Simulation
    ghost: Simulation | None
    sample: Sample
    settings: Settings
    pace: Pace
    elapsed: float = 0.0

    def after(self, period: float) -> float:
        """Next time of a panel with this period [s]; later if frames are rare."""
        return self.now + period * min(max(self.elapsed / FRAME, 1.0), LATEST)

    @property
    def replayed(self) -> bool:
        return self.shown.replay.time is not None

    @property
    def of_live(self) -> bool:
        """True for the live run and for its reviewed moments."""
        return self.shown.replay.reviewed or not self.replayed

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        """Run and ghost for plots over time; a reviewed moment gives the whole run."""
        return self.live.traced if self.of_live else self.shown.traced

    def part(self, kind: type[P]) -> P | None:
        """The live session's part; None in an export."""
        return None if self.live.parts is None else self.live.parts.of(kind)

    @cached_property
    def state(self) -> tuple[object, ...]:
        """Two frames with equal states read the same."""
        shown, simulation, ghost = self.shown, self.simulation, self.ghost
        steps = simulation.history.count, ghost is not None and ghost.history.count
        run = simulation, ghost, *steps, self.sample.positions.tobytes(), self.settings, self.pace
        return *run, shown.law_status, shown.replay, shown.held is None

    @cached_property
    def contact(self) -> Contact:
        return contact(self.simulation, self.sample)

    @cached_property
    def target(self) -> Target | None:
        return self.shown.target()


def make_frame(session: Session, now: float, elapsed: float, budget: float = BUDGET) -> Frame:
    """Advance a session by one frame. `now`, `elapsed`, `budget`: wall time [s]; no step begins after
    `budget`."""
    session.take_actions(elapsed)
    for part in session.parts:
        part.decide()
    session.control.step(elapsed, budget)
    session.player.advance(elapsed)
    return freeze(session, now, session.player.past, elapsed)


def freeze(live: Shown, now: float, shown: Shown | None = None, elapsed: float = 0.0) -> Frame:
    """Present moment of a run, see `Frame`. `live`: the session, or its stand-in; `shown`: None for
    `live`."""
    shown = shown or live
    simulation, ghost = shown.simulation, None if live.ghost_hidden else shown.ghost
    return Frame(
        now, shown, live, simulation, ghost, simulation.sample(), shown.settings, shown.pace, elapsed
    )
