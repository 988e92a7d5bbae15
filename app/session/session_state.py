"""Where a session is, as plain data from which another one can go on."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from app.session.clock import Reason
from controllers.kinematics import Array
from scenes.inputs import Recorded
from scenes.settings import RunSettings
from scenes.simulation import Simulation, Snapshot

LASTING: Final[tuple[Reason, ...]] = ("visitor", "lesson")
"""Reasons for a halt that go on in another session; the others are set again by their authors."""

PART: Final = 16
"""Steps that are made again at a time."""


@dataclass(frozen=True)
class RunState:
    """Where one run is.

    Attributes:
        pieces: what it was made with, in order; they lead to the snapshot.
    """

    snapshot: Snapshot
    pieces: tuple[Recorded, ...] = ()


@dataclass(frozen=True)
class SessionState:
    """Where a session is, besides its settings.

    Attributes:
        frozen: run settings with the law, gain and hardware that a frozen ghost keeps.
        halted: why the run stands still, if it does.
        source: when the source of targets began [s], and where q (nv,) was then; None for none.
    """

    run: RunState
    ghost: RunState | None
    frozen: RunSettings
    halted: tuple[Reason, ...] = ()
    source: tuple[float, Array] | None = None


def common_pieces(state: SessionState, seconds: float) -> tuple[tuple[Recorded, ...], tuple[Recorded, ...]]:
    """Return the newest pieces of the run and of its ghost that begin at the same time; two empty tuples if there are none.

    Args:
        seconds: how far back they reach at most [s].
    """
    earliest = state.run.snapshot.time - seconds - 1e-6
    run = tuple(piece for piece in state.run.pieces if piece.begin >= earliest)
    if state.ghost is None or not run:
        return run, ()
    begins = {piece.snapshot.steps for piece in state.ghost.pieces}
    first = next((i for i, piece in enumerate(run) if piece.snapshot.steps in begins), len(run))
    run = run[first:]
    return run, tuple(piece for piece in state.ghost.pieces if run and piece.snapshot.steps >= run[0].snapshot.steps)


def resumed(simulation: Simulation, state: RunState, pieces: tuple[Recorded, ...]) -> Iterator[None]:
    """Bring a simulation to a state; with pieces its history is made again from their beginning. Yields every `PART` steps."""
    settings = simulation.settings
    if pieces:
        simulation.apply(pieces[0].settings)
        simulation.resume(pieces[0].snapshot)
        for target in itertools.chain.from_iterable(piece.targets(simulation) for piece in pieces):
            simulation.step(target)
            if simulation.steps % PART == 0:
                yield
        simulation.apply(settings)
    if not pieces or simulation.positions.tobytes() != state.snapshot.positions.tobytes():
        simulation.resume(state.snapshot)
