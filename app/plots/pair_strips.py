"""The closest pair over the last 20 s, one strip per pair."""

from collections import Counter
from typing import Final

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import N_, tr
from app.plots.bins import BIN, WINDOW
from app.plots.time_series import COLUMNS, RollingSeries
from app.text.first_task_texts import wording
from app.text.templates import macros
from scenes.simulation import Simulation

ROWS: Final = 7


def pairs_html(simulation: Simulation, buffer: RollingSeries) -> Markup:
    times, pairs, changes = buffer.newest([COLUMNS["pair"], COLUMNS["changes"]])
    held = Counter(int(pair) for pair in pairs.tolist() if pair >= 0.0)
    made = macros("plots/charts.html")
    if not held:
        return made.pairs((), 0, "", "")
    shown = sorted(pair for pair, _ in held.most_common(ROWS))
    rows = [(pair_name(simulation, pair), _runs(pairs, pair), pair == int(pairs[-1])) for pair in shown]
    if (often := np.diff(changes, prepend=changes[0])).max() > 1.0:
        # Changes to and fro within a bin are not shown.
        rows.append(
            (tr("changes, up to {rate} a second", rate=f"{often.max() / BIN:.0f}"), _bars(often), False)
        )
    count, others = int(changes[-1] - changes[0]), len(held) - len(shown)
    words = _words(simulation, count, len(held))
    more = " " + tr("{count} more pairs are not shown.", count=others) if others else ""
    since = min(WINDOW, float(times[-1] - times[0]))
    return made.pairs(rows, len(times), f"{since:.0f}", words + more)


def pair_name(simulation: Simulation, pair: int) -> str:
    """For example "forearm (silver) · hand (orange)"."""
    return " · ".join(
        body_name(name.removeprefix("control point at the ").removeprefix("arm "), simulation.guided.name)
        for name in simulation.detector.pair_names[pair]
    )


def arm_colour(arm: str, yours: str) -> str:
    """Name of an arm's colour in the current language. `yours`: the visitor's arm."""
    return tr("orange") if arm == yours else tr("silver")


def body_name(name: str, yours: str) -> str:
    """For example "forearm (silver)", "link 3" or "ball"."""
    arm, _, rest = name.partition(" ")
    if arm in ("left", "right"):
        return f"{body_name(rest, yours)} ({arm_colour(arm, yours)})"
    stem, mark, number = name.rpartition(" ")
    return f"{tr(stem)} {number}" if mark and number.isdecimal() else tr(name)


def _runs(pairs: np.ndarray, pair: int) -> str:
    marked = np.concatenate([[0], (pairs == pair).astype(np.int8), [0]])
    edges = np.flatnonzero(np.diff(marked)).reshape(-1, 2)
    return "".join(f"M{a} 0h{b - a}v1h-{b - a}z" for a, b in edges.tolist())


def _bars(counts: np.ndarray) -> str:
    shares = (counts / counts.max()).tolist()
    return "".join(f"M{i} 1v{-share:.2f}h1v{share:.2f}z" for i, share in enumerate(shares) if share)


def _words(simulation: Simulation, changes: int, pairs: int) -> str:
    kept = simulation.settings.quantity
    if simulation.detector.count == 1:
        only = N_(
            "There is one pair only: the critical point never changes, and the law is smooth in the strict sense."
        )
        return tr(wording(only, kept))
    said = N_("{changes} {changes:change|changes} among {pairs} {pairs:pair|pairs}.")
    counted = tr(wording(said, kept), changes=changes, pairs=pairs)
    law = simulation.settings.law
    if law.entry.sees == "nothing":
        return counted
    if law.entry.sees == "all pairs":
        return f"{counted} {tr('This law sees all of them at once.')}"
    if law.pairs == "single":
        single = wording(N_("The law sees the closest pair only: at every change q̇ may jump."), kept)
        return f"{counted} {tr(single)}"
    return f"{counted} {tr('The law sees a smooth minimum over all: a change makes no jump.')}"
