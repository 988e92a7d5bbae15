"""Handlers of actions."""

from collections.abc import Callable
from typing import Any, TypeVar

from app.session.actions import Action

A = TypeVar("A", bound=Action)
Handler = Callable[[Any], object]


class ActionHandlers:
    """Type of an action → handler, also of subclasses. A second handler, such as Space in a replay, is
    asked first and returns True if it did the action. The operator's page covers the session's table."""

    def __init__(self) -> None:
        self._handlers: dict[type[Action], Handler] = {}
        self._first: dict[type[Action], Handler] = {}
        self._page: ActionHandlers | None = None

    def add(self, kind: type[A], handler: Callable[[A], object]) -> None:
        """Raises ValueError if the type has a handler."""
        _add(self._handlers, kind, handler)

    def add_first(self, kind: type[A], handler: Callable[[A], bool]) -> None:
        """Raises ValueError if the type has a first handler."""
        _add(self._first, kind, handler)

    def cover(self, page: "ActionHandlers") -> None:
        self._page = page

    def uncover(self, page: "ActionHandlers") -> None:
        """Keeps the handlers of a newer page."""
        if self._page is page:
            self._page = None

    def of(self, kind: type[Action]) -> tuple[Handler, ...]:
        """One or two handlers, the first to ask first; () for an unknown type."""
        tables = (self,) if self._page is None else (self._page, self)
        handler = _find([table._handlers for table in tables], kind)
        if handler is None:
            return ()
        first = _find([table._first for table in tables], kind)
        return (handler,) if first is None else (first, handler)

    def do(self, action: Action) -> None:
        """Raises TypeError for an unknown type."""
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
