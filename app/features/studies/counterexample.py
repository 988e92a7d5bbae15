"""A search for a counterexample: the run in which d_law falls farthest below d_m although the promise's
conditions hold.

Inputs, obstacle and posture decide over w ≤ v, J_d regular and no joint at its limit, see `scenes.promise`;
the closest pair depends on the law's distance, so a run in which only that condition fails counts. One
differentiable distance keeps the promise under the first three. The closest of several pairs need not: where
an arm slides along the tie of two pairs and the retreats oppose each other, it holds each of them and loses
both.

So each search climbs from a random posture to such a tie. Scripted inputs continue from there along a few
random ways, and the simplex of Nelder & Mead (1965) varies start posture, way and speed together to find the
largest loss.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from time import monotonic
from typing import Final, Literal, NamedTuple

import numpy as np

from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS, Moved
from scenes.headless import MOST_STEPS
from scenes.history import COLUMN, History
from scenes.inputs import InputsLog, Recorded
from scenes.person.clips import REST
from scenes.promise import Condition, fallen, missing
from scenes.roles import room_of, scenario_of
from scenes.room import Room, World, random_bounds
from scenes.settings import HardwareSettings, RunSettings, specs
from scenes.simulation import Simulation
from scenes.targets import SIZES, Waypoints
from scenes.wanted import check_wanted

SECONDS: Final = 6.0
"""Simulated time of a run [s]."""

BROKEN: Final = 1e-4
"""Smallest loss that breaks the promise [m], at dt and at dt / `FINER`."""

FINER: Final = 4
"""Divisor of dt in a candidate's second run."""

LEGS: Final = 2
"""Number of segments between waypoints."""

WAYS: Final = 3
"""Random ways per start posture."""

CLIMB: Final = 300
"""Postures tried to find a start."""

NEAR: Final = 0.03
"""Length scale of the distances while a start is sought [m]."""

AHEAD: Final = 0.01
"""Desired margin of the nearest pair above d_m at the start [m]."""

NEARBY: Final = 0.3
"""How far a way that comes near an arm goes from it, along each axis [m]."""

FAR: Final = 0.8
"""How far a way goes that draws a hand to its reach, or brings a wall, along each axis [m, rad]."""

FIRM: Final = 0.4
"""|J_d| below which a pair is ignored at the start [m/rad]."""

REFINEMENTS: Final = 60
"""Refinement runs per candidate."""

INTEREST: Final = 1e-3
"""Refine candidates that lose more than this [m]."""

EVERY: Final = 8
"""Also refine every n-th start."""

CORNER: Final = 0.05
"""Edge of the first simplex [rad, m, m/s]."""

DIGITS: Final = 4
"""Decimals of start and way: 0.1 mrad and 0.1 mm."""

FARTHEST: Final = 10.0
"""Largest accepted number of a start or a way [rad, m]."""

BLAMED: Final = (Condition.SPEED, Condition.LEVER, Condition.BOUND)
"""Conditions that inputs, obstacle or posture can break."""


@dataclass(frozen=True)
class Attack:
    """A run that may break the promise.

    Attributes:
        start: q (nv,) [rad, m].
        points: waypoints (k, size), see `Waypoints`; the first is the start.
    """

    settings: RunSettings
    start: Array
    points: Array

    def text(self) -> str:
        """Start and way in the format of a link; see `attack_of`."""
        return ",".join(f"{number:.{DIGITS}f}" for number in (*self.start, *self.points.ravel()))

    def table(self, finer: int = 1) -> Array:
        """History of the run (rows, columns of `scenes.history`) at dt / `finer`."""
        return _made(self, replace(self.settings, dt=self.settings.dt / finer)).table()


def attack_of(settings: RunSettings, text: str) -> Attack:
    """Parse `Attack.text` from a link.

    Raises:
        BadSetting: invalid text, or of another scene.
    """
    check(settings)
    low, high = _box(room_of(settings))
    size, words = SIZES[_moved(settings)], text.split(",")
    count = len(low) + (LEGS + 1) * size
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        numbers = np.array([np.nan])
    if len(numbers) != count or not np.isfinite(numbers).all() or np.abs(numbers).max() > FARTHEST:
        raise BadSetting(
            "attack: needs {count} numbers, start posture and way; copy the link again.", count=count
        )
    start = numbers[: len(low)]
    if (start < low).any() or (start > high).any():
        raise BadSetting("attack: the start posture is outside the joints' limits; copy the link again.")
    return Attack(settings, start, numbers[len(low) :].reshape(LEGS + 1, size))


def replayed(attack: Attack) -> Recorded:
    """Recording of an attack; takes as long as the run."""
    log = InputsLog()
    _made(attack, attack.settings, log)
    recorded = log.window(SECONDS)
    assert recorded is not None
    return recorded


def _moved(settings: RunSettings) -> Moved | Literal["wall"]:
    """What moves along the way: a wall comes to the arm, as the faster one of both."""
    return settings.experiment.moves if room_of(settings).wall is None else "wall"


def _made(attack: Attack, settings: RunSettings, log: InputsLog | None = None) -> History:
    steps = round(SECONDS / settings.dt)
    simulation = Simulation(settings, steps)
    simulation.reset(attack.start)
    person = Waypoints(_moved(settings), attack.points, settings.hand_speed)
    for _ in range(steps):
        target = person.target(simulation.time)
        if log is not None:
            log.record(simulation, target)
        simulation.step(target)
    return simulation.history


def _box(room: Room) -> tuple[Array, Array]:
    """Bounds of a start posture (nv,) [rad, m], in whole units of its text."""
    low, high = random_bounds(room)
    unit = 10.0**DIGITS
    return np.ceil(low * unit) / unit, np.floor(high * unit) / unit


class Loss(NamedTuple):
    """Loss of a run below d_m in one interval [m].

    Attributes:
        lost: with all of `BLAMED` kept; if it exceeds `BROKEN`, its `lasting` part.
        strict: the same while one pair was also the closest.
        nearest: smallest d_law − d_m ≥ 0 while `BLAMED` are kept, or ∞.
        missing: one of `BLAMED` → loss while no other was missing.
    """

    lost: float
    strict: float
    nearest: float
    missing: dict[Condition, float]


@dataclass(frozen=True)
class Found:
    """Worst run of one start. `runs`: number of runs; `missing`: largest loss of all runs, as in `Loss`."""

    attack: Attack
    loss: Loss
    missing: dict[Condition, float]
    runs: int

    @property
    def badness(self) -> tuple[float, float]:
        """Sort key, larger for a worse run: its loss, then how near it comes."""
        return self.loss.lost, -self.loss.nearest


def lasting(lost: float, finer: float) -> float:
    """Loss that remains at any time step, from losses at dt and dt / `FINER` [m]: a part proportional to dt
    is the step's own.
    """
    limit = (FINER * finer - lost) / (FINER - 1)
    return max(min(lost, finer, limit), 0.0)


def check(settings: RunSettings) -> None:
    """Raise `BadSetting` if these settings leave nothing to search for."""
    if settings.experiment.obstacle == "nothing":
        scenes = ", ".join(name for name, one in EXPERIMENTS.items() if one.obstacle != "nothing")
        raise BadSetting(
            "Nothing is in the way in the scene {scene}; choose from {scenes}.",
            scene=settings.scene,
            scenes=scenes,
        )
    if settings.hardware != HardwareSettings():
        keys = ", ".join(specs(HardwareSettings))
        raise BadSetting("The promise is made for an ideal robot; leave out {keys}.", keys=keys)
    if settings.experiment.obstacle == "task" and (problem := Simulation(settings).start_problem) is not None:
        raise problem
    assert SECONDS / specs()["dt"].low * FINER < MOST_STEPS


def searched(settings: RunSettings, seed: int, index: int, until: float = np.inf) -> Found:
    """Search from one start, which a seed and an index determine.

    Args:
        until: end of the refinement on the clock `time.monotonic` [s].

    Raises:
        Stopped: before a run, see `scenes.wanted`.
    """
    return _Search(settings, np.random.default_rng([seed, index]), until).found(index % EVERY == EVERY - 1)


class _OutOfTime(Exception):
    """Ends a simplex."""


class _Search:
    """Search from one start. Its variables (nv + `LEGS` · size + 1,) are start posture, way and speed."""

    def __init__(self, settings: RunSettings, dice: np.random.Generator, until: float) -> None:
        self._settings, self._dice, self._until = settings, dice, until
        self._world = World(room_of(settings), settings.limit_gain)
        room = self._world.room
        self._scenario = scenario_of(settings)
        self._roles = self._scenario.roles(self._world, settings)
        columns = [task.joints for task in self._roles.avoiders(settings.avoid)]
        self._avoiding = np.r_[tuple(columns)]
        self._low, self._high = _box(room)
        self._speeds = specs()["wmax"].low, settings.hand_speed
        self._size = SIZES[_moved(settings)]
        self._runs = 0
        self._missing: dict[Condition, float] = dict.fromkeys(BLAMED, 0.0)
        self._worst: Found | None = None

    def found(self, refine: bool) -> Found:
        # Loads too slowly for the first picture.
        from scipy.optimize import minimize

        start = self._start()
        tries = [np.concatenate([start, self._way(start).ravel(), [self._speed()]]) for _ in range(WAYS)]
        losses = [self._badness(variables) for variables in tries]
        worst = int(np.argmax(losses))
        if refine or losses[worst] > INTEREST:
            simplex = np.vstack([tries[worst], tries[worst] + CORNER * np.eye(len(tries[worst]))])
            options = {"maxfev": REFINEMENTS, "initial_simplex": simplex}
            with suppress(_OutOfTime):
                minimize(self._goodness, tries[worst], method="Nelder-Mead", options=options)
        assert self._worst is not None
        attack, loss = self._worst.attack, self._worst.loss
        if loss.lost > BROKEN:
            finer = replace(attack.settings, dt=attack.settings.dt / FINER)
            loss = loss._replace(lost=lasting(loss.lost, _loss(finer, attack.table(FINER)).lost))
        return Found(attack, loss, self._missing, self._runs)

    def _goodness(self, variables: Array) -> float:
        if monotonic() > self._until:
            raise _OutOfTime
        return -self._badness(variables)

    def _badness(self, variables: Array) -> float:
        """Loss of a run [m]; below 0: its distance above d_m."""
        check_wanted()
        nv = len(self._low)
        # A link has no more decimals.
        start = variables[:nv].clip(self._low, self._high).round(DIGITS)
        if self._worst is not None and self._refused(start):
            return -1.0
        points = np.vstack([self._place(start), variables[nv:-1].reshape(LEGS, self._size)]).round(DIGITS)
        speed = round(float(np.clip(variables[-1], *self._speeds)), DIGITS)
        attack = Attack(replace(self._settings, hand_speed=speed), start, points)
        loss = _loss(attack.settings, attack.table())
        self._runs += 1
        self._missing = {
            condition: max(lost, loss.missing[condition]) for condition, lost in self._missing.items()
        }
        found = Found(attack, loss, self._missing, self._runs)
        if self._worst is None or found.badness > self._worst.badness:
            self._worst = found
        return loss.lost or -min(loss.nearest, 1.0)

    def _start(self) -> Array:
        """q (nv,) where the nearest pairs tie just above d_m and their retreats oppose each other, as nearly
        as possible.
        """
        dice, low, high = self._dice, self._low, self._high
        best, size = dice.uniform(low, high), 0.6
        if self._refused(best):
            best = self._world.room.start.clip(low, high)
        least = self._apart(best)
        for _ in range(CLIMB):
            tried = (best + dice.normal(0.0, size, len(best)) * (dice.random(len(best)) < 0.4)).clip(
                low, high
            )
            apart = self._apart(tried)
            if apart < least:
                best, least, size = tried, apart, min(1.3 * size, 1.0)
            else:
                size = max(0.97 * size, 0.02)
        return best

    def _refused(self, start: Array) -> bool:
        """True if the experiment does not begin at q (nv,), because it cannot keep there what it promises."""
        self._world.positions[:] = start
        self._world.update()
        return self._scenario.problem(self._world, self._settings) is not None

    def _apart(self, posture: Array) -> float:
        """How far q (nv,) is from a worthwhile start, 0 or less at a good one."""
        self._world.kinematics.update(posture)
        self._world.detector.detect()
        if not self._world.room.meets_bodies:
            return self._above(posture)
        distances, rows = self._world.detector.distances(), self._world.detector.rows()[:, self._avoiding]
        lengths = np.linalg.norm(rows, axis=1)
        firm = np.flatnonzero(lengths > FIRM)
        if len(firm) < 2:
            return 10.0
        nearest = firm[distances[firm].argmin()]
        others = firm[firm != nearest]
        cosines = rows[others] @ rows[nearest] / (lengths[others] * lengths[nearest])
        tie = ((distances[others] - distances[nearest]) / NEAR + cosines).min()
        first = self._settings.law.critical_distance + AHEAD
        return float(tie + (abs(distances[nearest] - first) + distances[nearest] - distances.min()) / NEAR)

    def _above(self, posture: Array) -> float:
        """The same for other first tasks: the two that are least are just above h_m."""
        first = self._settings.law.critical_distance + AHEAD
        least = np.sort(self._world.detector.distances())[:2]
        return float(np.abs(least - first).sum()) / NEAR + (1e3 if self._refused(posture) else 0.0)

    def _place(self, start: Array) -> Array:
        """Start of the way (size,)."""
        if self._world.room.wall is not None:
            return start[self._world.room.wall]
        if self._settings.experiment.moves == "person":
            return REST.ravel()
        if self._world.room.ball is not None:
            return start[self._world.room.ball]
        self._world.kinematics.update(start)
        return self._world.kinematics.hand_pose(self._roles.guided).translation.copy()

    def _way(self, start: Array) -> Array:
        """Random waypoints (`LEGS`, size) about `REST`, the wall, or elbow, wrist or hand of the arm that is not guided."""
        dice = self._dice
        if self._settings.experiment.moves == "person":
            return REST.ravel() + dice.uniform(-1.0, 1.0, (LEGS, self._size))
        kinematics, room = self._world.kinematics, self._world.room
        if room.wall is not None:
            return start[room.wall] + dice.uniform(-FAR, FAR, (LEGS, self._size))
        kinematics.update(start)
        arm = next((arm for arm in room.arms if arm is not self._roles.guided), self._roles.guided)
        joints = (
            kinematics.joint_point(arm.elbow),
            kinematics.joint_point(arm.wrist),
            kinematics.hand_pose(arm).translation,
        )
        # The obstacle is near the arm; what ends at the reach of the arm is farther away.
        reach = NEARBY if room.meets_bodies else FAR
        return np.array(joints)[dice.integers(len(joints), size=LEGS)] + dice.uniform(
            -reach, reach, (LEGS, self._size)
        )

    def _speed(self) -> float:
        """Input speed [m/s]: half of them are at most v."""
        slow, fast = self._speeds
        v = float(np.clip(self._settings.law.nominal_velocity, slow, fast))
        return v if self._dice.random() < 0.5 else float(self._dice.uniform(slow, fast))


def _loss(settings: RunSettings, table: Array) -> Loss:
    lacking = missing(settings, table)
    margins = table[:, COLUMN["law_d"]] - settings.law.critical_distance

    def lost(*tolerated: Condition) -> float:
        kept = ~np.any([steps for condition, steps in lacking.items() if condition not in tolerated], axis=0)
        return fallen(margins, kept)

    kept = ~np.any([lacking[condition] for condition in BLAMED], axis=0)
    nearest = float(margins[kept & (margins >= 0.0)].min(initial=np.inf))
    others = {condition: lost(condition, Condition.PAIRS) for condition in BLAMED}
    return Loss(lost(Condition.PAIRS), lost(), nearest, others)
