"""Browser tabs for one test, or for all tests of a file."""

import asyncio
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Error, Page

from tests.browser import FAILED, UNSEEN, WELCOMED, BrowserIn, PageAt, listen, save_picture
from tests.fonts import Font


@pytest.fixture(scope="session")
def used_tabs() -> list[Page]:
    """Used tabs for the next test: they show the page again in half the time."""
    return []


def _emptied(page: Page) -> bool:
    """Clear a tab's data. Returns True if it can be used again."""
    if page.is_closed() or len(page.context.pages) > 1:
        return False
    try:
        if page.url.startswith("http"):
            page.evaluate("() => { sessionStorage.clear(); localStorage.clear(); }")
        page.goto("about:blank")
        page.context.clear_cookies()
        page.mouse.up()
        page.mouse.move(0, 0)
    except Error:
        return False
    return True


def _close(context: BrowserContext) -> None:
    """Close a tab with its data. The test does not wait for a tab that does not answer."""
    with suppress(TimeoutError, Error):
        context._sync(asyncio.wait_for(context._impl_obj.close(reason=None), 30.0))


class Tabs:
    """Tabs opened by a test, or shared by a file's tests."""

    def __init__(self, browser_in: BrowserIn, used: list[Page]) -> None:
        self._browser_in, self._used = browser_in, used
        self._complaints: list[str] = []
        self._opened: list[tuple[Page, bool, Callable[[], None]]] = []

    def open(
        self,
        width: int = 800,
        height: int = 600,
        *,
        expect: Sequence[str] = (),
        newcomer: bool = False,
        fresh: bool = False,
        font: Font = "wide",
        **options: Any,
    ) -> Page:
        fresh = fresh or newcomer or bool(options) or font != "wide"
        if self._used and not fresh:
            page = self._used.pop()
            page.set_viewport_size({"width": width, "height": height})
        else:
            context = self._browser_in(font).new_context(
                viewport={"width": width, "height": height}, **options
            )
            context.add_init_script(UNSEEN)
            if not newcomer:
                context.add_init_script(WELCOMED)
            page = context.new_page()
        page.context.set_default_timeout(60_000)
        self._opened.append((page, fresh, listen(page, self._complaints, *expect)))
        return page

    def judge(self, test: pytest.Item) -> bool:
        """True if a test passed and no tab complained; otherwise save pictures of the tabs."""
        well = not (self._complaints or test.stash.get(FAILED, False))
        if not well:
            name = re.sub(r"[^\w.-]+", "_", test.nodeid)[-120:]
            # A tab may have opened more windows.
            windows = [window for page, _, _ in self._opened for window in page.context.pages]
            for index, window in enumerate(windows):
                try:
                    save_picture(window, f"{name}-{index}")
                except Error as error:
                    print(f"no picture of tab {index}: {error.message}")
        return well

    def close(self, used: bool) -> None:
        """Close the tabs. `used`: keep those that are not `fresh` for the next test."""
        for page, fresh, end in self._opened:
            if used and not fresh and _emptied(page):
                end()
                self._used.append(page)
            else:
                _close(page.context)
        self._opened.clear()

    def check(self) -> None:
        """Raise an AssertionError with the tabs' complaints since the last check."""
        complaints = self._complaints.copy()
        self._complaints.clear()
        assert not complaints, "the page complained:\n" + "\n".join(complaints)


@pytest.fixture
def page_at(
    browser: Browser, browser_in: BrowserIn, used_tabs: list[Page], request: pytest.FixtureRequest
) -> Iterator[PageAt]:
    """`page_at(width, height, expect=(…), font=…)` opens an empty tab of that size, by default with wide
    letters.

    A console error or an uncaught exception fails the test unless it matches a regular expression in
    `expect`. A newcomer sees the welcome, which appears once per browser. Used tabs are cleared; a test that
    adds scripts, routes, listeners or a protocol session needs a `fresh` tab. A failed test saves a picture
    of every tab in the artefact folder.
    """
    tabs = Tabs(browser_in, used_tabs)
    yield tabs.open
    tabs.close(used=tabs.judge(request.node))
    tabs.check()


@pytest.fixture(scope="module")
def lasting_tabs(browser: Browser, browser_in: BrowserIn, used_tabs: list[Page]) -> Iterator[Tabs]:
    """Tabs for all tests of a file."""
    tabs = Tabs(browser_in, used_tabs)
    yield tabs
    tabs.close(used=True)
    tabs.check()


@pytest.fixture(scope="module")
def lasting_page_at(lasting_tabs: Tabs) -> PageAt:
    """`page_at` for all tests of a file."""
    return lasting_tabs.open


@pytest.fixture(autouse=True)
def judge_lasting_tabs(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test with the complaints of its file's tabs during it, and save pictures of them."""
    tabs = request.getfixturevalue("lasting_tabs") if "lasting_tabs" in request.fixturenames else None
    yield
    if tabs is not None:
        tabs.judge(request.node)
        tabs.check()
