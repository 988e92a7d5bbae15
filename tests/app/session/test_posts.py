"""What is posted to a session is done in order at the beginning of the next frame: one value a control, within a budget."""

import logging
import math
from itertools import cycle, islice
from types import SimpleNamespace

import pytest

from app.session.action_queue import BUDGET, MOST_PRESSES, MOST_REBUILDS, PERIOD, ActionQueue
from app.session.session import Session
from app.settings import PageSettings, Settings


def test_posts_are_done_in_order_at_the_beginning_of_the_next_frame(session: Session) -> None:
    done: list[int] = []
    for number in range(3):
        session.post(lambda number=number: done.append(10 * number + session.simulation.steps))
    assert done == []
    session.advance(0.05)
    assert done == [0, 10, 20]


def test_a_post_that_fails_stops_neither_the_others_nor_the_clock(session: Session, caplog: pytest.LogCaptureFixture) -> None:
    done: list[str] = []
    session.post(lambda: done.append("before"))
    session.post(lambda: session.change("dm", math.nan))
    session.post(lambda: done.append("after"))
    with caplog.at_level(logging.ERROR, "duet.session"):
        assert session.advance(0.05) == 10
    assert done == ["before", "after"] and len(caplog.records) == 1
    assert session.settings == Settings() and session.settings.page == PageSettings()


@pytest.fixture
def clock(session: Session) -> SimpleNamespace:
    clock = SimpleNamespace(now=100.0)
    session.posts = ActionQueue(lambda: clock.now)
    return clock


def test_the_newest_value_of_a_control_wins_and_the_order_of_different_ones_is_kept(session: Session) -> None:
    done: list[str] = []
    for control, value in (("dm", 1), ("n", 1), ("dm", 2), ("v", 1), ("n", 2)):
        session.post(lambda control=control, value=value: done.append(f"{control}={value}"), control)
    session.advance(0.0)
    assert done == ["dm=2", "v=1", "n=2"]
    session.post(lambda: done.append("dm=3"), "dm")
    session.advance(0.0)
    assert done[3:] == ["dm=3"]


def test_what_counts_every_time_is_done_every_time_but_not_without_end(session: Session) -> None:
    session.halt.set("visitor")
    for _ in range(5):
        session.post(session.single_step)
    assert session.advance(0.1) == 5
    for _ in range(MOST_PRESSES + 100):
        session.post(session.single_step)
    session.post(lambda: session.change("dm", 0.2), "dm")
    while session.advance(0.0):
        pass
    assert session.simulation.steps == 5 + MOST_PRESSES and session.settings.run.law.critical_distance == 0.2


@pytest.mark.parametrize(("cost", "first"), [(0.4, [0, 10, 20, 31, 41, 51, 62]), (5.0, [0, 11, 22, 33, 44, 55, 66])])
def test_actions_go_on_in_the_next_frame(session: Session, clock: SimpleNamespace, cost: float, first: list[int]) -> None:
    done: list[int] = []

    def slow(number: int) -> None:
        done.append(10 * number + session.simulation.steps)
        clock.now += cost * BUDGET

    for number in range(7):
        session.post(lambda number=number: slow(number))
    assert [session.advance(0.005) for _ in range(7)] == [1] * 7 and done == first and not len(session.posts)


@pytest.mark.parametrize("rate", [30, 600])
def test_four_rebuilds_a_second_and_the_last_one_asked_for(session: Session, clock: SimpleNamespace, rate: int) -> None:
    """Another scene at every wish, for three seconds, at 32 frames a second."""
    wishes = islice(cycle(("ball", "solo", "hold", "master_slave")), 3 * rate - 2)
    built: list[float] = []
    frame, asked = 1.0 / 32.0, 0.0

    def advance() -> None:
        room = session.simulation.world
        session.advance(0.0)
        if session.simulation.world is not room:
            built.append(clock.now)
        clock.now += frame

    last = ""
    for wish in wishes:
        session.post(lambda wish=wish: session.change("scene", wish), "scene")
        session.post(lambda: session.change("dm", 0.2), "dm")
        asked, last = asked + 1.0 / rate, wish
        while asked >= frame:
            asked -= frame
            advance()
    for _ in range(40):
        advance()
    assert session.settings.run.scene == last and session.settings.run.law.critical_distance == 0.2
    assert 2 * MOST_REBUILDS < len(built) <= 4 * MOST_REBUILDS + 1
    assert all(b - a >= PERIOD for a, b in zip(built, built[MOST_REBUILDS:], strict=False))


@pytest.mark.parametrize(
    ("key", "choices"),
    [
        *(("scene", ("ball", "hold")), ("robot", ("ur5", "lwr")), ("rig", ("table", "torso")), ("lang", ("de", "sl"))),
        *(("ghost", ("frozen", "off")), ("picture", ("fast", "fine")), ("theme", ("dark", "light"))),
        *(("guided", ("left", "right")), ("plot", ("curve", "none"))),
    ],
)
def test_whatever_is_built_again_counts(session: Session, clock: SimpleNamespace, key: str, choices: tuple[str, ...]) -> None:
    done: list[str] = []
    for choice in islice(cycle(choices), 20):
        session.post(lambda choice=choice: (session.change(key, choice), done.append(choice))[0])
    for _ in range(10):
        session.advance(0.0)
    assert len(done) in (MOST_REBUILDS, MOST_REBUILDS + 1)  # The first may be what there is already.
    clock.now += PERIOD
    session.advance(0.0)
    assert len(done) > MOST_REBUILDS + 2


def test_what_builds_nothing_is_not_held_back(session: Session, clock: SimpleNamespace) -> None:
    for i in range(20):
        session.post(lambda i=i: session.change("dm", 0.1 + 0.005 * i))
    session.advance(0.0)
    assert not len(session.posts) and session.settings.run.law.critical_distance == pytest.approx(0.195)


def test_what_waits_can_be_dropped(session: Session) -> None:
    session.post(lambda: session.change("dm", 0.2), "dm")
    session.post(session.reset)
    session.posts.drop()
    session.advance(0.0)
    assert session.settings == Settings() and not len(session.posts)
