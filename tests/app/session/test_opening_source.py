"""The opening of a default page: conditions, reset and restored sessions."""

import pytest

from app.session.session import Session
from app.session.session_state import go_on_from, state_of
from app.settings import Settings, asks_for_nothing, first_settings, from_query, to_query
from scenes.headless import run
from scenes.opening import Opening
from scenes.settings import RunSettings
from tests.app.conftest import Made, visitor_of
from tests.app.session.conftest import bits, go


@pytest.fixture
def opened(session: Session) -> Session:
    session.hand.source.opens = True
    return session


def test_a_session_begins_with_the_opening_only_if_the_page_opens(session: Session, opened: Session) -> None:
    go(opened, 2.0)
    assert opened.hand.source.opening
    assert bits(opened) != run(Settings().run, 2.0).table.tobytes()
    other = Session(Settings())
    other.advance(0.1, 60.0)
    assert not other.hand.source.opening


def test_a_reset_restarts_the_opening_and_its_inputs_are_recorded(opened: Session) -> None:
    go(opened, 1.0)
    first, recorded = bits(opened), opened.inputs.window()
    assert recorded is not None
    opened.reset()
    go(opened, 1.0)
    assert opened.hand.source.opening and bits(opened) == first
    opened.reset()
    # The recorded inputs give the same bits without the opening.
    for target in recorded.targets(opened.simulation):
        opened.simulation.step(target)
    assert bits(opened) == first


def test_the_opening_does_not_return_with_the_autopilot(opened: Session) -> None:
    go(opened, 1.0)
    opened.change("autopilot", False)
    opened.change("autopilot", True)
    go(opened, 0.1)
    assert not opened.hand.source.opening


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("seed", 3),
        ("rig", "table"),
        ("guided", "left"),
        ("task", "pose"),
        ("start", "between"),
        ("scene", "solo"),
    ],
)
def test_other_arms_tasks_and_seeds_begin_without_the_opening(
    opened: Session, key: str, value: object
) -> None:
    opened.change(key, value)
    opened.reset()
    go(opened, 0.5)
    assert not opened.hand.source.opening
    assert bits(opened) == run(opened.settings.run, 0.5).table.tobytes()


@pytest.mark.parametrize("seconds", [1.0, 25.0])
def test_a_session_continues_in_the_opening_to_the_same_bits(opened: Session, seconds: float) -> None:
    go(opened, seconds)
    state = state_of(opened)
    other = Session(opened.settings)
    list(go_on_from(other, state))
    for one in (opened, other):
        one.hand.source.opens = True
        for _ in range(10):
            one.advance(0.05, 60.0)
    assert other.hand.source.opening
    assert other.simulation.positions.tobytes() == opened.simulation.positions.tobytes()


@pytest.mark.parametrize(
    ("query", "usual"),
    [
        ({}, True),
        ({"theme": "dark", "lang": "de", "panel": "all", "utm_source": "mail", "resume": "0" * 16}, True),
        *(
            ({key: text}, False)
            for key, text in {"seed": "1", "dm": "0.15", "autopilot": "1", "whole": "1"}.items()
        ),
        *(
            ({key: text}, False)
            for key, text in {"lesson": "1", "push": "x", "attack": "x", "amp;seed": "3"}.items()
        ),
    ],
)
def test_a_link_with_a_request_does_not_open_the_default_page(query: dict[str, str], usual: bool) -> None:
    assert asks_for_nothing(query) is usual


@pytest.mark.parametrize("query", [{}, {"theme": "dark", "embed": "1"}])
def test_on_a_default_page_arms_glide_and_its_link_keeps_it(query: dict[str, str]) -> None:
    settings, problems = first_settings(query, Settings())
    assert settings.run == RunSettings(world=True) and not problems
    assert from_query(to_query(settings), Settings()) == (settings, ())


@pytest.mark.parametrize(
    "query", [{"whole": "1"}, {"seed": "1"}, {"world": "0"}, {"lesson": "1"}, {"push": "x"}, {"attack": "x"}]
)
def test_a_link_without_the_setting_opens_a_run_without_gliding(query: dict[str, str]) -> None:
    assert first_settings(query, Settings())[0].run == RunSettings()
    assert not first_settings({}, Settings(RunSettings(rig="table")))[0].run.world
    assert first_settings({}, Settings(), glides_as_usual=False)[0].run == RunSettings()
    assert first_settings({"world": "1"}, Settings(), glides_as_usual=False)[0].run.world


@pytest.mark.parametrize(
    ("link", "usual"), [("", True), ("theme=dark", True), ("autopilot=1&seed=3", False), ("seed=1", False)]
)
def test_a_page_begins_with_the_opening_unless_its_link_says_otherwise(
    by_hand: Made, link: str, usual: bool
) -> None:
    opened = by_hand(sessions=8)
    opened.let_in(link)
    session = visitor_of(opened).session
    for _ in range(4):
        opened.frame()
    assert session.simulation.steps and session.hand.source.opening is usual
    assert isinstance(session.hand.source._active, Opening) is usual


@pytest.mark.parametrize("glides", [True, False])
def test_a_server_option_sets_gliding_of_the_default_page(by_hand: Made, glides: bool) -> None:
    opened = by_hand(sessions=8, glides_as_usual=glides)
    opened.let_in("")
    assert visitor_of(opened).session.settings.run == RunSettings(world=glides)
