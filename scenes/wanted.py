"""Computations that can be stopped: `until` sets the condition, `check_wanted` tests it."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final, TypeVar

T = TypeVar("T")

_STOPPED: Final[ContextVar[Callable[[], bool]]] = ContextVar("duet_stopped", default=lambda: False)


class Stopped(Exception):
    """The result is no longer wanted."""


@contextmanager
def until(stopped: Callable[[], bool]) -> Iterator[None]:
    """While open, `check_wanted` in this thread raises `Stopped` as soon as `stopped()` is true."""
    token = _STOPPED.set(stopped)
    try:
        yield
    finally:
        _STOPPED.reset(token)


def check_wanted() -> None:
    if _STOPPED.get()():
        raise Stopped


def while_wanted(items: Iterable[T], every: int = 1) -> Iterator[T]:
    for number, item in enumerate(items):
        if number % every == 0:
            check_wanted()
        yield item
