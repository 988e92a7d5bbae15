"""Fixtures of pages in a browser."""

from collections.abc import Iterator

import pytest

from tests.app.conftest import OpenHouse
from tests.app.page.shared_page import Shared, SharedPages
from tests.tabs import Tabs


@pytest.fixture(scope="module")
def shared_pages(lasting_house: OpenHouse, lasting_tabs: Tabs) -> SharedPages:
    return SharedPages(lasting_house, lasting_tabs)


@pytest.fixture
def shared(shared_pages: SharedPages, request: pytest.FixtureRequest) -> Iterator[Shared]:
    """Page of this file's `SHARED`, in its initial state; a new one after a failed test."""
    yield shared_pages.get(request.module.SHARED)
    if not shared_pages.tabs.judge(request.node):
        shared_pages.close(used=False)
    shared_pages.tabs.check()
