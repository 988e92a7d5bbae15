"""Scripted people: looped gestures, pure functions of name, seed and time.

Quintics join postures from `REST` to `REST`, smooth up to accelerations. The seed sets leading arm, counts
and pace. On the torso, without avoidance, clap and cross make the robots' arms collide.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np

from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.settings import ClipName
from scenes.targets import between, quintic

ClipArm = tuple[float, float, float, float]
"""Angles as in `scenes.person.angles`, but in degrees."""

REST_ARM: Final[ClipArm] = (20.0, 14.0, 0.0, 75.0)

REST: Final[Array] = np.radians([REST_ARM, REST_ARM])
"""Start and end of every clip (2, 4) [rad]. Read only."""


class Key(NamedTuple):
    """A posture and the time to reach it.

    Attributes:
        seconds: since the last key; 0 for the first.
        lead, other: arms [deg].
    """

    seconds: float
    lead: ClipArm
    other: ClipArm


class Clip:
    """A looped gesture; "medley" is all others in turn.

    Attributes:
        duration: of one loop [s].

    Raises:
        BadSetting: unknown clip.
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

_GESTURES: Final[dict[ClipName, _Gesture]] = {"wave": _wave, "clap": _clap, "cross": _cross, "reach": _reach}

CLIP_NAMES: Final[tuple[ClipName, ...]] = (*_GESTURES, "medley")
