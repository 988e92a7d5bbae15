"""Restored settings, saved entries and the list of lessons, without a page."""

from app.features.lessons.bookmark import Phase
from app.features.lessons.panel.lesson_html import learned_html
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.roles import NO_TARGETS
from scenes.settings import changed, values
from tests.app.features.lessons.student import BOOK, Student


def test_leaving_restores_the_visitors_settings() -> None:
    before = changed(changed(Settings(), "dm", 0.11), "autopilot", False)
    one = Student(settings=before)
    session, run = one.session, one.run
    for lesson in range(len(BOOK.lessons)):
        run.enter(lesson)
        one.frame()
        assert values(session.settings)["scene"] == BOOK.lessons[lesson].steps[0].setup.run.scene
    session.change("theme", "dark")
    run.act(do.Press("leave"))
    assert session.settings == changed(before, "theme", "dark") and not session.paused and not run.open
    assert session.target() is None


def test_a_reset_restarts_the_step_and_a_new_experiment_restarts_the_run() -> None:
    one = Student()
    session, run = one.session, one.run
    fresh = run.walk.to_json(), values(session.settings)
    run.act(do.Choose(2))
    session.change("k", 9.0)
    run.act(do.Press("reset"))
    assert (run.walk.to_json(), values(session.settings)) == fresh
    run.act(do.Press("back"))
    assert run.walk.phase is Phase.PREDICT
    run.act(do.Choose(2))
    session.change("scene", "hold")
    run.decide()
    assert session.settings.run.scene == "solo" and session.notices
    session.change("autopilot", False)
    run.decide()
    assert session.settings.page.autopilot


def test_changed_settings_pushes_and_typed_numbers_are_restored() -> None:
    one = Student(2, 2)
    session, run = one.session, one.run
    one.to_challenge()
    session.change("v", 0.17)
    run.said.extend([0.25, None, 0.5])
    run.walk.kept["push"] = NO_TARGETS
    saved = run.saved_lesson()
    assert saved is not None
    other = Session(Settings())
    again = LessonSession(other, BOOK)
    again.resume(saved, reopen=True)
    assert other.settings.run == session.settings.run and other.settings.run.law.nominal_velocity == 0.17
    assert again.said == [0.25, None, 0.5] and dict(again.walk.kept) == dict(run.walk.kept)
    again.act(do.Press("leave"))
    assert other.settings == Settings()
    again.enter(2, 2)
    again.act(do.Press("reset"))
    assert again.said == []


def test_the_list_opens_lessons_and_marks_finished_steps() -> None:
    session = Session(Settings())
    run = LessonSession(session, BOOK)
    run.act(do.Press("list"))
    assert run.listing and not run.open
    assert not any(entry.here or any(entry.finished) or entry.step for entry in run.walk.entries())
    run.act(do.Press("list"))
    assert not run.listing
    run.act(do.GoTo(1, 0))
    assert not run.open, "a lesson opens only from the list"
    run.act(do.Press("list"))
    run.act(do.GoTo(1, 0))
    assert run.open and not run.listing and run.walk.lesson is BOOK.lessons[1]

    student = Student(1)
    run = student.run
    run.act(do.Choose(0))
    student.finish()
    run.act(do.Press("next"))
    run.act(do.GoTo(1, 1))
    entry = tuple(run.walk.entries())[1]
    assert entry.here and entry.finished == (True, False, False) and entry.step == 1
    assert [one.here for one in run.walk.entries()].count(True) == 1
    run.act(do.GoTo(0, 0))
    # In a lesson that the student has left, the first unfinished step is next.
    assert tuple(run.walk.entries())[1].step == 1 and not tuple(run.walk.entries())[1].here


def test_a_finished_lesson_shows_its_summary() -> None:
    student = Student(2, 2)
    run = student.run
    assert not run.walk.view().lesson_finished
    student.to_challenge()
    assert not run.walk.view().lesson_finished, "an open challenge does not finish the lesson"
    run.walk.done.passed = True
    view = run.walk.view()
    assert view.lesson_finished and BOOK.lessons[2].learned and "q" in learned_html(view)
    run.act(do.GoTo(2, 0))
    assert not run.walk.view().lesson_finished and learned_html(run.walk.view()) == ""
