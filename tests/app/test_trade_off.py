"""The map of n and v: computed apart, row by row, and again only when something else has changed; where the present settings lie."""

import threading
from dataclasses import replace

import pytest

from app.plots.trade_off_chart import map_html, place_of
from app.runtime.job_pool import JobPool
from app.session.trade_off import trade_off_map
from scenes.settings import LawSettings, RunSettings
from scenes.sweep import TRADE_OFF_ORDERS, TRADE_OFF_VELOCITIES, TradeOff

RUN = RunSettings(dt=0.02)
"""Coarse steps, for speed."""


def test_the_map_grows_and_is_computed_once(request: pytest.FixtureRequest) -> None:
    """Every point of every n in the end; n and v themselves do not begin it again, anything else does."""
    news, background = threading.Event(), JobPool(1)
    request.addfinalizer(background.close)
    made = trade_off_map(background, news.set)
    assert made.results(RUN) == {} and made.size == 0.0
    seen = [0]
    while made.size < 1.0:
        assert news.wait(60.0)
        news.clear()
        seen.append(sum(map(len, made.results(RUN).values())))
    assert seen == sorted(seen)
    points = [
        point
        for row in made.results(replace(RUN, law=replace(RUN.law, order=3.0, nominal_velocity=0.5))).values()
        for point in row
    ]
    assert {(p.order, p.nominal_velocity) for p in points} == {(n, v) for n in TRADE_OFF_ORDERS for v in TRADE_OFF_VELOCITIES}
    # The larger n, the later the arm gives way: nearer, and with a smaller error.
    at = {(p.order, p.nominal_velocity): p for p in points}
    assert at[16.0, 0.3].d_min < at[2.0, 0.3].d_min and at[16.0, 0.3].e2_max < at[2.0, 0.3].e2_max
    assert made.results(replace(RUN, law=replace(RUN.law, critical_distance=0.1))) == {}
    made.forget()


@pytest.mark.parametrize(("n", "v"), [(1.0, 0.1), (4.0, 0.3), (16.0, 0.7)])
def test_the_present_settings_lie_on_the_map(n: float, v: float) -> None:
    """On a point of the grid, at that point; beside it, between; beyond it, at its edge; nowhere while points are missing."""
    # A map whose numbers are easily known: d_min = n/100, |e| = v.
    whole = tuple(TradeOff(n, v, n / 100.0, v**2) for n in TRADE_OFF_ORDERS for v in TRADE_OFF_VELOCITIES)

    def run(n: float, v: float) -> RunSettings:
        return RunSettings(law=LawSettings(order=n, nominal_velocity=v))

    assert place_of(whole, run(n, v)) == pytest.approx((n / 100.0, v))
    between = place_of(whole, run(3.0, 0.25))
    assert between is not None and 0.02 < between[0] < 0.04 and 0.2 < between[1] < 0.3
    assert place_of(whole, run(20.0, 1.0)) == pytest.approx((0.16, 0.7))
    assert place_of(whole[:-1], run(n, v)) is None
    text = map_html(whole, 1.0, run(n, v), 200)
    assert text.count("n = ") == len(TRADE_OFF_ORDERS) and "computed" not in text
    assert "40 % computed" in map_html(whole[:10], 0.4, run(n, v), 200)
