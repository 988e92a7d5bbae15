"""One knob a law, so that laws can be compared where they keep the same distance; and the value of it that keeps a given one."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from scenes.headless import Summary, run
from scenes.inputs import Recorded
from scenes.rerun import Stopped, never, rerun
from scenes.settings import LawName, LawSettings, RunSettings, changed, specs

_DISTANCES: Final = (0.06, 0.09, 0.12, 0.15, 0.19, 0.24, 0.30)
_REACHES: Final = (0.16, 0.20, 0.25, 0.30, 0.40, 0.60)


@dataclass(frozen=True)
class LawKnob:
    """A law with the setting that trades the hand's error for distance.

    Attributes:
        law: its name.
        key: of the setting.
        points: values of it, ascending, SI.
        feed_forward: whether the law knows the obstacle's speed w.
    """

    law: LawName
    key: str
    points: tuple[float, ...]
    feed_forward: bool = False

    def at(self, settings: RunSettings, value: float) -> RunSettings:
        """Return the settings with this law and a value of its knob."""
        law = replace(settings.law, law=self.law, feed_forward=self.feed_forward)
        return changed(replace(settings, law=law), self.key, value)


KNOBS: Final = (
    LawKnob("smooth_priority", "dm", _DISTANCES),
    LawKnob("smooth_priority", "v", (0.05, 0.10, 0.20, 0.30, 0.50, 0.80)),
    LawKnob("smooth_priority", "dm", _DISTANCES, True),
    LawKnob("barrier_qp", "dm", _DISTANCES),
    LawKnob("barrier_qp", "gamma", (0.2, 0.5, 1.0, 2.0, 5.0, 20.0)),
    LawKnob("barrier_qp", "dm", _DISTANCES, True),
    LawKnob("intermediate_value", "dm", _DISTANCES),
    LawKnob("potential_field", "eta", (0.0005, 0.001, 0.002, 0.005, 0.015, 0.05)),
    LawKnob("null_space_avoidance", "d0", _REACHES),
    LawKnob("task_activation", "d0", _REACHES),
    LawKnob("continuous_inverse", "dm", _DISTANCES),
    LawKnob("set_based_task", "dm", _DISTANCES),
    LawKnob("set_based_task", "kr", (0.0, 1.0, 5.0, 15.0, 40.0)),
)
"""Of every law with a distance that can be chosen. Strict priority that is always on, and no avoidance at all, have none."""

_KEYS: Final = {knob.law: knob.key for knob in reversed(KNOBS)} | {"strict_switched": "dm"}
"""Law → key of its first knob."""

MATCH: Final = 0.001
"""How near two smallest distances are to count as the same [m]."""

MOST_RERUNS: Final = 24
"""Runs that a search may make."""

_FIRST_LOOK: Final = 7
"""Of these, values spread over the whole range of the knob."""


@dataclass(frozen=True)
class KnobPoint:
    """A run at one value of a knob, and what came out."""

    value: float
    summary: Summary


def knob_points(knob: LawKnob, settings: RunSettings, seconds: float) -> Iterator[KnobPoint]:
    """Yield a run of the scene's own person at every point of a knob."""
    for value in knob.points:
        yield KnobPoint(value, run(knob.at(settings, value), seconds).summary)


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

    law: LawName
    key: str
    value: float | None
    wanted: float
    reached: float


def match_knob(
    recorded: Recorded, reference: Mapping[str, object], chosen: Mapping[str, object], stopped: Callable[[], bool] = never
) -> KnobMatch:
    """Return the value of a law's knob at which its smallest distance is that of another law on the same recorded inputs.

    Looks at some values over the whole range, then halves the interval between two of them.

    Args:
        reference: key → value of the other law's settings.
        chosen: those of the law with the knob that is turned.
        stopped: see `rerun`.

    Raises:
        Stopped: see `rerun`.
    """

    def nearest(law: Mapping[str, object]) -> float:
        if stopped():
            raise Stopped
        return rerun(recorded, law, stopped=stopped).summary.d_min

    law: LawName = chosen["law"]  # pyright: ignore[reportAssignmentType]
    wanted, key = nearest(reference), _KEYS.get(law, "")
    if not key:
        return KnobMatch(law, "", None, wanted, nearest(chosen))
    spec = specs(LawSettings)[key]
    span = spec.high - spec.low
    found = {
        value: nearest({**chosen, key: value}) - wanted
        for value in (spec.low + span * (i / (_FIRST_LOOK - 1)) ** 2 for i in range(_FIRST_LOOK))
    }
    best = min(found, key=lambda value: abs(found[value]))
    ends = next(
        ((a, b) for a, b in zip(list(found), list(found)[1:], strict=False) if (found[a] < 0.0) != (found[b] < 0.0)), None
    )
    while ends is not None and abs(found[best]) > MATCH and len(found) < MOST_RERUNS:
        low, high = ends
        middle = (low + high) / 2.0
        found[middle] = nearest({**chosen, key: middle}) - wanted
        ends = (middle, high) if (found[middle] < 0.0) == (found[low] < 0.0) else (low, middle)
        best = min(best, middle, key=lambda value: abs(found[value]))
    return KnobMatch(law, key, best if abs(found[best]) <= MATCH else None, wanted, wanted + found[best])
