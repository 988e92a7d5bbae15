"""An action is done by the handler of its type; a second handler may precede it."""

import pytest

from app.session.action_handlers import ActionHandlers
from app.session.actions import Action, Pause, Reset, SetSetting


class Draw(Action):
    """A base class of actions."""


class DrawLine(Draw):
    """A subclass of `Draw`."""


class Book:
    """Handler that records its actions. `takes`: its answer."""

    def __init__(self, name: str, done: list[str], takes: bool = True) -> None:
        self.name, self.done, self.takes = name, done, takes

    def __call__(self, action: Action) -> bool:
        self.done.append(f"{self.name}: {type(action).__name__}")
        return self.takes


def test_an_action_reaches_the_handler_of_its_type_and_no_other() -> None:
    handlers, done = ActionHandlers(), list[str]()
    handlers.add(Pause, Book("pause", done))
    handlers.add(Reset, Book("reset", done))
    handlers.do(Pause())
    assert done == ["pause: Pause"]


def test_a_first_handler_precedes_and_reports_if_it_did_the_action() -> None:
    handlers, done = ActionHandlers(), list[str]()
    replay = Book("replay", done)
    handlers.add(Pause, Book("run", done, takes=False))
    handlers.add_first(Pause, replay)
    handlers.do(Pause())
    replay.takes = False
    handlers.do(Pause())
    assert done == ["replay: Pause", "replay: Pause", "run: Pause"]
    assert [one.name for one in handlers.of(Pause) if isinstance(one, Book)] == ["replay", "run"]


def test_a_handler_of_a_class_also_handles_subclasses() -> None:
    handlers, done = ActionHandlers(), list[str]()
    handlers.add(Draw, Book("any", done))
    handlers.do(DrawLine())
    handlers.add(DrawLine, Book("line", done))
    handlers.do(DrawLine())
    handlers.do(Draw())
    assert done == ["any: DrawLine", "line: DrawLine", "any: Draw"]


@pytest.mark.parametrize("first", [False, True])
def test_an_action_without_a_handler_is_an_error_that_names_it(first: bool) -> None:
    handlers = ActionHandlers()
    if first:
        # `add_first` alone does not count as a handler.
        handlers.add_first(SetSetting, lambda action: False)
    assert handlers.of(SetSetting) == ()
    with pytest.raises(TypeError, match=r"SetSetting\(key='dm', value=0.2\): no handler of SetSetting"):
        handlers.do(SetSetting("dm", 0.2))


def test_two_handlers_of_one_type_in_one_table_are_refused() -> None:
    handlers = ActionHandlers()
    for add in (handlers.add, handlers.add_first):
        add(Pause, lambda action: False)
        with pytest.raises(ValueError, match="Pause has a handler already"):
            add(Pause, lambda action: False)


def test_a_pages_handlers_precede_the_sessions_until_it_closes() -> None:
    handlers, page, done = ActionHandlers(), ActionHandlers(), list[str]()
    handlers.add_first(Pause, Book("replay", done, takes=False))
    handlers.add(Pause, Book("run", done))
    page.add(Pause, Book("lesson", done))
    page.add(Reset, Book("page", done))
    handlers.cover(page)
    handlers.do(Pause())
    handlers.do(Reset())
    assert done == ["replay: Pause", "lesson: Pause", "page: Reset"]
    handlers.uncover(page)
    handlers.do(Pause())
    assert done[3:] == ["replay: Pause", "run: Pause"] and handlers.of(Reset) == ()


def test_a_new_page_replaces_the_old_one_which_may_close_later() -> None:
    handlers, old, new, done = ActionHandlers(), ActionHandlers(), ActionHandlers(), list[str]()
    old.add(Pause, Book("old", done))
    old.add(SetSetting, Book("old", done))
    new.add(Pause, Book("new", done))
    handlers.cover(old)
    handlers.cover(new)
    assert handlers.of(SetSetting) == ()
    handlers.uncover(old)
    handlers.do(Pause())
    assert done == ["new: Pause"]
    handlers.uncover(new)
    assert handlers.of(Pause) == ()
