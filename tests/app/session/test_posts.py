"""Posted actions are done in order in the next frame, one value per control, within a budget."""

import ast
import logging
import math
from itertools import cycle, islice
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import app
from app.session.actions import (
    BUDGET,
    MOST_PRESSES,
    MOST_REBUILDS,
    PERIOD,
    Action,
    ActionQueue,
    Digit,
    Drag,
    Pause,
    SetSetting,
    SingleStep,
)
from app.session.session import Session
from app.settings import PageSettings, Settings
from tests.app.posted_call import post_call


def test_a_failed_post_does_not_stop_other_posts_or_the_clock(
    session: Session, caplog: pytest.LogCaptureFixture
) -> None:
    done: list[str] = []
    post_call(session, lambda: done.append("before"))
    session.post(SetSetting("dm", math.nan))
    post_call(session, lambda: done.append("after"))
    with caplog.at_level(logging.ERROR, "duet.session"):
        assert session.advance(0.05) == 10
    assert done == ["before", "after"] and len(caplog.records) == 1
    assert session.settings == Settings() and session.settings.page == PageSettings()


@pytest.fixture
def clock(session: Session) -> SimpleNamespace:
    clock = SimpleNamespace(now=100.0)
    session.posts = ActionQueue(session.handlers.do, lambda: clock.now)
    return clock


def test_repeated_steps_are_all_done_up_to_a_limit(session: Session) -> None:
    session.control.halt.set("visitor")
    for _ in range(5):
        session.post(SingleStep())
    assert session.advance(0.1) == 5
    for _ in range(MOST_PRESSES + 100):
        session.post(SingleStep())
    session.post(SetSetting("dm", 0.2))
    while session.advance(0.0):
        pass
    assert session.simulation.steps == 5 + MOST_PRESSES and session.settings.run.law.critical_distance == 0.2


@pytest.mark.parametrize(
    ("cost", "first"), [(0.4, [0, 10, 20, 31, 41, 51, 62]), (5.0, [0, 11, 22, 33, 44, 55, 66])]
)
def test_actions_beyond_the_budget_continue_in_the_next_frame(
    session: Session, clock: SimpleNamespace, cost: float, first: list[int]
) -> None:
    done: list[int] = []

    def slow(number: int) -> None:
        done.append(10 * number + session.simulation.steps)
        clock.now += cost * BUDGET

    for number in range(7):
        post_call(session, lambda number=number: slow(number))
    assert done == []
    assert [session.advance(0.005) for _ in range(7)] == [1] * 7 and done == first and not len(session.posts)


@pytest.mark.parametrize("rate", [30, 600])
def test_four_rebuilds_a_second_and_the_last_requested_one(
    session: Session, clock: SimpleNamespace, rate: int
) -> None:
    """Another scene in each request, for 3 s, at 32 frames per second."""
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
        session.post(SetSetting("scene", wish))
        session.post(SetSetting("dm", 0.2))
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
        *(
            ("scene", ("ball", "hold")),
            ("robot", ("ur5", "lwr")),
            ("rig", ("table", "torso")),
            ("lang", ("de", "sl")),
        ),
        *(("ghost", ("frozen", "off")), ("picture", ("fast", "fine")), ("theme", ("dark", "light"))),
        *(("guided", ("left", "right")), ("plot", ("curve", "none"))),
    ],
)
def test_every_kind_of_rebuild_counts(
    session: Session, clock: SimpleNamespace, key: str, choices: tuple[str, ...]
) -> None:
    done: list[str] = []
    for choice in islice(cycle(choices), 20):
        post_call(session, lambda choice=choice: (session.change(key, choice), done.append(choice))[0])
    for _ in range(10):
        session.advance(0.0)
    assert len(done) in (MOST_REBUILDS, MOST_REBUILDS + 1)  # The first may equal the present value.
    clock.now += PERIOD
    session.advance(0.0)
    assert len(done) > MOST_REBUILDS + 2


def test_changes_without_a_rebuild_are_not_delayed(session: Session, clock: SimpleNamespace) -> None:
    for i in range(20):
        post_call(session, lambda i=i: session.change("dm", 0.1 + 0.005 * i))
    session.advance(0.0)
    assert not len(session.posts) and session.settings.run.law.critical_distance == pytest.approx(0.195)


def test_waiting_actions_are_done_in_order_or_dropped() -> None:
    done: list[Action] = []
    queue = ActionQueue(done.append, lambda: 0.0)
    for action in (
        Pause(),
        SetSetting("dm", 0.15),
        SetSetting("scene", "hold"),
        SetSetting("dm", 0.2),
        Pause(),
    ):
        queue.put(action)
    queue.put(Digit(2))
    queue.put(drag := Drag("hand", "end", np.zeros(3)))
    queue.do()
    assert done == [Pause(), SetSetting("dm", 0.2), Pause(), Digit(2), drag] and not len(queue)
    queue.put(SetSetting("dm", 0.25))
    queue.do()
    assert done[5:] == [SetSetting("dm", 0.25)]
    queue.put(Pause())
    queue.drop()
    queue.do()
    assert len(done) == 6 and not len(queue)


def test_only_values_are_queued() -> None:
    """Product code posts instances or variables: no lambda, partial or method."""
    posted: list[ast.expr] = []
    for path in Path(app.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr in ("post", "put")
            ):
                posted += node.args
    assert len(posted) > 10
    assert not [
        ast.unparse(one) for one in posted if isinstance(one, ast.Lambda) or "partial(" in ast.unparse(one)
    ]


def test_an_action_without_a_handler_is_logged_and_skipped(
    session: Session, caplog: pytest.LogCaptureFixture
) -> None:
    class Unknown(Action):
        """An action that has no handler."""

    session.post(Unknown())
    with caplog.at_level(logging.ERROR, "duet.session"):
        session.advance(0.05)
    assert (
        len(caplog.records) == 1
        and "no handler of Unknown is registered" in caplog.text
        and session.simulation.steps
    )
