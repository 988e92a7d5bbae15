"""A teacher, the projector and a student in a real browser: clicker, reveal, black and frozen."""

import pytest
from playwright.sync_api import Page

from app.features.lecture.presenter import Station
from app.settings import Settings
from scenes.settings import changed
from tests.accessibility import accessible
from tests.app.conftest import Join, OpenHouse, ask
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.page.helpers import click
from tests.browser import PageAt, close_software_note, until


def fits(screen: Page) -> bool:
    """Whether nothing of what lies over the scene is cut off."""
    main = "document.querySelector('#duet-screen main')"
    return bool(screen.evaluate(f"{main}.scrollHeight <= {main}.clientHeight + 1"))


def strip(screen: Page) -> list[int]:
    """How many captions of plots, and plots, can be seen."""
    seen = "e => getComputedStyle(e).visibility === 'visible' && e.getClientRects().length > 0"
    every = (".duet-caption", ".uplot-container")
    return [
        int(screen.evaluate(f"[...document.querySelectorAll('{one}')].filter({seen}).length"))
        for one in every
    ]


def apart(screen: Page, beside: str) -> bool:
    """Whether the strip lies beside or below a part of what lies over the scene, and in the window."""
    box = "document.querySelector('{}').getBoundingClientRect().toJSON()"
    plot, text = (
        screen.evaluate(box.format(one)) for one in ("[data-duet-holds~=plots]", f"#duet-screen {beside}")
    )
    return (plot["left"] >= text["right"] or plot["top"] >= text["bottom"]) and plot[
        "bottom"
    ] <= screen.evaluate("innerHeight")


def bar_width(screen: Page, place: int) -> float:
    """Width of a bar of the histogram [CSS px]."""
    box = screen.locator("#duet-screen li > div > div").nth(place).bounding_box()
    return 0.0 if box is None else box["width"]


@pytest.mark.thorough
def test_a_projector_shows_what_the_clicker_asks_for(house: OpenHouse, page_at: PageAt, join: Join) -> None:
    opened = house(changed(Settings(), "picture", "fast"), lecture=True, key="chalk and talk")
    host = lecture_of(opened)
    presenter = host.control.presenter
    teacher = page_at(1000, 640)
    teacher.goto(f"{opened.url}/?key=chalk and talk&lesson=1&lang=en")
    teacher.locator(".duet-l-head").wait_for()
    close_software_note(teacher)
    teacher.get_by_role("tab", name="Join", exact=True).click()
    teacher.get_by_text("0 are in").wait_for()
    teacher.get_by_label("students expected").fill("60")
    teacher.get_by_text("0 of 60 are in").wait_for()
    teacher.get_by_role("tab", name="Screen", exact=True).click()
    dark = "document.documentElement.dataset.mantineColorScheme === 'dark'"
    assert not teacher.evaluate(dark)
    ask(host.session, lambda s: s.change("theme", "dark"))
    teacher.wait_for_function(dark)
    with teacher.context.expect_page() as coming:
        teacher.get_by_role("button", name="Open the screen").click()
    screen = coming.value
    over = screen.locator("#duet-screen")
    over.locator(".caption").wait_for()
    screen.wait_for_function(dark)
    # The window has the key, though neither its address nor the teacher's shows it, and does not pass for the teacher's tab.
    assert "chalk" not in screen.url and "screen=1" in screen.url
    tabs = {page.evaluate("sessionStorage.getItem('duetResume')") for page in (teacher, screen)}
    assert len(tabs) == 2 and host.classroom.here == ()
    teacher.get_by_text("screens: 1").wait_for()
    # The scene fills the window.
    canvas = "(() => { const box = __viserMutable.canvas.getBoundingClientRect(); return [box.width, box.height]; })()"
    # A window that has just opened may still get another size.
    until(
        screen,
        lambda: screen.evaluate(canvas) == screen.evaluate("[innerWidth, innerHeight]"),
        "the whole window",
    )
    assert not screen.get_by_text("Lesson", exact=True).is_visible()

    student = join(opened, f"resume={'2' * 32}")
    host.control.post("invite")
    screen.locator("#duet-overlay").get_by_text("1 of 60 are in").wait_for()
    screen.keyboard.press("PageDown")
    screen.locator("#duet-overlay section").wait_for(state="detached")
    screen.keyboard.press("PageDown")
    over.locator(".at-question").wait_for()
    over.get_by_text("0 of 1 answered").wait_for()
    size = "parseFloat(getComputedStyle(document.querySelector('#duet-screen .question.duet p')).fontSize)"
    until(screen, lambda: abs(screen.evaluate(size) - 40.0) < 0.1 and fits(screen), "large letters that fit")
    teacher.get_by_role("button", name="60 s").click()
    over.get_by_role("timer").wait_for()
    teacher.get_by_text("time left: ").wait_for()
    click(student, "3 ")
    over.get_by_text("1 of 1 answered").wait_for()
    assert all(bar_width(screen, i) == 0.0 for i in range(4))
    # The bars grow where they are, from nothing.
    screen.evaluate("window.kept = document.querySelector('#duet-screen li:nth-child(3) > div > div')")
    screen.keyboard.press("ArrowRight")
    over.locator(".at-answers").wait_for()
    until(screen, lambda: bar_width(screen, 2) > 300.0 and bar_width(screen, 0) == 0.0, "the answers")
    assert screen.evaluate("kept.isConnected")
    accessible(screen)
    until(teacher, lambda: teacher.get_by_role("button", name="Next: the run").count(), "what comes next")

    # Black, and with it the next key only brings the picture back; frozen, the teacher goes on unseen.
    black = screen.locator("#duet-black")
    for key, covered in (("b", True), (".", False), ("b", True)):
        screen.keyboard.press(key)
        black.wait_for(state="visible" if covered else "hidden")
    teacher.get_by_text("the screen is black").wait_for()
    # The small picture on the teacher's page is black too, and is no screen that counts.
    small = teacher.frame_locator(".duet-thumbnail iframe")
    small.locator("#duet-black").wait_for(state="visible")
    small.locator("#duet-screen .at-answers").wait_for(state="attached")
    assert teacher.get_by_text("screens: 1").count() == 1
    teacher.locator("body").click(position={"x": 500, "y": 30})
    teacher.keyboard.press("PageDown")
    black.wait_for(state="hidden")
    assert presenter.station is Station.ANSWERS
    teacher.get_by_role("button", name="Frozen").click()
    teacher.get_by_text("the screen is frozen").wait_for()
    before = over.inner_html()
    place = "JSON.stringify(Object.entries(__viserMutable.nodeRefFromName).map(([n, o]) => [n, o?.quaternion.toArray()]))"
    pose = screen.evaluate(place)
    teacher.get_by_role("button", name="Run", exact=True).click()
    until(teacher, lambda: host.session.simulation.time > 1.0, "the run")
    # Of nine seconds, of which none may be over before it has been seen on the projector.
    ask(host.session, lambda s: s.change("speed", 0.25))
    assert presenter.station is Station.RUN and over.inner_html() == before and screen.evaluate(place) == pose
    teacher.get_by_role("button", name="Live").click()
    over.locator(".at-run").wait_for()
    until(screen, lambda: screen.evaluate(place) != pose, "the run on the projector")
    # With the run the step's first plot stands as a strip beside the line of text, without the panel around it.
    until(screen, lambda: strip(screen) == [1, 1] and apart(screen, ".caption"), "one plot beside the text")

    # To the end of the run: the right answer is marked, not by its colour alone.
    screen.keyboard.press("PageDown")
    over.locator(".at-outcome li.right").wait_for()
    until(
        screen,
        lambda: strip(screen) == [1, 1] and apart(screen, "main") and fits(screen),
        "one plot below the outcome",
    )
    assert (
        screen.evaluate(
            "getComputedStyle(document.querySelector('#duet-screen li.right span'), '::after').content"
        )
        == '" ✓"'
    )
    # The moment that the class looks at has its name in the strip, not over the slide.
    root = "getComputedStyle(document.documentElement).getPropertyValue('--duet-moment-words')"
    until(screen, lambda: screen.evaluate(root), "the moment")
    assert screen.evaluate("getComputedStyle(document.body, '::after').content") == "none"
    # Of more than there is room for, letters become smaller only down to a limit; then the strip gives way.
    sent = "document.querySelector('.duet-screen main')"
    screen.evaluate(f"{sent}.append({sent}.querySelector('.duet-poll').cloneNode(true))")
    until(
        screen,
        lambda: over.locator(".duet-poll").count() == 2 and fits(screen) and strip(screen) == [0, 0],
        "no strip",
    )
    screen.evaluate(f"{sent}.lastElementChild.remove()")
    until(screen, lambda: strip(screen) == [1, 1] and fits(screen), "the strip again")
    screen.keyboard.press("PageUp")
    over.locator(".at-run").wait_for()

    # Leaving asks first.
    teacher.keyboard.press("x")
    teacher.get_by_role("button", name="Stay").click()
    teacher.get_by_role("button", name="Stay").wait_for(state="detached")
    assert host.lessons.open
    teacher.get_by_role("button", name="Leave the lessons").click()
    teacher.get_by_role("button", name="Leave with the class").click()
    until(teacher, lambda: not host.lessons.open, "out of the lessons")
