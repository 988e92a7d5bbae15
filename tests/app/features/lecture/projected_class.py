"""A teacher's page, the projector window opened from it, and one student, shared by the tests of a file."""

from itertools import pairwise

from playwright.sync_api import Locator, Page

from app.features.classroom.ballots import Ballots
from app.features.lecture.presenter import Station
from app.features.lessons.session.lesson_actions import GoTo, Press
from app.session.session import Session
from app.start import App
from tests.app.conftest import ask
from tests.app.features.lecture.lecture_room import lecture_of, tab_of
from tests.app.page.helpers import click
from tests.blocking_client import BlockingClient
from tests.browser import close_software_note, until
from tests.tabs import Tabs

DARK = "document.documentElement.dataset.mantineColorScheme === 'dark'"

POSES = "JSON.stringify(Object.entries(__viserMutable.nodeRefFromName).map(([n, o]) => [n, o?.quaternion.toArray()]))"
"""Script: orientation of each node of the scene."""

SLOW = 0.25
"""Speed of the runs: at this speed a run of 9 s is still visible when the projector is checked."""

KEY = "chalk and talk"


class ProjectedClass:
    """A teacher with dark colours and an open projector window; the student has no browser."""

    def __init__(self, opened: App, tabs: Tabs) -> None:
        self.host = lecture_of(opened)
        self.teacher = tabs.open(1000, 640)
        self.teacher.goto(f"{opened.url}/?key={KEY}&lesson=1&lang=en")
        self.teacher.locator(".duet-l-head").wait_for()
        close_software_note(self.teacher)
        self.teacher.get_by_role("tab", name="Screen", exact=True).click()
        assert not self.teacher.evaluate(DARK)
        ask(self.host.session, lambda s: s.change("theme", "dark"))
        self.teacher.wait_for_function(DARK)
        with self.teacher.context.expect_page() as coming:
            self.teacher.get_by_role("button", name="Open the screen").click()
        self.screen = coming.value
        self.over.locator(".caption").wait_for()
        self.tabs_before_the_student = self.host.classroom.here
        self.student = BlockingClient(opened.url, query=f"resume={tab_of('ann')}")

    @property
    def over(self) -> Locator:
        """Overlay of the projector's scene."""
        return self.screen.locator("#duet-screen")

    @property
    def black(self) -> Locator:
        return self.screen.locator("#duet-black")

    @property
    def station(self) -> Station:
        return self.host.control.presenter.station

    def begin(self) -> None:
        """Return to the first question without an answer, with the scene on the projector."""
        host, presenter = self.host, self.host.control.presenter

        def start_again(session: Session) -> None:
            host.classroom.ballots = Ballots()
            host.lessons.enter("redundancy")
            for action in (GoTo(1, 0), Press("reset")):
                host.lessons.act(action)
            presenter.uncover()
            presenter.start_timer(0)
            presenter.expected = 0
            session.change("speed", SLOW)

        def shows_the_scene() -> bool:
            ask(host.session, lambda _: presenter.show(Station.SCENE))
            return self.over.locator(".at-scene").is_visible() and self.over.locator("footer").count() == 0

        ask(host.session, start_again)
        until(self.screen, shows_the_scene, "the scene")
        self.teacher.get_by_role("tab", name="Screen", exact=True).click()

    def answer(self) -> None:
        """Send the student's answer 3, which is right."""
        click(self.student, "3 ")

    def show(self, station: Station) -> None:
        """Press Page ↓ on the projector until it shows this station of the first step."""
        order = tuple(Station)
        for before, after in pairwise(order[: order.index(station) + 1]):
            if before is Station.QUESTION:
                self.answer()
                self.over.get_by_text("1 of 1 answered").wait_for()
            self.screen.keyboard.press("PageDown")
            self.over.locator(f".at-{after}").wait_for()

    def close(self) -> None:
        self.student.close()


def fits(screen: Page) -> bool:
    """True if no part of the overlay is cut off."""
    main = "document.querySelector('#duet-screen main')"
    return bool(screen.evaluate(f"{main}.scrollHeight <= {main}.clientHeight + 1"))


def strip(screen: Page) -> list[int]:
    """Numbers of visible plot captions and of visible plots."""
    seen = "e => getComputedStyle(e).visibility === 'visible' && e.getClientRects().length > 0"
    every = (".duet-caption", ".uplot-container")
    return [
        int(screen.evaluate(f"[...document.querySelectorAll('{one}')].filter({seen}).length"))
        for one in every
    ]


def apart(screen: Page, beside: str) -> bool:
    """True if the strip with the plot is beside or below this part of the overlay, and inside the window."""
    box = "document.querySelector('{}').getBoundingClientRect().toJSON()"
    plot, text = (
        screen.evaluate(box.format(one)) for one in ("[data-duet-holds~=plots]", f"#duet-screen {beside}")
    )
    return (plot["left"] >= text["right"] or plot["top"] >= text["bottom"]) and plot[
        "bottom"
    ] <= screen.evaluate("innerHeight")


def bar_width(screen: Page, place: int) -> float:
    """Width of a histogram bar [CSS px]."""
    box = screen.locator("#duet-screen li > div > div").nth(place).bounding_box()
    return 0.0 if box is None else box["width"]
