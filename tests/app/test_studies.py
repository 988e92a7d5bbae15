"""What a session has computed beside its run: asked when a slider rests, answered once, dropped when it is about another run."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from app.page.panels.compare import what_if_html
from app.session.session import Session
from app.session.studies import DRAFT_WINDOW, REST, SMOOTHNESS_WINDOW, WINDOW
from app.settings import PageSettings, Settings
from scenes import rerun as rerun_module
from scenes.headless import summarise
from scenes.history import COLUMN
from scenes.inputs import CHAPTER
from scenes.rerun import WhatIf, rerun
from scenes.settings import RunSettings
from scenes.smoothness import SUBSTEPS
from tests.app.inline import Inline

pytestmark = pytest.mark.usefixtures("fast_machine")


@pytest.fixture
def desk() -> Inline:
    return Inline()


def running(desk: Inline, seconds: float = 5.0, **page: Any) -> Session:
    """A session that has run for a while, with "what if" on."""
    session = Session(Settings(RunSettings(), PageSettings(what_if=True, **page)), background=desk)
    for _ in range(round(seconds / 0.1)):
        session.advance(0.1)
    desk.work("warm")
    return session


def rest_at(desk: Inline, session: Session, key: str, value: Any) -> None:
    """Move a slider, give the draft, and let the slider rest, until the question about it is put."""
    session.change(key, value)
    session.advance(0.0)
    assert desk.work("draft") == ["draft"]
    session.advance(REST)


def answered(desk: Inline, session: Session) -> WhatIf:
    assert len(desk.work("what if")) == 1
    session.advance(0.0)
    assert session.what_if is not None
    return session.what_if


def test_a_draft_comes_while_the_slider_moves_and_the_exact_answer_when_it_rests(desk: Inline) -> None:
    session = running(desk)
    session.toggle_pause()
    for d_m in (0.14, 0.13, 0.12):
        session.change("dm", d_m)
        session.advance(REST * 0.6)
        assert session.studies.busy and not desk.waiting("what if")
    # The draft under way is not dropped for a newer value, or there would be none as long as the slider moves.
    (job,) = desk.waiting("draft")
    assert job.urgent and job.arguments[1]["dm"] == 0.14
    desk.work("draft")
    session.advance(0.0)
    draft = session.what_if
    assert draft is not None and draft.settings.law.critical_distance == 0.14 and not desk.waiting("what if")
    (job,) = desk.waiting("draft")
    assert job.arguments[1]["dm"] == 0.12
    desk.work("draft")
    session.advance(REST)
    (job,) = desk.waiting("what if")
    assert job.urgent and session.studies.busy
    answer = answered(desk, session)
    assert not session.studies.busy and answer.stride == 1
    assert answer.settings == session.settings.run and answer.settings.law.critical_distance == 0.12
    # The curves are of the run's own clock, and what they are compared with is the run itself.
    table = session.simulation.history.table()
    recorded = session.recorded(WINDOW)
    assert recorded is not None and recorded.steps == len(table) == 1000
    assert answer.times.tobytes() == table[:, COLUMN["t"]].tobytes()
    again = rerun(recorded, {"dm": 0.12})
    assert answer.distance.tobytes() == again.table[:, COLUMN["d"]].tobytes()
    assert answer.squared_error.tobytes() == again.table[:, COLUMN["e2"]].tobytes()
    assert replace(answer.before, step_us_median=0.0) == replace(summarise(session.simulation, table), step_us_median=0.0)
    assert answer.summary.d_min < answer.before.d_min - 0.01


def test_a_draft_is_coarse_and_shorter(desk: Inline, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rerun_module, "perf_counter", itertools.count(1.0).__next__)
    session = running(desk, 13.0)
    session.change("v", 0.6)
    session.advance(0.0)
    desk.work("draft")
    session.advance(0.0)
    draft = session.what_if
    assert draft is not None and draft.stride == 4 and session.studies.busy
    assert DRAFT_WINDOW - 0.1 < draft.seconds <= DRAFT_WINDOW + CHAPTER
    assert "in steps of 20 ms" in what_if_html(draft)
    session.advance(REST)
    # Moving on drops the exact answer that is being computed.
    (job,) = desk.waiting("what if")
    rest_at(desk, session, "v", 0.7)
    assert job.state == "dropped"
    exact = answered(desk, session)
    assert exact.stride == 1 and not session.studies.busy and "in steps" not in what_if_html(exact)
    assert exact.settings.law.nominal_velocity == 0.7 and len(exact.times) > 5 * len(draft.times)
    assert exact.times[-1] >= draft.times[-1]


def test_at_small_time_steps_only_what_is_drawn_is_made_again(desk: Inline, monkeypatch: pytest.MonkeyPatch) -> None:
    session = running(desk, 0.1)
    monkeypatch.setattr(session.simulation.history, "_capacity", 700)
    session.reset()
    for _ in range(50):
        session.advance(0.1)
    session.toggle_pause()
    rest_at(desk, session, "dm", 0.1)
    answer = answered(desk, session)
    assert 700 - 2.0 * CHAPTER / 0.005 < len(answer.times) <= 700
    assert answer.times[-1] == session.simulation.history.last().time


@pytest.mark.parametrize(
    ("key", "value"), [("wmax", 0.5), ("theme", "dark"), ("seed", 3), ("autopilot", False), ("ghost", "frozen")]
)
def test_only_the_law_and_k_are_asked_about(desk: Inline, key: str, value: Any) -> None:
    session = running(desk, 1.0)
    session.change(key, value)
    for _ in range(5):
        session.advance(REST)
    assert not session.studies.busy and not desk.waiting("what if") and not desk.waiting("draft")


def test_nothing_is_asked_while_it_is_off_or_without_a_background(desk: Inline) -> None:
    for session in (Session(Settings(page=PageSettings(what_if=True))), Session(Settings(), background=desk)):
        session.advance(0.1)
        session.change("dm", 0.1)
        if session.settings.page.what_if:
            session.measure_smoothness()
        session.advance(1.0)
        studies = session.studies
        assert (
            session.what_if is None
            and studies.smoothness is None
            and not studies.busy
            and studies.message == ""
            and not desk.jobs
        )
    # Switching it on makes a process ready, and asks nothing yet.
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
        assert len(desk.waiting("draft")) == 1
    if stage == "answered":
        desk.work("draft")
        session.advance(REST)
    if stage == "answered":
        answered(desk, session)
    ENDS[end](session)
    session.advance(1.0)
    assert session.what_if is None and not session.studies.busy
    assert not desk.waiting("what if") and not desk.waiting("draft")


def test_moving_on_replaces_the_question_and_what_fails_is_named(desk: Inline) -> None:
    session = running(desk, 1.5)
    rest_at(desk, session, "k", 3.0)
    (old,) = desk.waiting("what if")
    rest_at(desk, session, "k", 4.0)
    (job,) = desk.waiting("what if")
    assert old.state == "dropped" and job is not old
    job.state, job.message = "failed", "The computation was ended from outside; ask for it again."
    session.advance(0.0)
    assert session.studies.message == job.message and not session.studies.busy
    rest_at(desk, session, "k", 5.0)
    assert answered(desk, session).settings.gain == 5.0 and session.studies.message == ""


def test_the_run_does_not_notice(desk: Inline) -> None:
    alone, asking = Session(Settings()), running(desk, 0.0)
    for i in range(30):
        for session in (alone, asking):
            session.change("dm", 0.1 + 0.001 * i)
            session.advance(0.11)
        desk.work()
    assert asking.what_if is not None
    assert asking.simulation.history.table().tobytes() == alone.simulation.history.table().tobytes()


def test_smoothness_of_the_law_and_of_the_ghost(desk: Inline) -> None:
    session = running(desk, 4.5, ghost="strict_switched")
    for _ in range(10):
        session.advance(0.1)
    session.measure_smoothness()
    assert session.studies.busy and session.studies.smoothness is not None and not session.studies.smoothness.finished
    assert len(desk.waiting("smoothness")) == 2 * len(SUBSTEPS)
    # The answers come one by one, in any order.
    for job in reversed(desk.waiting("smoothness")[:-2]):
        job.arguments = (job.arguments[0], job.arguments[1], 1)  # the coarsest is soon done
        job.result, job.state = 0.5, "done"
    session.advance(0.0)
    law, ghost = session.studies.smoothness.law, session.studies.smoothness.ghost
    assert ghost is not None and law.largest == (0.5, 0.5, 0.5, None) == ghost.largest
    assert law.verdict == "measuring" and law.settings == session.settings.run
    assert ghost.settings.law.law == "strict_switched"
    assert law.seconds <= SMOOTHNESS_WINDOW + CHAPTER and law.dts == (0.005, 0.0025, 0.00125, 0.000625)
    desk.work("smoothness")
    session.advance(0.0)
    assert session.studies.smoothness.finished and not session.studies.busy
    ghost = session.studies.smoothness.ghost
    # The smooth law's true step at dt/8 is far below 0.5; the hard switch of the ghost jumps.
    assert session.studies.smoothness.law.largest[3] is not None and session.studies.smoothness.law.largest[3] < 0.01
    assert ghost is not None and ghost.largest[3] is not None and ghost.largest[3] > 0.1 and ghost.verdict == "jump"


def test_smoothness_needs_something_to_measure_and_measuring_again_begins_again_and_reset_forgets(desk: Inline) -> None:
    session = running(desk, 0.1)
    session.measure_smoothness()
    assert session.studies.smoothness is None and "few seconds" in session.studies.message and not desk.waiting("smoothness")
    for _ in range(9):
        session.advance(0.1)
    session.measure_smoothness()
    first = desk.waiting("smoothness")
    session.measure_smoothness()
    assert all(job.state == "dropped" for job in first) and len(desk.waiting("smoothness")) == len(SUBSTEPS)
    (job, *_) = desk.waiting("smoothness")
    job.state, job.message = "failed", "The computation failed."
    session.advance(0.0)
    assert session.studies.smoothness is None and session.studies.message == job.message and not desk.waiting("smoothness")
    session.measure_smoothness()
    assert session.studies.message == ""
    session.reset()
    assert session.studies.smoothness is None and not session.studies.busy and not desk.waiting("smoothness")
