"""What the tests of commands share."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from scenes import children


def interrupted(compute: Callable[..., Iterator[Any]], after: int) -> Callable[..., Iterator[Any]]:
    """The same, but that Ctrl+C comes once so many of its computations are done."""

    def some(*arguments: Any) -> Iterator[Any]:
        for done, found in enumerate(compute(*arguments)):
            if done == after:
                raise KeyboardInterrupt
            yield found

    return some


@pytest.fixture
def interrupted_after_two(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(children, "computed", interrupted(children.computed, 2))
