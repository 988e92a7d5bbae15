"""Thirty visitors live through killed workers, renewals, lost lines, and tabs that come and go; see `tests.tools.survival`."""

import asyncio

import pytest

from tests.app.served import Serve
from tests.tools.survival import survive

pytestmark = pytest.mark.thorough


def test_thirty_visitors_lose_nothing(serve: Serve) -> None:
    served = serve("--workers", "2", "--sessions", "42")
    assert asyncio.run(survive(served, 30, 1.0, lines=4, visits=20)) == []
