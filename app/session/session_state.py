"""Saved state of a session."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from app.session.clock import Reason
from app.session.session import Session
from controllers.kinematics import Array
from scenes.inputs import Recorded
from scenes.settings import RunSettings
from scenes.simulation import Simulation, Snapshot

LASTING: Final[tuple[Reason, ...]] = ("visitor", "lesson")
"""Restored reasons for a halt; the owners of the others set them again."""

PART: Final = 16


@dataclass(frozen=True)
class RunState:
    """State of one run. `pieces`: recorded inputs in order, up to the snapshot."""

    snapshot: Snapshot
    pieces: tuple[Recorded, ...] = ()


@dataclass(frozen=True)
class SessionState:
    """State of a session, except its settings.

    Attributes:
        frozen: see `GhostRun.frozen`.
        source: see `InputSource.began`.
    """

    run: RunState
    ghost: RunState | None
    frozen: RunSettings
    halted: tuple[Reason, ...] = ()
    source: tuple[float, Array] | None = None
    opening: bool = False


def common_pieces(state: SessionState, seconds: float) -> tuple[tuple[Recorded, ...], tuple[Recorded, ...]]:
    """Newest pieces of run and ghost with a common beginning, at most `seconds` long; perhaps empty."""
    earliest = state.run.snapshot.time - seconds - 1e-6
    run = tuple(piece for piece in state.run.pieces if piece.begin >= earliest)
    if state.ghost is None or not run:
        return run, ()
    begins = {piece.snapshot.steps for piece in state.ghost.pieces}
    first = next((i for i, piece in enumerate(run) if piece.snapshot.steps in begins), len(run))
    run = run[first:]
    return run, tuple(
        piece for piece in state.ghost.pieces if run and piece.snapshot.steps >= run[0].snapshot.steps
    )


def resumed(simulation: Simulation, state: RunState, pieces: tuple[Recorded, ...]) -> Iterator[None]:
    """Restore a simulation, with pieces also its history. Yields every `PART` steps."""
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


def state_of(session: Session) -> SessionState:
    ghost, run = None, session.ghost_run
    if run.simulation is not None and run.source is None:
        ghost = RunState(*run.inputs.cut(run.simulation))
    halted: tuple[Reason, ...] = tuple(reason for reason in LASTING if reason in session.control.halt)
    own = RunState(*session.inputs.cut(session.simulation))
    source = session.hand.source
    return SessionState(own, ghost, run.frozen, halted, source.began, source.opening)


def go_on_from(session: Session, state: SessionState, history: float = 0.0) -> Iterator[None]:
    """Continue from a saved state with the same settings; yields every few steps. `history`: length of the
    recomputed curves [s]."""
    ghost = session.ghost_run
    run, beside = (
        common_pieces(state, history) if session.law.of_run is session.law.of_ghost is None else ((), ())
    )
    ghost.frozen = state.frozen
    ghost.begin(session.settings, session.simulation)
    session.hand.source.resume(session.simulation, state.source, state.opening)
    yield from resumed(session.simulation, state.run, run)
    session.inputs.restore(state.run.pieces, session.simulation)
    if ghost.simulation is not None:
        state_beside = RunState(session.simulation.snapshot()) if state.ghost is None else state.ghost
        yield from resumed(ghost.simulation, state_beside, beside)
        ghost.inputs.restore(state_beside.pieces, ghost.simulation)
    session.control.halt.clear()
    session.control.halt.update(state.halted)
    session.control.forget()
