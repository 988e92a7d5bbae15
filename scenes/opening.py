"""Opening of the hold experiment: a scripted guided hand shows the other arm's redundancy."""

from typing import Final, NamedTuple

import numpy as np

from controllers.kinematics import Array
from scenes.roles import TargetSource
from scenes.settings import RunSettings
from scenes.targets import HandTarget, Target, quintic


class Leg(NamedTuple):
    """A move of the guided hand, from rest to rest.

    Attributes:
        place: end (3,), world [m].
        pause: rest after it [s].
    """

    place: tuple[float, float, float]
    seconds: float
    pause: float = 0.0


ELBOW: Final = (
    Leg((0.44, -0.083, 0.642), 2.0),
    Leg((0.203, 0.378, 0.624), 2.0),
    Leg((0.265, 0.399, 0.640), 10.0),
)
"""To the silver elbow from below, then slowly further: it swings away in the null space of its
hand. The last two places are beyond the guided arm's reach.
"""

PUSH: Final = (Leg((0.60, 0.32, 0.90), 2.5, 1.0),)
"""To the silver forearm, too fast for the null space alone: the hand must leave its ring."""

BACK: Final = (Leg((0.729, -0.311, 0.873), 4.0, 1.0),)
"""Home; the silver hand returns to its ring."""

OPENING: Final = (*ELBOW, *PUSH, *BACK)

AS_DESIGNED: Final = ("scene", "rig", "robot", "guided", "task", "start", "seed")
"""Settings whose usual values the legs were designed for."""


def begins_with_opening(settings: RunSettings) -> bool:
    """True for the usual values of `AS_DESIGNED`, under any law."""
    usual = RunSettings()
    return all(getattr(settings, name) == getattr(usual, name) for name in AS_DESIGNED)


class Opening:
    """A `TargetSource`: the opening, then another source.

    Args:
        start: hand at time 0 (3,) [m].
        after: starts at the last place, with its time 0.
    """

    def __init__(self, start: Array, after: TargetSource) -> None:
        places = [np.array(start, float), *(np.array(leg.place) for leg in OPENING)]
        lasting = [leg.seconds + leg.pause for leg in OPENING]
        self._ways = [
            (sum(lasting[: i + 1]), sum(lasting[:i]), leg.seconds, places[i], places[i + 1] - places[i])
            for i, leg in enumerate(OPENING)
        ]
        """End, begin and duration of each move [s], start and way of the hand (3,) [m]."""
        self._end = sum(lasting)
        self._after = after

    def target(self, time: float) -> Target | None:
        """Target at a time ≥ 0 [s]."""
        for end, begin, seconds, place, way in self._ways:
            if time < end:
                share, _ = quintic(min((time - begin) / seconds, 1.0))
                return HandTarget(place + way * share)
        return self._after.target(time - self._end)
