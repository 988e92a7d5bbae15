"""Drawn predictions and true curves."""

from collections.abc import Sequence
from statistics import fmean, median
from typing import Final, NamedTuple

import numpy as np
from markupsafe import Markup

from app.features.lessons.blocks import NEEDED, Table
from app.features.lessons.runs import Setup
from app.features.measures.evidence import Evidence
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_, tr
from app.plots.curve_chart import COLUMNS, Curve, CurveAxis, Line, curve_chart
from app.plots.drawing_axes import AXES, Drawing, axes_text, axis_of
from app.settings import Language
from controllers.activation import activation
from controllers.kinematics import Array

ENOUGH: Final = 0.5
"""Share of the columns that must be drawn, and whose truth must be known."""


class DrawingVerdict(NamedTuple):
    """Verdict on a drawing. `right`: None if too little was drawn."""

    right: bool | None
    text: str


class DrawnCurves(NamedTuple):
    """A drawing and the truth; () or None until known."""

    drawn: Curve
    truth: Curve
    verdict: DrawingVerdict | None


def read_drawing(table: Table, setup: Setup) -> Drawing | None:
    entry = table.table("drawing")
    if entry is None:
        return None
    x_name, y_name = entry.choice("x", AXES), entry.choice("y", AXES)
    if x_name == y_name or y_name == "time":
        raise entry.fault(
            "y",
            f"y = {y_name!r} over x = {x_name!r} is not a curve; draw another quantity than x, and none but x is time.",
        )
    if "error" in (x_name, y_name) and setup.run.experiment.error_unit != "m²":
        raise entry.fault(
            "y", f"the error of the scene {setup.run.scene} is one of joints; draw another quantity."
        )
    x, y = (_axis(entry, key, name, setup) for key, name in (("x_range", x_name), ("y_range", y_name)))
    formula = entry.choice("truth", ("run", "formula"), "run") == "formula"
    if formula and (x_name, y_name) != ("distance", "activation"):
        raise entry.fault(
            "truth",
            'there is a formula only for the activation over the distance, eq. (31); write truth = "run".',
        )
    within = entry.number("within", NEEDED, 0.0)
    if not 0.0 < within < y.high - y.low:
        raise entry.fault(
            "within", f"within = {within:g} is not a distance along y; give one smaller than the axis."
        )
    entry.close()
    return Drawing(x_name, y_name, x, y, formula, within)


def _axis(entry: Table, key: str, name: str, setup: Setup) -> CurveAxis:
    if not entry.has(key):
        raise entry.fault(key, f"{key} is missing; add the ends of the axis, [low, high].")
    low, high = entry.numbers(key, 2)
    if not low < high:
        raise entry.fault(
            key, f"{key} = [{low:g}, {high:g}] is not a range; write [low, high] with low < high."
        )
    return axis_of(name, (low, high), setup.run.law.critical_distance)


def true_curve(drawing: Drawing, evidence: Evidence) -> Curve:
    """True curve; None in columns that the run did not reach."""
    if drawing.formula:
        law = evidence.settings.law
        return tuple(activation(d, law.critical_distance, law.order) for d in drawing.columns)
    return first_met(_series(evidence, drawing.x_name), _series(evidence, drawing.y_name), drawing.columns)


def _series(evidence: Evidence, name: str) -> Array:
    column = evidence.column(AXES[name].column)
    return np.sqrt(column) if name == "error" else column


def first_met(xs: Array, ys: Array, columns: Sequence[float]) -> Curve:
    """y where x first reaches each column, linear between rows, or None. xs, ys: (rows,)."""
    known = np.isfinite(xs) & np.isfinite(ys)
    xs, ys = xs[known], ys[known]
    curve: list[float | None] = []
    for x in columns:
        below = xs <= x
        rows = np.flatnonzero(below[1:] != below[:-1])
        if not len(rows):
            curve.append(None)
            continue
        row = int(rows[0])
        share = (x - xs[row]) / (xs[row + 1] - xs[row])
        curve.append(float(ys[row] + share * (ys[row + 1] - ys[row])))
    return tuple(curve)


def mean_distance(drawn: Curve, truth: Curve) -> float | None:
    """Mean |drawn − truth| over common columns; None below `ENOUGH` of the truth's."""
    known = sum(t is not None for t in truth)
    apart = [abs(a - b) for a, b in zip(drawn, truth, strict=False) if a is not None and b is not None]
    return fmean(apart) if apart and len(apart) >= ENOUGH * known else None


def judge_drawing(drawing: Drawing, drawn: Curve, truth: Curve, language: Language) -> DrawingVerdict | None:
    if not drawn or not any(t is not None for t in truth):
        return None
    words, distance = words_of(language), mean_distance(drawn, truth)
    if distance is None:
        return DrawingVerdict(
            None, words(N_("Too little is drawn to be compared: less than half of the axis."))
        )
    text = words(N_("Your curve is off by {distance} on average."), distance=drawing.text(distance))
    return DrawingVerdict(distance <= drawing.within, text)


def median_curve(curves: Sequence[Curve]) -> Curve:
    columns = [[c[i] for c in curves if c] for i in range(COLUMNS)]
    known = [[value for value in column if value is not None] for column in columns]
    return tuple(median(values) if values else None for values in known) if any(known) else ()


def flat_line(truth: Curve) -> Curve:
    known = [t for t in truth if t is not None]
    return (median(known),) * COLUMNS if known else ()


def drawing_svg(
    drawing: Drawing,
    drawn: Curve,
    truth: Curve,
    others: tuple[Curve, ...] = (),
    earlier: tuple[Curve, ...] = (),
) -> Markup:
    """Axes with curves.

    Args:
        drawn: of one student, or the median of a class.
        earlier: of the class in an earlier round.
    """
    lines = [Line(curve, "first", width=1.0, opacity=0.35) for curve in earlier]
    if earlier:
        lines.append(Line(median_curve(earlier), "first", width=2.6, dash="7 5"))
    lines += [Line(curve, width=1.2, opacity=0.45 if earlier else 0.3) for curve in others]
    if drawn:
        name = tr("median") if others else tr("your curve") if truth else ""
        lines.append(Line(drawn, "", name, 3.4 if others else 2.2, "" if others else "6 4"))
    if truth:
        lines.append(
            Line(truth, drawing.y.colour, tr("by the formula") if drawing.formula else tr("in the run"), 3.0)
        )
    return curve_chart(drawing.x, drawing.y, tuple(lines), axes_text(drawing))
