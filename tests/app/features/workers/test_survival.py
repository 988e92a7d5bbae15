"""Thirty visitors survive killed workers, renewals, lost connections and changing tabs; see `survival.py`."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

import pytest

from tests.app.features.workers.served import Serve
from tests.app.features.workers.survival import survive

pytestmark = pytest.mark.thorough


def test_thirty_visitors_lose_nothing(serve: Serve) -> None:
    served = serve("--workers", "2", "--sessions", "42")
    # In its own thread: this one may have the event loop of another test's browser.
    with ThreadPoolExecutor(1) as other:
        lost = other.submit(lambda: asyncio.run(survive(served, 30, 1.0, lines=4, visits=20))).result()
    assert lost == []
