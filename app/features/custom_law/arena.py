"""Runs and situations for the tests, with the product's scenes, bounds and integration."""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Final, Literal, Protocol

import numpy as np

from app.features.custom_law.law_limits import LawProblem
from controllers.errors import LazyText
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.experiments import HOLD, SOLO
from scenes.history import COLUMN
from scenes.laws import NO_AVOIDANCE
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from scenes.targets import HandTarget, Target

PIECES: Final = 48


@dataclass(frozen=True)
class TrialCurve:
    """Worst value in each of `PIECES` parts of a run.

    Attributes:
        quantity: "d" [m], "e" [m] or "dq_step" [rad/s].
        seconds: length of the run.
        lines: name or "" → values [SI]; None for infinity.
    """

    quantity: Literal["d", "e", "dq_step"]
    seconds: float
    limit: float | None
    lines: dict[str, list[float | None]]


@dataclass(frozen=True)
class TrialResult:
    """Result of a test.

    Attributes:
        reason: condition, and its margin.
        line: 1-based line of the file where it failed.
        as_template: true if all answers so far are those of the template's law.
    """

    name: str
    passed: bool
    reason: str
    curve: TrialCurve | None = None
    line: int | None = None
    as_template: bool = False


def worst_values(values: Array, least: bool = False) -> list[float | None]:
    """Largest (or least) value in each of `PIECES` parts of (steps,); None for infinity."""
    edges = np.linspace(0, len(values), PIECES + 1)
    parts = [values[int(a) : max(int(b), int(a) + 1)] for a, b in itertools.pairwise(edges)]
    found = [float((part.min() if least else part.max()) if len(part) else math.inf) for part in parts]
    return [value if math.isfinite(value) else None for value in found]


def distance_curve(table: Array) -> TrialCurve:
    """d over a run. `table`: (steps, columns of `scenes.history`)."""
    d, seconds = table[:, COLUMN["d"]], float(table[-1, COLUMN["t"]])
    return TrialCurve("d", seconds, CRITICAL_DISTANCE, {"": worst_values(d, least=True)})


def error_curve(table: Array, limit: float) -> TrialCurve:
    e, seconds = np.sqrt(table[:, COLUMN["e2"]]), float(table[-1, COLUMN["t"]])
    return TrialCurve("e", seconds, limit, {"": worst_values(e)})


class Candidate(Law, Protocol):
    """A law that may fail. `seconds`: duration of its last call."""

    @property
    def problem(self) -> LawProblem | None: ...

    @property
    def seconds(self) -> float: ...


CRITICAL_DISTANCE: Final = 0.15
"""d_m [m]."""

DT: Final = 0.005
"""Time step [s]."""

FAR: Final = 2.5
"""Distance of a far obstacle [d_m]."""

DEPTH: Final = 0.05
"""Initial overlap of the arms [m]."""

LENGTHS: Final = (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-6, 0.0)
"""|J_d| near a singularity [m/rad]."""

TOP_SPEED: Final = 1.92
"""Top speed of the joints [rad/s], the LWR's slowest."""

PATIENCE: Final = 10.0
"""Time for all calls of a run [s]."""


class TrialStopped(Exception):
    """The law failed or is too slow. `curve`: of the run so far."""

    curve: TrialCurve | None = None
    line: int | None = None


def enter(scene: str, law: Candidate | None, dt: float = DT, path: str = "stay") -> Simulation:
    """Experiment at its start; unprotected without a law."""
    unprotected = LawSettings(law=NO_AVOIDANCE, critical_distance=CRITICAL_DISTANCE)
    simulation = Simulation(RunSettings(scene=scene, dt=dt, path=path, law=unprotected))  # pyright: ignore[reportArgumentType]
    if law is not None:
        simulation.law = law
    return simulation


def play(simulation: Simulation, law: Candidate, targets: Iterable[Target | None]) -> Array:
    """History's table after one step for each target.

    Raises:
        TrialStopped: the law failed or is too slow.
    """
    taken = 0.0
    try:
        for target in targets:
            simulation.step(target)
            stop_if_failed(law)
            taken += law.seconds
            if taken > PATIENCE:
                raise TrialStopped(
                    LazyText(
                        "stopped after {time:.2f} s of the run: a call takes {taken:.3g} ms.",
                        time=simulation.time,
                        taken=taken / simulation.steps * 1e3,
                    )
                )
    except TrialStopped as stopped:
        table = simulation.history.table()
        if len(table) > 1 and np.isfinite(table[:, COLUMN["d"]]).any():
            stopped.curve = distance_curve(table)
        raise
    return simulation.history.table()


def stop_if_failed(law: Candidate) -> None:
    if law.problem is not None:
        stopped = TrialStopped(law.problem.text)
        stopped.line = law.problem.line
        raise stopped


def largest_error(table: Array) -> float:
    """Largest |e| of a run [m]."""
    return float(table[:, COLUMN["e2"]].max()) ** 0.5


@cache
def error_of_the_task_alone() -> float:
    """Largest |e| in 2 s of the circle without an obstacle [m]."""
    simulation = enter(SOLO, None, path="circle")
    for _ in range(round(2.0 / DT)):
        simulation.step(None)
    return largest_error(simulation.history.table())


def put_the_ball_away(simulation: Simulation) -> None:
    ball = simulation.room.ball
    assert ball is not None
    q = simulation.positions.copy()
    hand = simulation.kinematics.hand_pose(simulation.avoiding).translation.copy()
    way = hand - q[ball]
    way /= np.linalg.norm(way)
    distance = 0.0
    q[ball] = hand
    for _ in range(20):
        # The ball has a radius, and the hand has none: the distance is measured, not computed.
        q[ball] += way * (FAR * CRITICAL_DISTANCE - distance)
        simulation.reset(q)
        distance = simulation.sample().distance
    assert math.isclose(distance, FAR * CRITICAL_DISTANCE, abs_tol=1e-6)


@cache
def overlapping() -> tuple[float, ...]:
    """Posture q (nv,) in which the arms overlap by `DEPTH`."""
    simulation = enter(HOLD, None)
    goal = HandTarget(simulation.kinematics.hand_pose(simulation.avoiding).translation.copy())
    while simulation.sample().distance > -DEPTH:
        simulation.step(goal)
    return tuple(simulation.positions.tolist())


@cache
def hard_situations() -> tuple[Situation, ...]:
    """Situations with ever smaller |J_d|, and at distances where 1/d fails."""
    signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    row, J = signs / math.sqrt(7.0), np.random.default_rng(1).uniform(-0.5, 0.5, (3, 7))
    # The task pulls towards the obstacle, and elsewhere.
    nominal = -0.1 * signs
    nominal[:2] = 0.05
    bound = np.full(7, TOP_SPEED)

    def at(length: float, distance: float) -> Situation:
        near = np.array([distance]), np.zeros(1)
        return Situation(
            np.zeros(7),
            nominal,
            row * length,
            distance,
            0.0,
            J,
            -bound,
            bound,
            (row * length)[None, :],
            *near,
        )

    return (*(at(length, d) for length in LENGTHS for d in (0.10, 0.0, -0.05, 0.2)), at(0.0, math.inf))
