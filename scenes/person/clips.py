"""People without a camera: gestures of our own making, and a figure with wrists and elbows that can be dragged.

A gesture loops for ever, a pure function of its name, a seed and the time.

A clip is a row of postures from `REST` to `REST` with a quintic between two of them, smooth up to its accelerations. The seed makes the
person: which arm leads, how often and how fast. On the torso, without avoidance, clap and cross bring the robots' arms into each other.
"""

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.linalg import norm

from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.person.angles import FOREARM, SIGN, UPPER_ARM, arm_directions, arm_points, arm_rotation, direction_angles
from scenes.settings import ArmName, ClipName
from scenes.targets import between, quintic

ClipArm = tuple[float, float, float, float]
"""The four angles of one arm, see `scenes.person.angles`; degrees, in this file alone."""

REST_ARM: Final[ClipArm] = (20.0, 14.0, 0.0, 75.0)

REST: Final[Array] = np.radians([REST_ARM, REST_ARM])
"""Where every clip starts and ends (2, 4) [rad]: elbows at the sides, forearms ahead. Only to be read."""


class Key(NamedTuple):
    """One posture and how long the way to it takes.

    Attributes:
        seconds: since the key before; 0 for the first.
        lead, other: the arm that leads and the other one [deg].
    """

    seconds: float
    lead: ClipArm
    other: ClipArm


class Clip:
    """A gesture that loops.

    Args:
        name: of the gesture; "medley" is all others in turn.
        seed: which person.

    Attributes:
        duration: of one loop [s].

    Raises:
        BadSetting: there is no such clip.
    """

    def __init__(self, name: ClipName, seed: int = 1) -> None:
        if name not in CLIP_NAMES:
            raise BadSetting(f"There is no clip {str(name)[:40]!r}; choose from {', '.join(CLIP_NAMES)}.")
        names = tuple(_GESTURES) if name == "medley" else (name,)
        seconds: list[float] = []
        tables: list[Array] = []
        for gesture in names:
            # Each gesture has its own stream, so that a seed waves in the medley as it does alone.
            random = np.random.default_rng([abs(seed), list(_GESTURES).index(gesture)])
            loop = [_home(0.0), _home(0.3), *_GESTURES[gesture](random), _home(0.4)]
            pace = random.uniform(0.92, 1.15)
            seconds += [pace * key.seconds for key in loop]
            pair = np.radians([[key.lead, key.other] for key in loop])
            tables.append(pair if random.integers(2) else pair[:, ::-1])
        self._times = np.cumsum(seconds)
        self._poses = np.concatenate(tables)
        self.duration = float(self._times[-1])

    def angles(self, time: float) -> Array:
        """Return the angles (2, 4) at a time [s], left arm first [rad]."""
        i, j, share = between(self._times, time % self.duration)
        return self._poses[i] + quintic(share)[0] * (self._poses[j] - self._poses[i])


def _about(random: np.random.Generator, arm: ClipArm, spread: float) -> ClipArm:
    f, a, r, e = (np.array(arm) + random.uniform(-spread, spread, 4)).tolist()
    return f, a, r, e


def _home(seconds: float) -> Key:
    return Key(seconds, REST_ARM, REST_ARM)


def _wave(random: np.random.Generator) -> list[Key]:
    idle = _about(random, REST_ARM, 4.0)
    raised = _about(random, (25.0, 66.0, 66.0, 88.0), 4.0)
    f, a, r, e = raised
    keys = [Key(2.2, raised, idle)]
    for _ in range(int(random.integers(2, 5))):
        swing = random.uniform(15.0, 20.0)
        keys += [Key(1.0, (f, a, r - swing, e + 8.0), idle), Key(1.0, (f, a, r + swing, e - 8.0), idle)]
    return [*keys, _home(2.3)]


def _clap(random: np.random.Generator) -> list[Key]:
    apart = _about(random, (58.0, 17.0, -16.0, 66.0), 3.0)
    keys = [Key(1.5, apart, apart)]
    for _ in range(int(random.integers(3, 6))):
        together = _about(random, (61.0, 4.0, -46.0, 72.0), 1.5)
        keys += [Key(0.9, together, together), Key(0.9, apart, apart)]
    return [*keys, _home(1.5)]


def _cross(random: np.random.Generator) -> list[Key]:
    ready = _about(random, (48.0, 18.0, -12.0, 82.0), 3.0)
    over, under = _about(random, (66.0, 3.0, -66.0, 90.0), 1.0), _about(random, (45.0, 3.0, -62.0, 85.0), 1.0)
    hold = random.uniform(0.6, 1.2)
    keys = [Key(1.3, ready, ready), Key(1.8, over, under), Key(hold, over, under), Key(1.8, ready, ready)]
    if random.integers(2):
        keys += [Key(1.8, under, over), Key(hold, under, over), Key(1.8, ready, ready)]
    return [*keys, _home(1.2)]


def _reach(random: np.random.Generator) -> list[Key]:
    idle = _about(random, REST_ARM, 3.0)
    ahead = _about(random, (82.0, 4.0, 0.0, 14.0), 5.0)
    aside = _about(random, (55.0, 48.0, 5.0, 20.0), 6.0)
    high = _about(random, (122.0, 8.0, 0.0, 22.0), 6.0)
    across = _about(random, (66.0, -2.0, -38.0, 30.0), 4.0)
    back = random.uniform(1.6, 2.0)
    keys = [Key(2.0, ahead, idle), Key(back, idle, aside), Key(2.6, high, idle), Key(2.6, across, idle)]
    return [*keys, Key(back, idle, ahead), Key(2.0, ahead, ahead), _home(2.0)]


_Gesture = Callable[[np.random.Generator], list[Key]]
"""What a person does between rest and rest, before their pace."""

_GESTURES: Final[dict[ClipName, _Gesture]] = {"wave": _wave, "clap": _clap, "cross": _cross, "reach": _reach}

CLIP_NAMES: Final[tuple[ClipName, ...]] = (*_GESTURES, "medley")


MOST_BENT: Final = float(np.radians(150.0))
"""An elbow bends no further [rad]."""

TRUSTED_SINE: Final = 1e-3
"""A hand that drags holds the point exactly, so that hardly anything is remembered at a singular posture."""


SETTLING: Final = 4
"""How often a pull at a hand corrects the wrist for the turn of the forearm."""


class Grasp(NamedTuple):
    """Where an arm is held.

    Attributes:
        side: which arm.
        forearm: whether beyond the middle of the forearm.
        along: beyond the wrist, along the forearm [m].
        aside: off the axis of its bone (3,), or off the elbow [m].
    """

    side: ArmName
    forearm: bool
    along: float
    aside: Array


class Figure:
    """A person who stays as they were dragged; a `PersonSource`. Points are in the torso frame, its origin halfway between the shoulders.

    Args:
        start: angles (2, 4) of both arms [rad].
    """

    def __init__(self, start: Array = REST) -> None:
        self._start = start.copy()
        self.reset()

    def reset(self) -> None:
        self._angles = dict(zip(SIGN, self._start, strict=True))

    def angles(self, time: float = 0.0) -> Array:
        """Return the angles (2, 4) of both arms now [rad], left first; `time` is not looked at."""
        return np.array(list(self._angles.values()))

    def points(self, side: ArmName) -> tuple[Array, Array, Array]:
        """Return shoulder, elbow and wrist (3,) of an arm [m]."""
        return arm_points(self._angles[side], side)

    def drag_wrist(self, side: ArmName, point: Array) -> None:
        """Bring a wrist to a point (3,) [m], or as near as the arm reaches, with the least swivel of the elbow; a point must be finite."""
        shoulder, elbow, wrist = self.points(side)
        a, b = UPPER_ARM, FOREARM
        way = np.asarray(point, float) - shoulder
        distance = norm(way)
        if not math.isfinite(distance):
            return
        if distance < 1e-6:
            way, distance = wrist - shoulder, norm(wrist - shoulder)
        toward = way / distance
        reach = min(max(distance, math.sqrt(a * a + b * b + 2.0 * a * b * math.cos(MOST_BENT))), a + b)
        along = (a * a + reach * reach - b * b) / (2.0 * reach)
        out = _across(elbow - shoulder, toward, 1e-3 * a)
        if out is None:
            # A straight elbow bends with the forearm going to the arm's own x, so the elbow itself goes the other way. That x is
            # square to the upper arm, which lies along `toward` here.
            out = _across(-arm_rotation(self._angles[side], side)[:, 0], toward, 0.0)
        assert out is not None
        bent = shoulder + along * toward + math.sqrt(max(a * a - along * along, 0.0)) * out
        self._take(side, bent - shoulder, shoulder + reach * toward - bent)

    def drag_elbow(self, side: ArmName, point: Array) -> None:
        """Point the upper arm at a finite point (3,) [m] off the shoulder; the forearm keeps its direction if the elbow can bend so far."""
        shoulder, _, _ = self.points(side)
        way = np.asarray(point, float) - shoulder
        distance = norm(way)
        if not 1e-6 < distance < math.inf:
            return
        upper = way / distance
        before, forearm = arm_directions(self._angles[side], side)
        if float(upper @ forearm) < math.cos(MOST_BENT):
            out = _across(forearm, upper, 1e-6)
            if out is None:
                out = _across(-before, upper, 0.0)
            if out is None:
                return
            forearm = math.cos(MOST_BENT) * upper + math.sin(MOST_BENT) * out
        self._take(side, upper, forearm)

    def grasp(self, side: ArmName, forearm: bool, point: Array) -> Grasp:
        """Return the grasp of an upper arm or a forearm at a point (3,) [m]; a forearm near its elbow is held at the elbow."""
        shoulder, elbow, wrist = self.points(side)
        if not forearm:
            upper = (elbow - shoulder) / UPPER_ARM
            way = point - shoulder
            return Grasp(side, False, 0.0, way - upper * float(upper @ way))
        axis = (wrist - elbow) / FOREARM
        way = point - wrist
        along = float(axis @ way)
        if along < -0.5 * FOREARM:
            return Grasp(side, False, 0.0, point - elbow)
        return Grasp(side, True, along, way - axis * along)

    def pull(self, grasp: Grasp, point: Array) -> None:
        """Bring what is held to a point (3,) [m], or as near as the arm reaches."""
        goal = np.asarray(point, float) - grasp.aside
        if not grasp.forearm:
            self.drag_elbow(grasp.side, goal)
            return
        for _ in range(SETTLING):
            _, elbow, wrist = self.points(grasp.side)
            self.drag_wrist(grasp.side, goal - (wrist - elbow) * (grasp.along / FOREARM))

    def _take(self, side: ArmName, upper: Array, forearm: Array) -> None:
        upper, forearm = upper / norm(upper), forearm / norm(forearm)
        self._angles[side] = direction_angles(upper, forearm, side, self._angles[side], TRUSTED_SINE)


def _across(vector: Array, axis: Array, least: float) -> Array | None:
    """Return the unit vector of the component of a vector normal to a unit axis; None if that is not longer than `least`."""
    rest = vector - float(vector @ axis) * axis
    length = norm(rest)
    return rest / length if length > least else None
