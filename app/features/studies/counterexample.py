"""Search for a counterexample: the run in which d_law falls farthest below d_m under the promise's
conditions.

These are w ≤ v, J_d regular and no joint at its limit, see `scenes.promise`. One differentiable distance
keeps the promise; the closest of several pairs need not. Where an arm slides along the tie of two pairs whose
retreats oppose each other, it loses both. So a loss counts although the closest pair changes, and each search
climbs from a random posture to such a tie. From there inputs follow a few random ways, and the simplex of
Nelder & Mead (1965) varies start posture, way and speed.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from time import monotonic
from typing import Final, NamedTuple

import numpy as np

from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS
from scenes.headless import MOST_STEPS
from scenes.history import COLUMN
from scenes.inputs import InputsLog, Recorded
from scenes.person.clips import REST
from scenes.promise import Condition, fallen, missing
from scenes.roles import room_of, scenario_of
from scenes.room import Room, World, random_bounds
from scenes.settings import HardwareSettings, RunSettings, specs
from scenes.simulation import Simulation
from scenes.targets import OF_WALL, SIZES, Led, Waypoints
from scenes.wanted import check_wanted
from scenes.watched_stages import WatchedStages

SECONDS: Final = 6.0
"""Simulated time of a run [s]."""

BROKEN: Final = 1e-4
"""Smallest loss that breaks the promise [m], at dt and at dt / `FINER`."""

FINER: Final = 4

LEGS: Final = 2

WAYS: Final = 3
"""Random ways per start posture."""

CLIMB: Final = 300
"""Postures tried to find a start."""

NEAR: Final = 0.03
"""Length scale of distances at the start [m]."""

AHEAD: Final = 0.01
"""Margin of the nearest pair above d_m at the start [m]."""

NEARBY: Final = 0.3
"""Largest offset of a waypoint from an arm, per axis [m]."""

FAR: Final = 0.8
"""The same if the arm is stretched or a wall moves [m, rad]."""

FIRM: Final = 0.4
"""Pairs with a smaller |J_d| are ignored at the start [m/rad]."""

REFINEMENTS: Final = 60
"""Refinement runs per candidate."""

INTEREST: Final = 1e-3
"""Refine candidates that lose more than this [m]."""

EVERY: Final = 8
"""Also refine every n-th start."""

CORNER: Final = 0.05
"""Edge of the first simplex [rad, m, m/s]."""

DIGITS: Final = 4
"""Decimals of start and way: 0.1 mrad, 0.1 mm."""

FARTHEST: Final = 10.0
"""Largest number of a start or a way [rad, m]."""

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
        """Text for a link; see `attack_of`."""
        return ",".join(f"{number:.{DIGITS}f}" for number in (*self.start, *self.points.ravel()))

    def table(self, finer: int = 1) -> Array:
        """History (rows, columns of `scenes.history`) at dt / `finer`."""
        return self.tables(finer)[0]

    def tables(self, finer: int = 1) -> tuple[Array, ...]:
        """One history per stage; the first is the law's own."""
        settings = replace(self.settings, dt=self.settings.dt / finer)
        steps = round(SECONDS / settings.dt)
        if not settings.stages:
            return (_made(self, Simulation(settings, steps)).history.table(),)
        watched = WatchedStages(settings, steps)
        _made(self, watched)
        return watched.tables()


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
    """Takes as long as the run."""
    log = InputsLog()
    _made(attack, Simulation(attack.settings, round(SECONDS / attack.settings.dt)), log)
    recorded = log.window(SECONDS)
    assert recorded is not None
    return recorded


def _moved(settings: RunSettings) -> Led:
    return settings.experiment.moves if room_of(settings).wall is None else "wall and hand"


def _made(attack: Attack, simulation: Simulation, log: InputsLog | None = None) -> Simulation:
    settings = simulation.settings
    simulation.reset(attack.start)
    person = Waypoints(_moved(settings), attack.points, settings.hand_speed)
    for _ in range(round(SECONDS / settings.dt)):
        target = person.target(simulation.time)
        if log is not None:
            log.record(simulation, target)
        simulation.step(target)
    return simulation


def _box(room: Room) -> tuple[Array, Array]:
    """Bounds of a start posture (nv,) [rad, m], in whole units of its text."""
    low, high = random_bounds(room)
    unit = 10.0**DIGITS
    return np.ceil(low * unit) / unit, np.floor(high * unit) / unit


class Loss(NamedTuple):
    """Loss of a run below d_m in one interval [m].

    Attributes:
        lost: with all of `BLAMED` kept; above `BROKEN`, its `lasting` part.
        strict: the same, with a single closest pair.
        nearest: smallest d_law − d_m ≥ 0 with `BLAMED` kept, or ∞.
        missing: one of `BLAMED` → loss while only it was missing.
        stage: index; 0 without stages.
    """

    lost: float
    strict: float
    nearest: float
    missing: dict[Condition, float]
    stage: int = 0

    @property
    def badness(self) -> tuple[float, float]:
        """Larger for a worse run."""
        return self.lost, -self.nearest


@dataclass(frozen=True)
class Found:
    """Worst run of one start; `missing`: of all its runs."""

    attack: Attack
    loss: Loss
    missing: dict[Condition, float]
    runs: int

    @property
    def badness(self) -> tuple[float, float]:
        return self.loss.badness


def lasting(lost: float, finer: float) -> float:
    """Loss that remains as dt → 0, from losses at dt and dt / `FINER` [m]."""
    limit = (FINER * finer - lost) / (FINER - 1)
    return max(min(lost, finer, limit), 0.0)


def check(settings: RunSettings) -> None:
    """Raises `BadSetting` if there is nothing to search for."""
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
    """Search from the start of `seed` and `index`.

    Args:
        until: end of the refinement, of `time.monotonic` [s].

    Raises:
        Stopped: see `scenes.wanted`.
    """
    return _Search(settings, np.random.default_rng([seed, index]), until).found(index % EVERY == EVERY - 1)


class _OutOfTime(Exception):
    """Ends a simplex."""


class _Search:
    """Variables (nv + `LEGS` · size + 1,): start posture, way, speed."""

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
            losses = zip(
                _losses(attack.settings, attack.tables()), _losses(finer, attack.tables(FINER)), strict=True
            )
            # A stage may lose less than another one, and in steps of any length.
            loss = _worst_of([one._replace(lost=lasting(one.lost, other.lost)) for one, other in losses])
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
        losses = _losses(attack.settings, attack.tables())
        loss = _worst_of(losses)
        self._runs += 1
        self._missing = {
            condition: max(lost, *(one.missing[condition] for one in losses))
            for condition, lost in self._missing.items()
        }
        found = Found(attack, loss, self._missing, self._runs)
        if self._worst is None or found.badness > self._worst.badness:
            self._worst = found
        return loss.lost or -min(loss.nearest, 1.0)

    def _start(self) -> Array:
        """q (nv,) near a tie of opposing pairs just above d_m."""
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
        self._world.positions[:] = start
        self._world.update()
        return self._scenario.problem(self._world, self._settings) is not None

    def _apart(self, posture: Array) -> float:
        """Cost of a start q (nv,); 0 or less is good."""
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
        """Cost for other first tasks: the two smallest values are just above h_m."""
        first = self._settings.law.critical_distance + AHEAD
        least = np.sort(self._world.detector.distances())[:2]
        return float(np.abs(least - first).sum()) / NEAR + (1e3 if self._refused(posture) else 0.0)

    def _place(self, start: Array) -> Array:
        if self._settings.experiment.moves == "person":
            return REST.ravel()
        if self._world.room.ball is not None:
            return start[self._world.room.ball]
        self._world.kinematics.update(start)
        hand = self._world.kinematics.hand_pose(self._roles.guided).translation.copy()
        wall = self._world.room.wall
        return hand if wall is None else np.concatenate([start[wall], hand])

    def _way(self, start: Array) -> Array:
        """Random waypoints (`LEGS`, size) about `REST`, or about elbow, wrist or hand of the arm that is not
        guided; those of a wall about its start.
        """
        dice = self._dice
        if self._settings.experiment.moves == "person":
            return REST.ravel() + dice.uniform(-1.0, 1.0, (LEGS, self._size))
        kinematics, room = self._world.kinematics, self._world.room
        kinematics.update(start)
        arm = next((arm for arm in room.arms if arm is not self._roles.guided), self._roles.guided)
        joints = (
            kinematics.joint_point(arm.elbow),
            kinematics.joint_point(arm.wrist),
            kinematics.hand_pose(arm).translation,
        )
        # The obstacle is near the arm; what ends at the reach of the arm is farther away.
        reach = NEARBY if room.meets_bodies else FAR
        hand = np.array(joints)[dice.integers(len(joints), size=LEGS)] + dice.uniform(
            -reach, reach, (LEGS, 3)
        )
        if room.wall is None:
            return hand
        wall = start[room.wall] + dice.uniform(-FAR, FAR, (LEGS, OF_WALL.stop))
        return np.hstack([wall, hand])

    def _speed(self) -> float:
        slow, fast = self._speeds
        v = float(np.clip(self._settings.law.nominal_velocity, slow, fast))
        return v if self._dice.random() < 0.5 else float(self._dice.uniform(slow, fast))


def _losses(settings: RunSettings, tables: tuple[Array, ...]) -> list[Loss]:
    return [_loss(settings, table, stage) for stage, table in enumerate(tables)]


def _worst_of(losses: list[Loss]) -> Loss:
    return max(losses, key=lambda one: one.badness)


def _loss(settings: RunSettings, table: Array, stage: int) -> Loss:
    lacking = missing(settings, table)
    margins = table[:, COLUMN["law_d"]] - settings.law.critical_distance

    def lost(*tolerated: Condition) -> float:
        kept = ~np.any([steps for condition, steps in lacking.items() if condition not in tolerated], axis=0)
        return fallen(margins, kept)

    kept = ~np.any([lacking[condition] for condition in BLAMED], axis=0)
    nearest = float(margins[kept & (margins >= 0.0)].min(initial=np.inf))
    others = {condition: lost(condition, Condition.PAIRS) for condition in BLAMED}
    return Loss(lost(Condition.PAIRS), lost(), nearest, others, stage)
