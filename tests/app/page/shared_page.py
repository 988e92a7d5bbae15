"""One browser page for all tests of a file: opening it takes longer than most of the tests."""

from collections.abc import Sequence
from dataclasses import dataclass

from playwright.sync_api import Page

from app.session.actions import FirstView, RestoreSettings
from app.session.session import Session
from app.settings import Settings
from app.start import App
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import visit
from tests.browser import until, wait_frames
from tests.tabs import Tabs


@dataclass(frozen=True)
class SharedPage:
    """Page shared by a file's tests: the constant `SHARED`; the tests use the fixture `shared`.

    Attributes:
        query: of the link.
        expect: regular expressions of permitted complaints in the console.
    """

    width: int
    height: int
    query: str = ""
    expect: Sequence[str] = ()


@dataclass(frozen=True)
class Shared:
    """An open page with its session. `begun`: the settings at the beginning of each test."""

    page: Page
    session: Session
    opened: App
    begun: Settings


class SharedPages:
    """The open page of a file, if any."""

    def __init__(self, house: OpenHouse, tabs: Tabs) -> None:
        self._house, self.tabs = house, tabs
        self._shared: Shared | None = None

    def get(self, wanted: SharedPage) -> Shared:
        if self._shared is None:
            page, opened = self.tabs.open(wanted.width, wanted.height, expect=wanted.expect), self._house()
            session = visit(page, opened, wanted.query)
            self._shared = Shared(page, session, opened, session.settings)
        else:
            restore(self._shared, wanted)
        return self._shared

    def close(self, used: bool) -> None:
        self._shared = None
        self.tabs.close(used)


def restore(shared: Shared, wanted: SharedPage) -> None:
    """Restore the initial settings, run, view, window and mouse; the open tab stays open."""
    page, session = shared.page, shared.session
    page.mouse.up()
    page.mouse.move(0, 0)
    page.set_viewport_size({"width": wanted.width, "height": wanted.height})
    page.evaluate("document.activeElement?.blur()")
    session.post(RestoreSettings(shared.begun))
    ask(session, lambda s: [s.control.halt.go_on(), s.reset()])
    session.post(FirstView())
    until(page, lambda: session.settings == shared.begun and not session.paused, "the page as it was")
    wait_frames(page)
