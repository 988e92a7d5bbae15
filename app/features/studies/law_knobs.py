"""Knobs of the laws, and their values."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from scenes.inputs import Recorded
from scenes.laws import LAWS, Knob
from scenes.rerun import rerun
from scenes.settings import LawSettings, RunSettings, changed, specs


@dataclass(frozen=True)
class LawKnob:
    law: str
    setting: Knob

    @property
    def second(self) -> bool:
        """False for the law's distance knob."""
        first = LAWS[self.law].distance_knob
        return first is None or self.setting.key != first.key

    def at(self, settings: RunSettings, value: float) -> RunSettings:
        law = replace(settings.law, law=self.law, feed_forward=self.setting.feed_forward)
        settings = replace(settings, law=law)
        for key, number in self.setting.settings(value).items():
            settings = changed(settings, key, number)
        return settings


def knobs() -> tuple[LawKnob, ...]:
    return tuple(LawKnob(law.name, knob) for law in LAWS.values() for knob in law.knobs)


MATCH: Final = 0.001
"""Tolerance of equal distances [m]."""

MOST_RERUNS: Final = 24

_FIRST_LOOK: Final = 7


@dataclass(frozen=True)
class KnobMatch:
    """Result of a search.

    Attributes:
        key: "" if the law has no knob.
        value: keeps the wanted distance within `MATCH` [SI], or None.
        wanted: smallest distance of the other law [m].
        reached: smallest distance at `value`, or the nearest found [m].
    """

    law: str
    key: str
    value: float | None
    wanted: float
    reached: float


def match_knob(
    recorded: Recorded, reference: Mapping[str, object], chosen: Mapping[str, object]
) -> KnobMatch:
    """Find the knob value that gives another law's smallest distance on the same inputs.

    Args:
        reference: key → value of the other law.
        chosen: of the law with the knob.

    Raises:
        Stopped: see `rerun`.
    """

    def nearest(law: Mapping[str, object]) -> float:
        return rerun(recorded, law).summary.d_min

    law = str(chosen["law"])
    wanted, knob = nearest(reference), LAWS[law].distance_knob
    if knob is None:
        return KnobMatch(law, "", None, wanted, nearest(chosen))
    value, reached = sought(
        lambda value: nearest({**chosen, **knob.settings(value)}), knob_range(knob), wanted
    )
    return KnobMatch(law, knob.key, value, wanted, reached)


def knob_range(knob: Knob) -> tuple[float, float]:
    spec = specs(LawSettings)[knob.key]
    return spec.low, spec.high


def sought(
    distance: Callable[[float], float], ends: tuple[float, float], wanted: float
) -> tuple[float | None, float]:
    """Value with the wanted distance within `MATCH`, or None, and the nearest distance [m]."""
    low, high = ends
    found = {
        value: distance(value) - wanted
        for value in (low + (high - low) * (i / (_FIRST_LOOK - 1)) ** 2 for i in range(_FIRST_LOOK))
    }
    best = min(found, key=lambda value: abs(found[value]))
    between = next(((a, b) for a, b in pairwise(found) if (found[a] < 0.0) != (found[b] < 0.0)), None)
    while between is not None and abs(found[best]) > MATCH and len(found) < MOST_RERUNS:
        low, high = between
        middle = (low + high) / 2.0
        found[middle] = distance(middle) - wanted
        between = (middle, high) if (found[middle] < 0.0) == (found[low] < 0.0) else (low, middle)
        best = min(best, middle, key=lambda value: abs(found[value]))
    return best if abs(found[best]) <= MATCH else None, wanted + found[best]
