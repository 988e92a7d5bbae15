"""The page at equal safety: curves of all laws computed apart, and a button that sets a law's knob to the same distance."""

import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from app.plots.safety_chart import safety_html
from app.runtime.job_pool import JobPool
from app.session.safety_curves import SafetyPoint, safety_curves
from app.session.session import Session
from app.settings import PageSettings, Settings
from scenes.law_knobs import KNOBS, MATCH, KnobMatch
from scenes.settings import LawSettings, RunSettings
from tests.app.inline import Inline

RUN = RunSettings(dt=0.02)
"""Coarse steps, for speed."""


@pytest.fixture
def background() -> Iterator[JobPool]:
    pool = JobPool(1)
    yield pool
    pool.close()


def test_the_curves_come_one_by_one_and_are_computed_once(background: JobPool) -> None:
    news = threading.Event()
    made = safety_curves(background, news.set)
    assert made.results(RUN) == {} and made.size == 0.0
    while made.size < 1.0:
        assert news.wait(60.0)
        news.clear()
    curves = made.results(replace(RUN, law=replace(RUN.law, law="barrier_qp", feed_forward=True)))
    assert tuple(curves) == KNOBS and made.size == 1.0
    for knob, points in curves.items():
        assert len(points) == len(knob.points) and list(points) == sorted(points)
    paper = curves[KNOBS[0]]
    assert paper[0].d_min < paper[-1].d_min and paper[0].e2_max < paper[-1].e2_max
    assert made.results(replace(RUN, gain=5.0)) == {}
    made.forget()


def test_the_chart_names_every_law_that_has_a_knob() -> None:
    curves = {knob: (SafetyPoint(0.1, 0.01), SafetyPoint(0.2, 0.05)) for knob in KNOBS}
    text = safety_html(curves, 1.0, RUN, 200)
    assert text.count("<li") == len({knob.law for knob in KNOBS}) and "computed" not in text
    assert "40 % computed" in safety_html({}, 0.4, RUN, 200)
    assert "[rad²]" in safety_html({}, 1.0, replace(RUN, scene="master_slave"), 200)


def running(desk: Inline, **page: Any) -> Session:
    session = Session(Settings(RUN, PageSettings(**page)), background=desk)
    for _ in range(80):
        session.advance(0.1)
    return session


def searched(desk: Inline, session: Session) -> KnobMatch:
    """The outcome of a search, which the session has taken in."""
    assert desk.work("knob") == ["knob"]
    session.advance(0.0)
    assert not session.knob_search.busy
    return [job for job in desk.jobs if job.kind == "knob"][-1].result


def test_the_button_sets_the_knob_and_keeps_the_present_law_as_the_ghost() -> None:
    desk = Inline()
    session = running(desk, ghost="barrier_qp")
    session.match_distance()
    assert session.knob_search.busy
    found = searched(desk, session)
    assert found.value is not None and abs(found.reached - found.wanted) <= MATCH
    law = session.settings.run.law
    assert law.law == "barrier_qp" and law.critical_distance == found.value != LawSettings().critical_distance
    assert session.settings.page.ghost == "frozen" and session.ghost is not None
    assert session.ghost.settings.law == LawSettings()
    assert "d_m = " in session.knob_search.message and f"{1000.0 * found.wanted:.0f} mm" in session.knob_search.message
    # Beside the frozen ghost, the next law is measured against it, too.
    session.change("law", "intermediate_value")
    session.match_distance()
    again = searched(desk, session)
    assert again.law == session.settings.run.law.law == "intermediate_value" and again.wanted == pytest.approx(found.wanted)
    assert session.ghost.settings.law == LawSettings()


def test_what_cannot_be_matched_is_said_and_changes_nothing() -> None:
    desk = Inline()
    session = running(desk, ghost="null_space_avoidance")
    before = session.settings
    session.match_distance()
    assert searched(desk, session).value is None
    assert session.settings == before and "No value of d_0 helps" in session.knob_search.message
    session.change("ghost", "off")
    session.match_distance()
    assert not session.knob_search.busy and "choose another law as the ghost" in session.knob_search.message
    session.change("ghost", "barrier_qp")
    session.match_distance()
    session.change("dm", 0.12)
    searched(desk, session)
    assert session.settings.run.law.law == "smooth_priority" and "changed meanwhile" in session.knob_search.message
    session.close()
    fresh = Session(session.settings, background=desk)
    fresh.match_distance()
    assert "too little to measure" in fresh.knob_search.message
