"""Finds the handler of an action by the action's type."""

from collections.abc import Callable
from typing import Any, TypeVar

from app.session.actions import Action

A = TypeVar("A", bound=Action)
Handler = Callable[[Any], object]


class ActionHandlers:
    """A table: type of an action → the handler that does it. A handler of a class is also the handler of its subclasses.

    A few types have a second meaning at times, such as Space in a replay. The handler of the second meaning goes first, and returns True
    if it has done the action.

    A session has one table for its lifetime. The page that operates the session fills a table of its own, which covers the session's:
    its handlers replace those of the same types.
    """

    def __init__(self) -> None:
        self._handlers: dict[type[Action], Handler] = {}
        self._first: dict[type[Action], Handler] = {}
        self._page: ActionHandlers | None = None

    def add(self, kind: type[A], handler: Callable[[A], object]) -> None:
        """Register the handler of a type of actions.

        Raises:
            ValueError: this table has a handler of this type.
        """
        _add(self._handlers, kind, handler)

    def add_first(self, kind: type[A], handler: Callable[[A], bool]) -> None:
        """Register a handler that is asked before the other one, and returns True if it has done the action.

        Raises:
            ValueError: this table has such a handler of this type.
        """
        _add(self._first, kind, handler)

    def cover(self, page: "ActionHandlers") -> None:
        """Put the handlers of a page over these, in place of those of the page before."""
        self._page = page

    def uncover(self, page: "ActionHandlers") -> None:
        """Remove the handlers of a page; nothing happens if another page has replaced them."""
        if self._page is page:
            self._page = None

    def of(self, kind: type[Action]) -> tuple[Handler, ...]:
        """Handlers of a type in the order in which they are asked, one or two; () for a type without a handler."""
        tables = (self,) if self._page is None else (self._page, self)
        handler = _find([table._handlers for table in tables], kind)
        if handler is None:
            return ()
        first = _find([table._first for table in tables], kind)
        return (handler,) if first is None else (first, handler)

    def do(self, action: Action) -> None:
        """Do an action by its handler.

        Raises:
            TypeError: the action's type has no handler.
        """
        handlers = self.of(type(action))
        if not handlers:
            raise TypeError(f"nothing here does {action!r}: no handler of {type(action).__name__} is registered")
        *first, handler = handlers
        if not (first and first[0](action)):
            handler(action)


def _add(table: dict[type[Action], Handler], kind: type[Action], handler: Handler) -> None:
    if kind in table:
        raise ValueError(f"{kind.__name__} has a handler already: {table[kind]!r}")
    table[kind] = handler


def _find(tables: list[dict[type[Action], Handler]], kind: type[Action]) -> Handler | None:
    """Handler in the first of the tables that has one of this type or of a class that it inherits from."""
    return next((table[base] for table in tables for base in kind.__mro__ if base in table), None)
