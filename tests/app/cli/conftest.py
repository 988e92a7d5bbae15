"""What the tests of commands share."""

from collections.abc import Iterator
from typing import Any

import pytest

from scenes import children


@pytest.fixture
def interrupted_after_two(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl+C comes once two of many computations are done."""
    computed = children.computed

    def interrupted(*arguments: Any) -> Iterator[tuple[int, Any]]:
        for done, found in enumerate(computed(*arguments)):
            if done == 2:
                raise KeyboardInterrupt
            yield found

    monkeypatch.setattr(children, "computed", interrupted)
