"""Background studies of a session: started at rest, answered once, dropped when the run changes."""

import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.features.studies import background_studies
from app.features.studies.background_studies import BackgroundStudies, SafetyPoint
from app.features.studies.law_knobs import MATCH, KnobMatch, knobs
from app.features.studies.studies import MOVING, REST, SMOOTHNESS_WINDOW, WINDOW
from app.features.studies.trade_off_charts import map_html, place_on_map, safety_html
from app.session.session import Session
from app.settings import PageSettings, Settings
from scenes.headless import summarise
from scenes.history import COLUMN
from scenes.inputs import CHAPTER
from scenes.rerun import WhatIf, rerun
from scenes.settings import LawSettings, RunSettings
from scenes.smoothness import SUBSTEPS
from scenes.sweep import TRADE_OFF_ORDERS, TRADE_OFF_VELOCITIES, TradeOff
from tests.app.inline import Inline
from tests.app.session.conftest import go

pytestmark = pytest.mark.slow


def running(desk: Inline, seconds: float = 5.0, dt: float = 0.005, **page: Any) -> Session:
    """A session that has run for a while with "what if" on."""
    session = Session(Settings(RunSettings(dt=dt), PageSettings(what_if=True, **page)), background=desk)
    session.parts.of(BackgroundStudies)
    go(session, seconds)
    desk.work("warm")
    return session


def rest_at(desk: Inline, session: Session, key: str, value: Any) -> None:
    """Move a slider, compute the short answer, and wait until the long one is requested."""
    session.change(key, value)
    session.advance(0.0)
    assert desk.work("newest") == ["newest"]
    session.advance(REST)


def answered(desk: Inline, session: Session) -> WhatIf:
    assert len(desk.work("what if")) == 1
    session.advance(0.0)
    answer = session.parts.of(BackgroundStudies).questions.what_if
    assert answer is not None
    return answer


def test_a_short_answer_comes_during_and_a_long_one_after_a_slider_moves(desk: Inline) -> None:
    session = running(desk)
    session.control.toggle_pause()
    for d_m in (0.14, 0.13, 0.12):
        session.change("dm", d_m)
        session.advance(REST * 0.6)
        assert session.parts.of(BackgroundStudies).questions.busy and not desk.waiting("what if")
    # A newer value does not drop the running short answer; otherwise a moving slider would never get one.
    (job,) = desk.waiting("newest")
    assert job.urgent and job.arguments[1]["dm"] == 0.14
    desk.work("newest")
    session.advance(0.0)
    newest = session.parts.of(BackgroundStudies).questions.what_if
    assert (
        newest is not None and newest.settings.law.critical_distance == 0.14 and not desk.waiting("what if")
    )
    (job,) = desk.waiting("newest")
    assert job.arguments[1]["dm"] == 0.12
    desk.work("newest")
    session.advance(REST)
    (job,) = desk.waiting("what if")
    assert job.urgent and session.parts.of(BackgroundStudies).questions.busy
    answer = answered(desk, session)
    assert not session.parts.of(BackgroundStudies).questions.busy
    assert answer.settings == session.settings.run and answer.settings.law.critical_distance == 0.12
    # The curves use the run's clock and are compared with the run itself.
    table = session.simulation.history.table()
    recorded = session.inputs.window(WINDOW)
    assert recorded is not None and recorded.steps == len(table) == 1000
    assert answer.times.tobytes() == table[:, COLUMN["t"]].tobytes()
    again = rerun(recorded, {"dm": 0.12})
    assert answer.distance.tobytes() == again.table[:, COLUMN["d"]].tobytes()
    assert answer.squared_error.tobytes() == again.table[:, COLUMN["e2"]].tobytes()
    assert replace(answer.before, step_us_median=0.0) == replace(
        summarise(session.simulation, table), step_us_median=0.0
    )
    assert answer.summary.d_min < answer.before.d_min - 0.01


@pytest.mark.parametrize("dt", [0.005, 0.002])
def test_the_short_answer_equals_the_end_of_the_long_one(desk: Inline, dt: float) -> None:
    session = running(desk, 13.0, dt=dt)
    session.change("v", 0.6)
    session.advance(0.0)
    desk.work("newest")
    session.advance(0.0)
    newest = session.parts.of(BackgroundStudies).questions.what_if
    assert newest is not None and session.parts.of(BackgroundStudies).questions.busy
    assert MOVING - 1 <= len(newest.times) <= MOVING + CHAPTER / dt
    session.control.toggle_pause()
    session.advance(REST)
    # Another move drops the running long answer.
    (job,) = desk.waiting("what if")
    rest_at(desk, session, "v", 0.7)
    assert job.state == "dropped"
    rest_at(desk, session, "v", 0.6)
    answer = answered(desk, session)
    assert not session.parts.of(BackgroundStudies).questions.busy and len(answer.times) > 1.2 * len(
        newest.times
    )
    # It begins on the unchanged run; the law in question has then pulled it to the same place.
    assert np.interp(newest.times[-1], answer.times, answer.distance) == pytest.approx(
        newest.distance[-1], abs=1e-3
    )


def test_at_small_time_steps_only_the_drawn_part_is_recomputed(
    desk: Inline, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = running(desk, 0.1)
    monkeypatch.setattr(session.simulation, "_capacity", 700)
    session.reset()
    go(session, 5.0)
    session.control.toggle_pause()
    rest_at(desk, session, "dm", 0.1)
    answer = answered(desk, session)
    assert 700 - 2.0 * CHAPTER / 0.005 < len(answer.times) <= 700
    assert answer.times[-1] == session.simulation.history.last().time


@pytest.mark.parametrize(
    ("key", "value"),
    [("wmax", 0.5), ("theme", "dark"), ("seed", 3), ("autopilot", False), ("ghost", "frozen")],
)
def test_only_the_law_and_k_are_studied(desk: Inline, key: str, value: Any) -> None:
    session = running(desk, 1.0)
    session.change(key, value)
    for _ in range(5):
        session.advance(REST)
    assert (
        not session.parts.of(BackgroundStudies).questions.busy
        and not desk.waiting("what if")
        and not desk.waiting("newest")
    )


def test_nothing_is_computed_while_it_is_off_or_without_a_background(desk: Inline) -> None:
    for session in (Session(Settings(page=PageSettings(what_if=True))), Session(Settings(), background=desk)):
        session.advance(0.1)
        session.change("dm", 0.1)
        if session.settings.page.what_if:
            session.parts.of(BackgroundStudies).measure_smoothness()
        session.advance(1.0)
        questions = session.parts.of(BackgroundStudies).questions
        assert (
            questions.what_if is questions.smoothness is None
            and not questions.busy
            and questions.message == ""
        )
        assert not desk.jobs
    # Switching it on prepares a process and computes nothing yet.
    session.change("whatif", True)
    session.advance(1.0)
    assert [job.kind for job in desk.jobs] == ["warm"]


ENDS: dict[str, Callable[[Session], object]] = {
    "off": lambda session: session.change("whatif", False),
    "reset": Session.reset,
    "scene": lambda session: session.change("scene", "solo"),
    "guided": lambda session: session.change("guided", "left"),
    "close": Session.close,
}


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("stage", ["asked", "computing", "answered"])
def test_an_answer_about_another_run_is_dropped(desk: Inline, end: str, stage: str) -> None:
    session = running(desk, 1.5)
    session.change("dm", 0.12)
    if stage != "asked":
        session.advance(0.0)
        assert len(desk.waiting("newest")) == 1
    if stage == "answered":
        desk.work("newest")
        session.advance(REST)
        answered(desk, session)
    ENDS[end](session)
    session.advance(1.0)
    assert (
        session.parts.of(BackgroundStudies).questions.what_if is None
        and not session.parts.of(BackgroundStudies).questions.busy
    )
    assert not desk.waiting("what if") and not desk.waiting("newest")


def test_another_move_replaces_the_request_and_a_failure_is_named(desk: Inline) -> None:
    session = running(desk, 1.5)
    rest_at(desk, session, "k", 3.0)
    (old,) = desk.waiting("what if")
    rest_at(desk, session, "k", 4.0)
    (job,) = desk.waiting("what if")
    assert old.state == "dropped" and job is not old
    job.state, job.message = "failed", "The computation was ended from outside; ask for it again."
    session.advance(0.0)
    assert (
        session.parts.of(BackgroundStudies).questions.message == job.message
        and not session.parts.of(BackgroundStudies).questions.busy
    )
    rest_at(desk, session, "k", 5.0)
    assert (
        answered(desk, session).settings.gain == 5.0
        and session.parts.of(BackgroundStudies).questions.message == ""
    )


def test_the_run_is_unchanged_by_studies(desk: Inline) -> None:
    alone, asking = Session(Settings()), running(desk, 0.0)
    for i in range(30):
        for session in (alone, asking):
            session.change("dm", 0.1 + 0.001 * i)
            session.advance(0.11)
        desk.work()
    assert asking.parts.of(BackgroundStudies).questions.what_if is not None
    assert asking.simulation.history.table().tobytes() == alone.simulation.history.table().tobytes()


def test_smoothness_of_the_law_and_of_the_ghost(desk: Inline) -> None:
    session = running(desk, 4.5, ghost="strict_switched")
    questions = session.parts.of(BackgroundStudies).questions
    go(session, 1.0)
    session.parts.of(BackgroundStudies).measure_smoothness()
    assert questions.busy and questions.smoothness is not None and not questions.smoothness.finished
    assert len(desk.waiting("smoothness")) == 2 * len(SUBSTEPS)
    # The answers arrive one by one, in any order.
    for job in reversed(desk.waiting("smoothness")[:-2]):
        job.arguments = (job.arguments[0], job.arguments[1], 1)  # The coarsest is quick.
        job.result, job.state = 0.5, "done"
    session.advance(0.0)
    law, ghost = questions.smoothness.law, questions.smoothness.ghost
    assert ghost is not None and law.largest == (0.5, 0.5, 0.5, None) == ghost.largest
    assert law.verdict == "measuring" and law.settings == session.settings.run
    assert ghost.settings.law.law == "strict_switched"
    assert law.seconds <= SMOOTHNESS_WINDOW + CHAPTER and law.dts == (0.005, 0.0025, 0.00125, 0.000625)
    desk.work("smoothness")
    session.advance(0.0)
    assert questions.smoothness.finished and not questions.busy
    ghost = questions.smoothness.ghost
    # The smooth law's real step at dt/8 is far below 0.5; the ghost's hard switch jumps.
    assert questions.smoothness.law.largest[3] is not None and questions.smoothness.law.largest[3] < 0.01
    assert (
        ghost is not None
        and ghost.largest[3] is not None
        and ghost.largest[3] > 0.1
        and ghost.verdict == "jump"
    )


def test_smoothness_needs_data_restarts_on_request_and_is_dropped_by_a_reset(
    desk: Inline,
) -> None:
    session = running(desk, 0.1)
    questions = session.parts.of(BackgroundStudies).questions
    session.parts.of(BackgroundStudies).measure_smoothness()
    assert (
        questions.smoothness is None and "few seconds" in questions.message and not desk.waiting("smoothness")
    )
    go(session, 0.9)
    session.parts.of(BackgroundStudies).measure_smoothness()
    first = desk.waiting("smoothness")
    session.parts.of(BackgroundStudies).measure_smoothness()
    assert all(job.state == "dropped" for job in first) and len(desk.waiting("smoothness")) == len(SUBSTEPS)
    (job, *_) = desk.waiting("smoothness")
    job.state, job.message = "failed", "The computation failed."
    session.advance(0.0)
    assert (
        questions.smoothness is None and questions.message == job.message and not desk.waiting("smoothness")
    )
    session.parts.of(BackgroundStudies).measure_smoothness()
    assert questions.message == ""
    session.reset()
    assert questions.smoothness is None and not questions.busy and not desk.waiting("smoothness")


RUN = RunSettings(dt=0.02)
"""Coarse steps, for speed."""


@pytest.mark.parametrize(
    ("study", "unlike", "alike"),
    [
        ("trade_off", {"critical_distance": 0.1}, {"order": 3.0, "nominal_velocity": 0.5}),
        ("safety_curves", {"convexity": 1e-3}, {"law": "barrier_qp", "feed_forward": True}),
    ],
    ids=["map", "curves"],
)
def test_a_study_grows_and_is_computed_once(
    desk: Inline, monkeypatch: pytest.MonkeyPatch, study: str, unlike: dict[str, Any], alike: dict[str, Any]
) -> None:
    """All points in the end; the varied and the compared settings do not restart a study, others do."""
    monkeypatch.setattr(background_studies, "SECONDS", 5.0)
    news: list[int] = []
    made = getattr(Session(Settings(), lambda: news.append(1), desk).parts.of(BackgroundStudies), study)
    assert made.results(RUN) == {} and made.size == 0.0
    jobs, seen = desk.waiting(), [0]
    for number, job in enumerate(jobs, 1):
        # As through another process: request and result are pickled.
        assert pickle.loads(pickle.dumps((job.function, job.arguments))) == (job.function, job.arguments)
        assert desk.work(job.kind) == [job.kind] and len(news) == number
        assert pickle.loads(pickle.dumps(job.result)) == job.result
        seen.append(sum(map(len, made.results(RUN).values())))
        assert made.size == number / len(jobs) and seen[-1] > seen[-2]
    rows = made.results(replace(RUN, law=replace(RUN.law, **alike)))
    points = [point for row in rows.values() for point in row]
    if study == "trade_off":
        at = {(p.order, p.nominal_velocity): p for p in points}
        assert set(at) == {(n, v) for n in TRADE_OFF_ORDERS for v in TRADE_OFF_VELOCITIES}
        # A larger n lets the arm give way later: smaller distance, smaller error.
        far, near = at[2.0, 0.3], at[16.0, 0.3]
    else:
        assert tuple(rows) == knobs() and all(
            len(row) == len(knob.setting.points) for knob, row in rows.items()
        )
        assert all(list(row) == sorted(row) for row in rows.values())
        near, *_, far = rows[knobs()[0]]
    assert near.d_min < far.d_min and near.e2_max < far.e2_max
    assert made.results(replace(RUN, law=replace(RUN.law, **unlike))) == {} and len(desk.waiting()) == len(
        jobs
    )
    made.forget()
    assert not desk.waiting()


@pytest.mark.parametrize(("n", "v"), [(1.0, 0.1), (4.0, 0.3), (16.0, 0.7)])
def test_the_present_settings_are_on_the_map(n: float, v: float) -> None:
    """On a grid point, at it; between points, between; outside, at the edge; nowhere with missing points."""
    # A map with simple numbers: d_min = n/100, |e| = v.
    whole = tuple(TradeOff(n, v, n / 100.0, v**2) for n in TRADE_OFF_ORDERS for v in TRADE_OFF_VELOCITIES)

    def run(n: float, v: float) -> RunSettings:
        return RunSettings(law=LawSettings(order=n, nominal_velocity=v))

    assert place_on_map(whole, run(n, v)) == pytest.approx((n / 100.0, v))
    between = place_on_map(whole, run(3.0, 0.25))
    assert between is not None and 0.02 < between[0] < 0.04 and 0.2 < between[1] < 0.3
    assert place_on_map(whole, run(20.0, 1.0)) == pytest.approx((0.16, 0.7))
    assert place_on_map(whole[:-1], run(n, v)) is None
    text = map_html(whole, 1.0, run(n, v), 200)
    assert text.count("n = ") == len(TRADE_OFF_ORDERS) and "computed" not in text
    assert "40\N{NO-BREAK SPACE}% computed" in map_html(whole[:10], 0.4, run(n, v), 200)


def test_the_chart_names_every_law_that_has_a_knob() -> None:
    curves = {knob: (SafetyPoint(0.1, 0.01), SafetyPoint(0.2, 0.05)) for knob in knobs()}
    text = safety_html(curves, 1.0, RUN, 200)
    assert text.count("<li") == len({knob.law for knob in knobs()}) and "computed" not in text
    assert "40\N{NO-BREAK SPACE}% computed" in safety_html({}, 0.4, RUN, 200)
    assert "[rad²]" in safety_html({}, 1.0, replace(RUN, scene="master_slave"), 200)


def beside_a_ghost(desk: Inline, ghost: str) -> Session:
    session = Session(Settings(RUN, PageSettings(ghost=ghost)), background=desk)
    go(session, 8.0)
    return session


def searched(desk: Inline, session: Session) -> KnobMatch:
    """Outcome of a search after the session has applied it."""
    assert desk.work("knob") == ["knob"]
    session.advance(0.0)
    assert not session.parts.of(BackgroundStudies).knob_search.busy
    return [job for job in desk.jobs if job.kind == "knob"][-1].result


def test_the_button_sets_the_knob_and_keeps_the_present_law_as_the_ghost(desk: Inline) -> None:
    session = beside_a_ghost(desk, "barrier_qp")
    session.parts.of(BackgroundStudies).match_distance()
    assert session.parts.of(BackgroundStudies).knob_search.busy
    found = searched(desk, session)
    assert found.value is not None and abs(found.reached - found.wanted) <= MATCH
    law = session.settings.run.law
    assert law.law == "barrier_qp" and law.critical_distance == found.value != LawSettings().critical_distance
    assert session.settings.page.ghost == "frozen" and session.ghost is not None
    assert session.ghost.settings.law == LawSettings()
    said = session.parts.of(BackgroundStudies).knob_search.message
    assert "d_m = " in said and f"{1000.0 * found.wanted:.0f} mm" in said
    # With the frozen ghost, the next law is also compared with it.
    session.change("law", "intermediate_value")
    session.parts.of(BackgroundStudies).match_distance()
    again = searched(desk, session)
    assert (
        again.law == session.settings.run.law.law == "intermediate_value"
        and again.wanted == pytest.approx(found.wanted)
    )
    assert session.ghost.settings.law == LawSettings()


def test_a_search_with_a_frozen_ghost_uses_its_hardware(desk: Inline) -> None:
    session = beside_a_ghost(desk, "frozen")
    session.change("dead", 0.05)
    go(session, 4.0)
    session.change("law", "intermediate_value")
    session.parts.of(BackgroundStudies).match_distance()
    asked = [job for job in desk.jobs if job.kind == "knob"][-1].arguments[1]
    assert session.ghost is not None and asked["dead"] == session.ghost.settings.hardware.dead_time == 0.0


def test_an_impossible_match_is_reported_and_changes_nothing(desk: Inline) -> None:
    session = beside_a_ghost(desk, "null_space_avoidance")
    before = session.settings
    session.parts.of(BackgroundStudies).match_distance()
    found = searched(desk, session)
    assert found.value is None
    assert (
        session.settings == before
        and "No value of d_0 helps" in session.parts.of(BackgroundStudies).knob_search.message
    )
    search = session.parts.of(BackgroundStudies).knob_search
    search._asked = session.settings
    search._found(replace(found, wanted=-0.0334))
    assert "as near as −33 mm" in search.message
    session.change("ghost", "off")
    session.parts.of(BackgroundStudies).match_distance()
    assert (
        not session.parts.of(BackgroundStudies).knob_search.busy
        and "choose another law as the ghost" in session.parts.of(BackgroundStudies).knob_search.message
    )
    session.change("ghost", "barrier_qp")
    session.parts.of(BackgroundStudies).match_distance()
    session.change("dm", 0.12)
    searched(desk, session)
    assert (
        session.settings.run.law.law == "smooth_priority"
        and "changed since then" in session.parts.of(BackgroundStudies).knob_search.message
    )
    session.close()
    fresh = Session(session.settings, background=desk)
    fresh.parts.of(BackgroundStudies).match_distance()
    assert "too little to measure" in fresh.parts.of(BackgroundStudies).knob_search.message
