"""Finds the handler of an action by the action's type."""

from collections.abc import Callable
from typing import Any, TypeVar

from app.session.actions import Action

A = TypeVar("A", bound=Action)
Handler = Callable[[Any], object]


class ActionHandlers:
    """Table from the type of an action to its handler; a handler of a class also serves its subclasses.

    A type may have a second handler, such as Space in a replay: it is asked first and returns True if it did
    the action.
    The page of the operator covers the session's table with one of its own.
    """

    def __init__(self) -> None:
        self._handlers: dict[type[Action], Handler] = {}
        self._first: dict[type[Action], Handler] = {}
        self._page: ActionHandlers | None = None

    def add(self, kind: type[A], handler: Callable[[A], object]) -> None:
        """Raises ValueError if this table has a handler of this type."""
        _add(self._handlers, kind, handler)

    def add_first(self, kind: type[A], handler: Callable[[A], bool]) -> None:
        """Add a handler that is asked first and returns True if it did the action.

        Raises:
            ValueError: this table has such a handler of this type.
        """
        _add(self._first, kind, handler)

    def cover(self, page: "ActionHandlers") -> None:
        self._page = page

    def uncover(self, page: "ActionHandlers") -> None:
        """Remove the handlers of a page, unless another page has replaced them."""
        if self._page is page:
            self._page = None

    def of(self, kind: type[Action]) -> tuple[Handler, ...]:
        """One or two handlers in the order in which they are asked; () for an unknown type."""
        tables = (self,) if self._page is None else (self._page, self)
        handler = _find([table._handlers for table in tables], kind)
        if handler is None:
            return ()
        first = _find([table._first for table in tables], kind)
        return (handler,) if first is None else (first, handler)

    def do(self, action: Action) -> None:
        """Raises TypeError if the action's type has no handler."""
        handlers = self.of(type(action))
        if not handlers:
            raise TypeError(
                f"nothing here does {action!r}: no handler of {type(action).__name__} is registered"
            )
        *first, handler = handlers
        if not (first and first[0](action)):
            handler(action)


def _add(table: dict[type[Action], Handler], kind: type[Action], handler: Handler) -> None:
    if kind in table:
        raise ValueError(f"{kind.__name__} has a handler already: {table[kind]!r}")
    table[kind] = handler


def _find(tables: list[dict[type[Action], Handler]], kind: type[Action]) -> Handler | None:
    return next((table[base] for table in tables for base in kind.__mro__ if base in table), None)
