"""Lesson cases of the core's `test_replay.py`."""

from app.features.lessons.session.lesson_actions import Choose, GoTo, Press
from app.web.headless_client import HeadlessClient
from tests.app.conftest import Arrive, OpenHouse, visitor_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.helpers import shown


def says_so(visitor: HeadlessClient) -> bool:
    return "This is the past" in shown(visitor) and "the past: " in shown(visitor)


def test_a_lessons_next_step_ends_the_replay_and_waits_for_an_answer(
    house: OpenHouse, arrive: Arrive
) -> None:
    opened = house()
    guest = arrive(opened)
    stand = visitor_of(opened)
    guest.ask(lambda _: lessons_of(stand).enter(1))
    guest.ask(lambda _: lessons_of(stand).act(Choose(2)))
    guest.ask(lambda _: lessons_of(stand).act(Press("run")))
    guest.wait(lambda s: s.simulation.time > 0.3)
    guest.visitor.set_value("replay", "Watch")
    guest.visitor.wait_for(says_so)
    guest.ask(lambda _: lessons_of(stand).act(GoTo(1, 1)))
    guest.visitor.wait_for(lambda v: not says_so(v))
    assert guest.ask(
        lambda s: ("replay" in s.control.halt, s.paused, s.simulation.steps, lessons_of(stand).locked)
    ) == (
        False,
        True,
        0,
        True,
    )
