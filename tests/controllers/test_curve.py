"""λ(d) through given points: interpolation, no overshoot, and messages for invalid texts."""

import math
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from controllers.curve import MOST_POINTS, curve_points, curve_text, curve_through, kept_distance, read_curve
from controllers.errors import BadSetting
from controllers.laws.drawn_curve import DrawnCurve

HEIGHTS = st.floats(0.0, 1.0).map(lambda x: float(f"{x:.6g}"))


@st.composite
def texts(draw: st.DrawFn) -> str:
    places = sorted(draw(st.lists(st.integers(-2000, 2000), min_size=2, max_size=MOST_POINTS, unique=True)))
    return curve_text(tuple((1e-3 * place, draw(HEIGHTS)) for place in places))


@given(texts(), st.floats(0.0, 1.0))
def test_the_curve_passes_its_points_without_overshoot(text: str, share: float) -> None:
    curve = curve_through(text)
    assert read_curve(text) == text
    for (d, lam), (after, then) in pairwise(curve_points(text)):
        assert curve.height(d) == pytest.approx(lam, abs=1e-12) and curve.height(after) == pytest.approx(
            then, abs=1e-12
        )
        between = curve.height(d + share * (after - d))
        assert min(lam, then) - 1e-12 <= between <= max(lam, then) + 1e-12
    first, last = curve.distances[0], curve.distances[-1]
    assert curve.height(first - 1.0) == curve.heights[0] and curve.height(last + 1.0) == curve.heights[-1]


@given(texts(), st.floats(-2.0, 2.0))
def test_the_slope_has_no_jump(text: str, at: float) -> None:
    curve, h = curve_through(text), 1e-7
    assume(min(abs(at - d) for d in curve.distances) > 2 * h)
    for d in (at, *curve.distances):
        left, right = ((curve.height(d + side * h) - curve.height(d)) / (side * h) for side in (-1.0, 1.0))
        # A second derivative is at most 6 |Δλ| / h² plus the slopes' share, with steps h of at least 1 mm.
        assert left == pytest.approx(right, abs=24.0e6 * h)


@given(texts(), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_a_falling_curve_falls_everywhere(text: str, a: float, b: float) -> None:
    points = curve_points(text)
    falling = sorted((lam for _, lam in points), reverse=True)
    curve = curve_through(curve_text(tuple((d, lam) for (d, _), lam in zip(points, falling, strict=True))))
    assert curve.height(min(a, b)) >= curve.height(max(a, b)) - 1e-12


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "cannot be read"), ("0.1", "cannot be read"), ("0.1:1", "2 to 48"), ("0.1:1;0.2:0", "cannot be read"), ("a:b,c:d", "0.15:1"),
        (",".join(f"{i / 100}:0" for i in range(49)), "not 49"), ("0.2:1,0.1:0", "0.2 comes before 0.1"), ("0.1:1,0.1:0", "0.1 mm"),
        ("0.1:1.2,0.2:0", "0.1:1.2"), ("0.1:nan,0.2:0", "out of range"), ("nan:1,0.2:0", "out of range"), ("0.1:1,3:0", "3:0"),
        ("0.1:1:2,0.2:0", "cannot be read"),
    ],
)  # fmt: skip
def test_an_invalid_text_is_refused_in_one_line(text: str, named: str) -> None:
    with pytest.raises(BadSetting, match=named) as caught:
        read_curve(text)
    assert "\n" not in str(caught.value)


def test_the_kept_distance() -> None:
    assert kept_distance("0.1:1,0.2:1,0.3:0.5") == 0.2
    assert kept_distance("0.1:1,0.2:0.5,0.3:1") == 0.1
    assert kept_distance("0.1:0.99,0.2:0") is None


def test_at_rest_retreat_and_pull_are_equal() -> None:
    law = DrawnCurve("0.1:1,0.2:0.25,0.4:0", 0.3)
    for d in (0.05, 0.1, 0.15, 0.2, 0.3, 0.5):
        lam = law.activation(d)
        assert law.correction(d, 0.7, 0.0) - 0.7 == pytest.approx(lam * 0.3 - (1.0 - lam) * 0.7)
    assert law.activation(0.2) == 0.25 and law.activation(math.inf) == 0.0
