"""The closest pair of bodies over the last 20 s, a strip for each pair."""

from collections import Counter
from typing import Final

import numpy as np

from app.i18n.speaking import tr
from app.plots.bins import WINDOW
from app.plots.time_series import COLUMNS, RollingSeries
from scenes.simulation import Simulation

ROWS: Final = 7
"""Pairs shown; of more than that, the ones that were closest the longest."""


def pairs_html(simulation: Simulation, buffer: RollingSeries) -> str:
    """Return the strips, and how often another pair became the closest one."""
    times, pairs, changes = buffer.newest([COLUMNS["pair"], COLUMNS["changes"]])
    held = Counter(int(pair) for pair in pairs.tolist() if pair >= 0.0)
    if not held:
        return '<div class="duet duet-pairs"></div>'
    shown = sorted(pair for pair, _ in held.most_common(ROWS))
    present, span = int(pairs[-1]), len(times)
    rows = "".join(
        f'<div class="{"now" if pair == present else ""}"><span>{pair_name(simulation, pair)}</span>'
        f'<svg viewBox="0 0 {span} 1" preserveAspectRatio="none"><path d="{_runs(pairs, pair)}"/></svg></div>'
        for pair in shown
    )
    count, others = int(changes[-1] - changes[0]), len(held) - len(shown)
    words = _words(simulation, count, len(held))
    more = " " + tr("{count} more pairs are not shown.", count=others) if others else ""
    since = min(WINDOW, float(times[-1] - times[0]))
    axis = f"<div class=ends><span></span><p><i>−{since:.0f} s</i><i>{tr('now')}</i></p></div>"
    return f'<div class="duet duet-pairs">{rows}{axis}<p>{words}{more}</p></div>'


def pair_name(simulation: Simulation, pair: int) -> str:
    """Return the name of a pair of bodies: "L forearm · R hand"."""
    return " · ".join(
        body_name(name.replace("left ", "L ").replace("right ", "R ").removeprefix("arm ").removeprefix("control point at the "))
        for name in simulation.detector.pair_names[pair]
    )


def body_name(name: str) -> str:
    """Return the name of a body in the current language: "L forearm", "link 3", "ball"."""
    side, mark, rest = name.partition(" ")
    if mark and side in ("L", "R"):
        return f"{tr(side)} {body_name(rest)}"
    stem, mark, number = name.rpartition(" ")
    return f"{tr(stem)} {number}" if mark and number.isdecimal() else tr(name)


def _runs(pairs: np.ndarray, pair: int) -> str:
    """Return boxes of SVG over the bins in which a pair was closest."""
    marked = np.concatenate([[0], (pairs == pair).astype(np.int8), [0]])
    edges = np.flatnonzero(np.diff(marked)).reshape(-1, 2)
    return "".join(f"M{a} 0h{b - a}v1h-{b - a}z" for a, b in edges.tolist())


def _words(simulation: Simulation, changes: int, pairs: int) -> str:
    if simulation.detector.count == 1:
        return tr("There is one pair only: the critical point never changes, and the law is smooth in the strict sense.")
    counted = _counted(changes, pairs)
    law = simulation.settings.law
    if law.law == "unprotected":
        return counted
    if law.law == "barrier_qp":
        return f"{counted} {tr('This law sees all of them at once.')}"
    if law.pairs == "single":
        return f"{counted} {tr('The law sees the closest pair only: at every change q̇ may jump.')}"
    return f"{counted} {tr('The law sees a smooth minimum over all: a change makes no jump.')}"


def _counted(changes: int, pairs: int) -> str:
    if changes == 1:
        return tr("1 change among 1 pair.") if pairs == 1 else tr("1 change among {pairs} pairs.", pairs=pairs)
    if pairs == 1:
        return tr("{changes} changes among 1 pair.", changes=changes)
    return tr("{changes} changes among {pairs} pairs.", changes=changes, pairs=pairs)
