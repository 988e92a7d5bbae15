"""The promise of the paper's law, d ≥ d_law ≥ d_m, and its conditions.

Along the line of contact ḋ_law = s λ (v + u) − u − w, with the lever s; at d_law = d_m, where λ = 1, this is
s v − (1 − s) u − w. So d_law stays ≥ d_m while w ≤ v, J_d is regular (s = 1), no joint bound and no later
stage (`scenes.world_stages`) reduces q̇, and d_law has one derivative along the motion. The closest of
several pairs violates the last: an arm that slides along the tie of two pairs can lose distance although it
keeps each by itself.
"""

from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from controllers.kinematics import Array
from controllers.laws.situation import FIRM_LEVER
from controllers.limits import Authority
from scenes.history import COLUMN, History
from scenes.settings import HardwareSettings, RunSettings

TIE: Final = 0.05
"""Pairs count as tied for this time before and after a change [s]."""


class Condition(Enum):
    SPEED = "w ≤ v"
    LEVER = "J_d regular"
    BOUND = "no joint at its limit"
    WORLD = "clear of table, stand and itself"
    PAIRS = "one closest pair"
    ROBOT = "an ideal robot"


def missing(settings: RunSettings, table: Array) -> dict[Condition, NDArray[np.bool_]]:
    """Condition → steps of a history table (rows, columns) in which it is missing, bool (rows,).

    J_d and the closest pair count where λ > 1/2: far away they do not predict those at d_m. If two arms keep
    clear, each by its own row, no w is too fast: one arm's retreat compensates the other's motion.
    """
    law = settings.law
    w, second = table[:, COLUMN["w_law"]], ~np.isnan(table[:, COLUMN["authority_b"]])
    two = bool(second.any())
    if two:
        w = np.where(second, 0.0, w)
    v = law.nominal_velocity + (w if settings.adds_w else 0.0)
    near = table[:, COLUMN["lambda"]] > 0.5
    u, least, bound = (
        table[:, COLUMN["u"]],
        table[:, COLUMN["lever"]],
        _at_bound(table[:, COLUMN["authority"]]),
    )
    rate = least * (v + u) - u - w
    if two:
        u, s = table[:, COLUMN["u_b"]], table[:, COLUMN["lever_b"]]
        rate = rate + np.where(second, s * (v + u) - u, 0.0)
        least = np.where(second, np.minimum(least, s), least)
        bound |= second & _at_bound(table[:, COLUMN["authority_b"]])
    tied = np.zeros(len(table), bool)
    # Each of several stages has one first task.
    if law.pairs == "single" and not settings.stages:
        reach = _reach(settings)
        for k in np.flatnonzero(np.diff(table[:, COLUMN["pair"]])).tolist():
            tied[max(0, k - reach) : k + 1 + reach] = True
    return {
        Condition.SPEED: w > v,
        Condition.LEVER: near & ((least < FIRM_LEVER) | (least < 1.0) & (w <= v) & (rate < 0.0)),
        Condition.BOUND: bound,
        Condition.WORLD: (table[:, COLUMN["authority"]] == Authority.WORLD)
        | (table[:, COLUMN["authority_b"]] == Authority.WORLD),
        Condition.PAIRS: near & tied,
        Condition.ROBOT: np.full(len(table), settings.hardware != HardwareSettings()),
    }


def _at_bound(authority: Array) -> NDArray[np.bool_]:
    return (authority == Authority.STOP) | (authority == Authority.SPEED)


def missing_now(settings: RunSettings, history: History) -> tuple[Condition, ...]:
    """Conditions missing in the newest step."""
    # Only ties need earlier steps.
    looks_back = settings.law.pairs == "single" and not settings.stages
    table = history.table(_reach(settings) + 1 if looks_back else 1)
    return tuple(
        condition for condition, steps in missing(settings, table).items() if len(steps) and steps[-1]
    )


def broken_by(settings: RunSettings, table: Array) -> float:
    """Loss of d_law below d_m with all conditions met [m]; of the order of dt, as time is discrete.

    Falls below d_m count, minus rises in between.
    """
    distance = table[:, COLUMN["law_d"]]
    critical = settings.law.critical_distance
    falls = np.minimum(distance[:-1], critical) - np.minimum(distance[1:], critical)
    excused = np.any(list(missing(settings, table).values()), axis=0)[:-1]
    most = lost = 0.0
    for fall, excuse in zip(falls.tolist(), excused.tolist(), strict=True):
        lost = max(0.0, lost + (min(fall, 0.0) if excuse else fall))
        most = max(most, lost)
    return most


def fallen(margins: Array, kept: NDArray[np.bool_]) -> float:
    """Largest fall below d_m in consecutive `kept` steps (rows,) that begin at or above d_m [m].

    Args:
        margins: distance − d_m (rows,) [m].
    """
    most, clear = 0.0, False
    for before, after, counts in zip(
        margins[:-1].tolist(), margins[1:].tolist(), kept[:-1].tolist(), strict=True
    ):
        clear = counts and (clear or before >= 0.0)
        if clear:
            most = max(most, -after)
    return most


def _reach(settings: RunSettings) -> int:
    return max(1, round(TIE / settings.dt))
