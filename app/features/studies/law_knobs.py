"""One knob a law, so that laws can be compared where they keep the same distance; and the value of it that keeps a given one."""

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
    """A law with one of its knobs. `law`: its name."""

    law: str
    setting: Knob

    @property
    def second(self) -> bool:
        """Whether it is not the setting by which the law's distance is chosen first."""
        first = LAWS[self.law].distance_knob
        return first is None or self.setting.key != first.key

    def at(self, settings: RunSettings, value: float) -> RunSettings:
        """Return the settings with this law and a value of its knob."""
        law = replace(settings.law, law=self.law, feed_forward=self.setting.feed_forward)
        settings = replace(settings, law=law)
        for key, number in self.setting.settings(value).items():
            settings = changed(settings, key, number)
        return settings


def knobs() -> tuple[LawKnob, ...]:
    """Return the knobs of all laws, law by law."""
    return tuple(LawKnob(law.name, knob) for law in LAWS.values() for knob in law.knobs)


MATCH: Final = 0.001
"""How near two smallest distances are to count as the same [m]."""

MOST_RERUNS: Final = 24
"""Runs that a search may make."""

_FIRST_LOOK: Final = 7
"""Number of the first values, which are spread over the whole range of the knob."""


@dataclass(frozen=True)
class KnobMatch:
    """The outcome of a search.

    Attributes:
        law: with the knob that was turned.
        key: of the knob; "" if the law has none.
        value: that keeps the wanted distance within `MATCH`, SI; None if no value does.
        wanted: smallest distance of the other law on the same inputs [m].
        reached: smallest distance of this law at `value`, or the nearest that was found [m].
    """

    law: str
    key: str
    value: float | None
    wanted: float
    reached: float


def match_knob(recorded: Recorded, reference: Mapping[str, object], chosen: Mapping[str, object]) -> KnobMatch:
    """Return the value of a law's knob at which its smallest distance is that of another law on the same recorded inputs.

    Looks at some values over the whole range, then halves the interval between two of them.

    Args:
        reference: key → value of the other law's settings.
        chosen: those of the law with the knob that is turned.

    Raises:
        Stopped: see `rerun`.
    """

    def nearest(law: Mapping[str, object]) -> float:
        return rerun(recorded, law).summary.d_min

    law = str(chosen["law"])
    wanted, knob = nearest(reference), LAWS[law].distance_knob
    if knob is None:
        return KnobMatch(law, "", None, wanted, nearest(chosen))
    value, reached = sought(lambda value: nearest({**chosen, **knob.settings(value)}), knob_range(knob), wanted)
    return KnobMatch(law, knob.key, value, wanted, reached)


def knob_range(knob: Knob) -> tuple[float, float]:
    """Return the least and the largest value of a knob."""
    spec = specs(LawSettings)[knob.key]
    return spec.low, spec.high


def sought(distance: Callable[[float], float], ends: tuple[float, float], wanted: float) -> tuple[float | None, float]:
    """Return the value at which a distance is the wanted one within `MATCH`, None if it is nowhere, and the nearest that was found [m].

    Args:
        distance: by value [m].
        ends: of the range of values.
    """
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
