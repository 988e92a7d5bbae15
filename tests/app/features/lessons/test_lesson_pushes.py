"""The duel, without a page: of five pushes the nearest is kept, with its link."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.features.lessons.panel.lesson_html import attempt_html, duel_html
from app.features.lessons.progress import Try
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.history import COLUMN
from scenes.rerun import rerun
from scenes.run_text import run_of_text, run_text
from scenes.targets import HandTarget
from tests.app.features.lessons.student import BOOK, Student, duel, push

pytestmark = pytest.mark.usefixtures("fast_machine")


def tries(one: Student) -> int:
    return len(one.run.walk.done.tries)


def said(one: Student) -> str:
    return attempt_html(one.run.walk.view()).replace("\u00a0", " ")


def test_outside_a_duel_a_held_place_is_not_rounded() -> None:
    session = Student(BOOK.index("hold"), 2).session
    session.hand.hold(HandTarget(place := np.array([0.4, 0.01, 1.2]), None))
    assert session.held is not None and session.held[0] is place


def test_a_run_without_a_push_does_not_count_and_restarts() -> None:
    one = duel()
    session, run = one.session, one.run
    run.act(do.Press("check"))
    assert session.notices.pop()[0] == "Push first" and not tries(one) and run.walk.nearest is None
    before = run.walk.run_watch.run
    one.frames_until(lambda: run.walk.run_watch.run > before, 1.0)
    assert not run.over and not session.paused and not tries(one)


SPEEDS = (0.15, 0.25, 0.2, 0.1, 0.15, 0.4)
"""Speeds of six pushes; the last push does not count [m/s]."""


def test_five_pushes_count_once_and_the_link_has_the_exact_nearest_one() -> None:
    one = duel()
    session, run = one.session, one.run
    tables: list[np.ndarray] = []
    for number, fast in enumerate(SPEEDS, 1):
        push(one, fast)
        assert run.over and session.paused and tries(one) == min(number, 5)
        tables.append(session.simulation.history.table())
        run.act(do.Press("check"))
        assert tries(one) == min(number, 5), "the same push counts only once"
        run.act(do.Press("run"))
        assert not run.over and session.simulation.steps == 0 and session.settings.run.hand_speed == fast
    done, nearest, table = run.walk.done.tries, run.walk.nearest, tables[1]
    assert [each.setting for each in done] == list(SPEEDS[:5])
    assert min(done, key=lambda each: each.measured) is done[1]
    sixth, least_distance = (float(each[:, COLUMN["d"]].min()) for each in (tables[5], table))
    assert nearest is not None and sixth < least_distance, "the sixth push is nearer but does not count"
    assert_array_equal(rerun(run_of_text(run_text(nearest))).table, table)
    margin = least_distance - 0.15
    assert done[1].measured == margin
    assert f"You came to {1000 * margin:.1f} mm above dₘ." in said(one)
    assert said(one).count("mm above dₘ") == 6


def test_a_push_below_d_m_is_reported() -> None:
    view = replace(duel().run.walk.view(), tries=(Try(0.4, -0.0032, True),))
    assert "broke through by 3.2\u00a0mm" in duel_html(view)


def test_pushes_survive_a_reload_and_a_reset_allows_five_new_ones() -> None:
    one = duel()
    run = one.run
    for fast in (0.15, 0.25):
        push(one, fast)
    saved, nearest = run.saved_lesson(), run.walk.nearest
    assert saved is not None and nearest is not None
    other = LessonSession(Session(Settings()), BOOK)
    other.resume(saved, reopen=True)
    assert other.walk.done.tries == run.walk.done.tries and other.walk.nearest is nearest
    run.act(do.Press("reset"))
    assert not tries(one) and run.walk.nearest is None
    one.to_challenge()
    push(one, 0.1)
    assert tries(one) == 1 and run.walk.nearest is not nearest


def test_a_push_with_changed_settings_or_a_smaller_v_does_not_count() -> None:
    one = duel()
    session, run = one.session, one.run
    push(one, 0.1)
    push(one, 0.1, 0.2)
    assert tries(one) == 1 and "Push 1 of 5" in said(one) and "Press Next push." in said(one)
    # A duel shows its pushes, not its attempts.
    assert run.walk.done.attempts == 2 and "Attempt" not in said(one) and "Reset, then" not in said(one)
    session.change("v", 0.1)
    push(one, 0.25)
    assert tries(one) == 1 and run.over


def test_a_push_ends_after_10_s() -> None:
    one = duel()
    session, run = one.session, one.run
    run.act(do.Press("again"))
    session.hand.hold(HandTarget(np.array([0.3, 0.0, 1.3]), None))
    one.frames_until(lambda: run.over)
    assert tries(one) == 1 and session.simulation.time == pytest.approx(10.0, abs=0.1)
