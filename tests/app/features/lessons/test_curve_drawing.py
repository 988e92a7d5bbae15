"""A drawn prediction: checks of browser data, the true curve of the run, and the score as a mean distance."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.features.lessons.bookmark import Phase
from app.features.lessons.curve_drawing import (
    drawing_svg,
    first_met,
    flat_line,
    judge_drawing,
    mean_distance,
    median_curve,
)
from app.features.lessons.outcomes import reference
from app.features.lessons.progress import from_json, to_json
from app.features.lessons.reference_runs import simulated
from app.features.lessons.walkthrough import Walkthrough
from app.plots.curve_chart import COLUMNS, Curve, CurveAxis, path_of
from app.plots.drawing_axes import UNSEEN, Drawing, activation_axes, checked_curve, curve_from_text, law_curve
from controllers.curve import curve_through
from tests.app.features.lessons.helpers import our_book
from tests.approved import Approve

AXIS = CurveAxis("d", "mm", 1000.0, "d", 0.1, 0.5)
DRAWING = Drawing("time", "distance", CurveAxis("t", "s", 1.0, "", 0.0, 4.0), AXIS, False, 0.02)
GAPPED = st.lists(st.none() | st.floats(0.0, 1.0), min_size=COLUMNS, max_size=COLUMNS)
VALUES = st.lists(st.none() | st.floats(0.1, 0.5), min_size=COLUMNS, max_size=COLUMNS).map(tuple)

few = settings(max_examples=30)
"""Fewer examples, because each one has a value for every column of a curve."""


@given(GAPPED)
@few
def test_drawn_heights_arrive_as_values_of_the_axis(heights: list[float | None]) -> None:
    curve = curve_from_text(DRAWING, json.dumps(heights))
    assert curve is not None
    if all(h is None for h in heights):
        assert curve == ()
        return
    for height, value in zip(heights, curve, strict=True):
        assert (height is None) == (value is None)
        if height is not None and value is not None:
            assert value == pytest.approx(0.1 + 0.4 * height) and AXIS.fraction(value) == pytest.approx(
                height, abs=1e-9
            )
    assert path_of(curve, AXIS).count("M") == sum(
        h is not None and (i == 0 or heights[i - 1] is None) for i, h in enumerate(heights)
    )


@given(
    st.text()
    | st.integers()
    | st.none()
    | st.recursive(st.none() | st.floats() | st.text(), st.lists).map(json.dumps)
)
def test_other_data_never_gives_values_outside_the_axis(sent: object) -> None:
    curve = curve_from_text(DRAWING, sent)
    assert (
        curve is None
        or curve == ()
        or (len(curve) == COLUMNS and all(v is None or 0.1 <= v <= 0.5 for v in curve))
    )


@pytest.mark.parametrize("bad", [math.nan, math.inf, -0.1, 1.1, True, "1", [1.0]])
def test_one_invalid_height_makes_the_curve_invalid(bad: object) -> None:
    assert curve_from_text(DRAWING, json.dumps([0.5] * COLUMNS)) is not None
    assert curve_from_text(DRAWING, json.dumps([0.5] * (COLUMNS - 1) + [bad])) is None
    assert curve_from_text(DRAWING, json.dumps([0.5] * (COLUMNS + 1))) is None
    assert curve_from_text(DRAWING, json.dumps([0.5] * COLUMNS) + " " * 3000) is None


@given(GAPPED.filter(lambda heights: any(h is not None for h in heights)))
@few
@example([i / (COLUMNS - 1) for i in range(COLUMNS)])
def test_the_law_follows_the_drawn_curve(drawn: list[float | None]) -> None:
    axes = activation_axes(0.15, (0.0, 0.4))
    runs = curve_through(law_curve(axes, tuple(drawn)))
    for d, lam in zip(axes.columns, drawn, strict=True):
        assert lam is None or runs.height(d) == pytest.approx(lam, abs=UNSEEN)


@given(VALUES, VALUES)
@few
def test_the_score_is_the_mean_distance_where_both_are_known(drawn: Curve, truth: Curve) -> None:
    both = [abs(a - b) for a, b in zip(drawn, truth, strict=True) if a is not None and b is not None]
    known = sum(t is not None for t in truth)
    score = mean_distance(drawn, truth)
    assert (score is None) == (not both or 2 * len(both) < known)
    if score is not None:
        assert score == pytest.approx(float(np.mean(both))) and mean_distance(truth, drawn) in (
            None,
            pytest.approx(score),
        )
    if known:
        assert mean_distance(truth, truth) == 0.0


@given(VALUES.filter(lambda values: any(v is not None for v in values)), st.floats(0.1, 0.5))
@few
def test_no_flat_line_is_nearer_than_the_checks_flat_line(truth: Curve, level: float) -> None:
    best, other = mean_distance(flat_line(truth), truth), mean_distance((level,) * COLUMNS, truth)
    assert best is not None and other is not None and best <= other + 1e-12


def test_the_verdict_on_a_curve_has_the_right_tolerance_in_words(approve: Approve) -> None:
    truth = (0.2,) * COLUMNS
    near, far = (judge_drawing(DRAWING, (0.2 + by,) * COLUMNS, truth, "en") for by in (0.0111, 0.0201))
    assert near is not None and near.right
    assert far is not None and far.right is False
    little = judge_drawing(DRAWING, (0.2,) * 20 + (None,) * 28, truth, "en")
    assert little is not None and little.right is None
    approve("drawing.txt", "".join(f"{one.text}\n" for one in (near, far, little)))
    assert judge_drawing(DRAWING, (), truth, "en") is None and judge_drawing(DRAWING, truth, (), "en") is None


def test_the_true_curve_has_the_runs_first_value_per_column() -> None:
    xs, ys = np.array([0.0, 1.0, 3.0, 1.0, np.nan, 5.0]), np.array([0.0, 10.0, 30.0, 99.0, 7.0, 50.0])
    assert first_met(xs, ys, (0.5, 2.0, 4.0, 6.0)) == (5.0, 20.0, pytest.approx(62.25), None)
    assert first_met(xs[:0], ys[:0], (1.0,)) == (None,)


def test_the_median_of_a_class_ignores_gaps_per_column() -> None:
    curves: list[Curve] = [(low,) * 24 + (None,) * 24 for low in (0.1, 0.2)] + [(0.5,) * 47 + (None,)]
    assert median_curve(curves) == (0.2,) * 24 + (0.5,) * 23 + (None,)
    assert median_curve([]) == () == median_curve([()])


def test_a_curve_answers_a_step_and_survives_a_reload() -> None:
    walk = Walkthrough(our_book())
    walk.go("hold")
    drawing = walk.step.drawing
    assert drawing is not None and walk.plots == walk.step.plots and not walk.next()
    truth = reference(walk.step, walk.step.setup).curve
    assert truth[0] == pytest.approx(0.324, abs=2e-3) and None not in truth
    assert (
        walk.draw((0.3,) * COLUMNS)
        and walk.draw(truth)
        and not walk.draw((9.0,) * COLUMNS)
        and not walk.draw((0.3,))
    )
    assert walk.phase is Phase.PREDICT and not walk.view().locked
    again = Walkthrough(our_book(), walk.to_json())
    assert again.done.drawing == truth and again.phase is Phase.PREDICT and again.view().drawing is not None
    assert walk.next() and walk.phase is Phase.DO and not walk.draw(truth), "the run may be visible now"
    view = walk.view()
    assert view.drawing is not None and view.drawing.truth == () and view.drawing.verdict is None
    walk.observe(simulated(walk.setup))
    view = walk.view()
    assert walk.phase is Phase.OBSERVE and view.verdict is None and view.drawing is not None
    assert (
        view.drawing.truth == pytest.approx(truth)
        and view.drawing.verdict is not None
        and view.drawing.verdict.right
    )
    svg = drawing_svg(drawing, view.drawing.drawn, view.drawing.truth)
    assert "your curve" in svg and "in the run" in svg
    svg = drawing_svg(drawing, truth, truth, (truth,))
    found = re.search(r'<text x="(\d+)"[^>]*>\s*median\s*</text>.*?d="M(\d+) 10h20"', svg, re.DOTALL)
    assert found is not None and int(found[1]) - 45 >= int(found[2]) + 20 + 4, (
        "median has 45 px in DejaVu Sans"
    )
    walk.reset()
    assert walk.done.drawing == () and walk.draw(()) and walk.done.untouched
    again.go("lambda", 1)
    assert again.plots == ("distance",) and again.step.plots == ("curve", "distance")
    again.choose(0)
    assert again.plots == again.step.plots, "all plots are shown after the answer"


def test_saved_curves_that_do_not_fit_the_axes_are_dropped() -> None:
    walk = Walkthrough(our_book())
    walk.go("hold")
    drawing = walk.step.drawing
    assert drawing is not None and walk.draw((0.3,) * COLUMNS)
    kept = from_json(walk.to_json())
    for bad in ((0.3,) * 7, (99.0,) * COLUMNS, ("x",) * COLUMNS):
        assert not checked_curve(drawing, bad)
        kept.steps["hold", "push"].drawing = bad  # type: ignore[assignment]
        assert Walkthrough(our_book(), to_json(kept)).done.drawing == ()
