"""The opening of a page with its usual settings: what is moved by it, what is not, and how a session goes on in it."""

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


def test_a_session_begins_with_it_only_if_the_page_is_to(session: Session, opened: Session) -> None:
    go(opened, 2.0)
    assert opened.hand.source.opening
    assert bits(opened) != run(Settings().run, 2.0).table.tobytes()
    other = Session(Settings())
    other.advance(0.1, 60.0)
    assert not other.hand.source.opening


def test_a_reset_begins_it_again_and_its_inputs_are_recorded(opened: Session) -> None:
    go(opened, 1.0)
    first, recorded = bits(opened), opened.inputs.window()
    assert recorded is not None
    opened.reset()
    go(opened, 1.0)
    assert opened.hand.source.opening and bits(opened) == first
    opened.reset()
    # The recorded inputs lead to the same bits without it.
    for target in recorded.targets(opened.simulation):
        opened.simulation.step(target)
    assert bits(opened) == first


def test_who_lets_the_autopilot_go_on_later_does_not_see_it_again(opened: Session) -> None:
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
def test_other_arms_tasks_and_seeds_begin_without_it(opened: Session, key: str, value: object) -> None:
    opened.change(key, value)
    opened.reset()
    go(opened, 0.5)
    assert not opened.hand.source.opening
    assert bits(opened) == run(opened.settings.run, 0.5).table.tobytes()


@pytest.mark.parametrize("seconds", [1.0, 25.0])
def test_a_session_goes_on_in_it_to_the_same_bits(opened: Session, seconds: float) -> None:
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
def test_a_link_that_asks_for_something_is_another_page(query: dict[str, str], usual: bool) -> None:
    assert asks_for_nothing(query) is usual


@pytest.mark.parametrize("query", [{}, {"theme": "dark", "embed": "1"}])
def test_on_a_usual_page_arms_glide_along_things_and_its_link_says_so(query: dict[str, str]) -> None:
    settings, problems = first_settings(query, Settings())
    assert settings.run == RunSettings(world=True) and not problems
    assert from_query(to_query(settings), Settings()) == (settings, ())


@pytest.mark.parametrize(
    "query", [{"whole": "1"}, {"seed": "1"}, {"world": "0"}, {"lesson": "1"}, {"push": "x"}, {"attack": "x"}]
)
def test_a_link_that_does_not_name_it_replays_without(query: dict[str, str]) -> None:
    assert first_settings(query, Settings())[0].run == RunSettings()
    assert not first_settings({}, Settings(RunSettings(rig="table")))[0].run.world


@pytest.mark.parametrize(
    ("link", "usual"), [("", True), ("theme=dark", True), ("autopilot=1&seed=3", False), ("seed=1", False)]
)
def test_the_page_begins_with_it_unless_its_link_says_otherwise(
    by_hand: Made, link: str, usual: bool
) -> None:
    opened = by_hand(sessions=8)
    opened.let_in(link)
    session = visitor_of(opened).session
    for _ in range(4):
        opened.frame()
    assert session.simulation.steps and session.hand.source.opening is usual
    assert isinstance(session.hand.source._active, Opening) is usual
