"""A page that loads over a slow line, its first notes, and the welcome card (once per browser)."""

import pytest
from playwright.sync_api import Locator, Page

from app.i18n.catalogue import words_of
from app.settings import Language, Settings
from scenes.settings import changed
from tests.accessibility import accessible
from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import FREE, WRIST, grab, visit
from tests.browser import PageAt, screenshot, settled_view, until, wait_frames, wait_ready

SEEN = """(() => {
  const seen = window.seenSoFar = new Set();
  const there = e => e && e.checkVisibility({ visibilityProperty: true, opacityProperty: true });
  const shown = e => { for (let p = e; p && p.id !== 'root'; p = p.parentElement) if (!p.offsetHeight) return false; return there(e); };
  const look = () => {
    const first = document.querySelector('#duet-loading'), own = document.querySelector('#root input[value^="ws://"]');
    if (there(first)) {
      seen.add(first.textContent.trim().split(/\\s+/).join(' '));
      (window.backgroundsSeen ??= []).push(getComputedStyle(first).backgroundImage);
    }
    if (own && shown(own)) seen.add("viser's own panel");
    const said = document.querySelector('#duet-note');
    if (there(said)) window.noteSeen = [said.textContent, said.getBoundingClientRect().toJSON()];
    for (const note of document.querySelectorAll('[class*=Notification-root]')) seen.add(note.textContent);
    if (there(document.querySelector('#root .duet'))) seen.add('our page');
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
})()"""
"""Records the contents of every drawn frame from the first one on."""


@pytest.mark.parametrize(
    ("width", "height", "locale", "query", "loading", "note"),
    [
        (1024, 768, "sl-SI", "theme=dark", "Nalaganje …", "Brez grafične kartice"),
        (390, 844, "en-GB", "lang=de", "Wird geladen …", "Ohne Grafikkarte gezeichnet"),
    ],
)
def test_visers_own_page_is_never_visible(
    house: OpenHouse,
    page_at: PageAt,
    width: int,
    height: int,
    locale: str,
    query: str,
    loading: str,
    note: str,
) -> None:
    page = page_at(width, height, locale=locale)
    page.add_init_script(SEEN)
    line = page.context.new_cdp_session(page)
    line.send("Network.enable")
    slow = {"offline": False, "latency": 50, "downloadThroughput": 1_500_000, "uploadThroughput": 500_000}
    line.send("Network.emulateNetworkConditions", slow)
    page.goto(f"{house().url}/?{query}", wait_until="commit")
    # For some seconds, one line says how this browser draws.
    page.wait_for_function("window.noteSeen")
    said, box = page.evaluate("noteSeen")
    assert note in said and box["x"] >= 0.0 and box["x"] + box["width"] <= width and box["height"] < 30.0
    wait_ready(page, "/room")
    assert any("rgb(34, 38, 44)" in one for one in page.evaluate("backgroundsSeen")) == ("dark" in query)
    card = page.locator("#duet-contact").bounding_box()
    assert card is not None and (
        box["y"] >= card["y"] + card["height"] or box["y"] + box["height"] <= card["y"]
    ), "the note overlaps the card"
    page.wait_for_function("seenSoFar.has('our page')")
    assert set(page.evaluate("[...seenSoFar]")) == {f"Duet {loading}", "our page"}
    screenshot(page, f"opened-{width}")


@pytest.mark.thorough
def test_a_folder_opens_by_keys_and_the_note_disappears(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    # The first note disappears by itself, on a busy machine perhaps before everything is loaded.
    page.goto(house().url, wait_until="commit")
    note = page.locator("#duet-note")
    note.wait_for()
    wait_ready(page, "/room")
    folder, inside = (
        page.get_by_role("button", name="Keep and replay", exact=True),
        page.get_by_role("button", name="Load a run"),
    )
    assert folder.get_attribute("aria-expanded") == "false" and not inside.is_visible()
    clock = page.get_by_role("button", name="Pause", exact=True)
    # It can have the focus, and neither key has another effect there.
    folder.focus()
    assert folder.evaluate("e => e === document.activeElement")
    for key, opened in (("Enter", "true"), (" ", "false"), (" ", "true")):
        page.keyboard.press(key)
        until(
            page, lambda opened=opened: folder.get_attribute("aria-expanded") == opened, f"{key!r}: {opened}"
        )
    inside.wait_for()
    assert clock.is_visible()
    folder.click()
    until(page, lambda: folder.get_attribute("aria-expanded") == "false", "a click")
    # The note about the browser disappears by itself.
    note.wait_for(state="detached")
    accessible(page)


CARD = "#duet-welcome"
VISIBILITY = "part => getComputedStyle(part).visibility"
STILL = changed(Settings(), "autopilot", False)
"""Arms at rest, so that the mouse can take hold of one."""

WORDS = {
    "en": "Pull the orange hand into the ring.",
    "de": "Ziehen Sie die orange Hand in den Ring.",
    "sl": "Potegnite oranžno roko v obroč.",
}


def comes_not(page: Page) -> None:
    """Check that a page does not show the welcome card, although the server has sent it."""
    page.locator(".duet-welcome").wait_for(state="attached")
    page.wait_for_function("performance.now() > 2000 && document.documentElement.matches('.duet-built')")
    wait_frames(page, 10)
    assert page.locator(CARD).count() == 0


def fits(card: Locator, width: int, height: int) -> bool:
    """True if a card is inside the window [CSS px] and its texts are complete."""
    box = card.bounding_box()
    whole = (
        "card => [card, ...card.querySelectorAll('p, button')].every(e => e.scrollWidth <= e.clientWidth + 1)"
    )
    return (
        box is not None
        and min(box["x"], box["y"]) >= 0.0
        and box["x"] + box["width"] <= width
        and box["y"] + box["height"] <= height
        and card.evaluate(whole)
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("width", "height", "language", "look", "out"),
    [
        (1440, 900, "en", "theme=light", "Escape"),
        (1024, 768, "de", "theme=dark&profile=projector", "Start lesson 1"),
        (390, 844, "sl", "theme=dark", "Just play"),
    ],
)
def test_the_welcome_card_hides_no_hand_and_closes_by_key_or_button(
    house: OpenHouse, page_at: PageAt, width: int, height: int, language: Language, look: str, out: str
) -> None:
    page = page_at(width, height, newcomer=True)
    if out == "Just play":
        page.add_init_script(
            "Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('blocked'); } })"
        )
    session = visit(page, house(STILL), f"lang={language}&{look}")
    card = page.get_by_role("dialog")
    card.get_by_text(WORDS[language]).wait_for()
    arms = [f"/arms/{arm.name}{WRIST}" for arm in session.simulation.room.arms]
    until(page, lambda: page.evaluate(FREE, arms) == [], "both hands in free sight")
    until(page, lambda: fits(card, width, height), "the whole card in the window")
    # The reason is shown only in a wide window.
    assert card.locator("svg").is_visible() == card.locator(".why").is_visible() == (width > 1280)
    assert page.evaluate("document.activeElement === document.body"), "the card has taken the keys"
    screenshot(page, f"welcome-{width}")
    page.keyboard.press("Tab")
    first = card.get_by_role("button").first
    assert first.evaluate("button => button === document.activeElement")
    before = session.settings
    if out == "Escape":
        page.keyboard.press(out)
    else:
        page.get_by_role("button", name=words_of(language)(out)).click()
    card.wait_for(state="detached")
    assert session.held is None
    if out == "Start lesson 1":
        page.locator(".duet-l-head .crumb").get_by_text("Lektion 1").wait_for()
        return
    assert session.settings == before
    page.keyboard.press("ArrowUp")
    until(page, lambda: session.held is not None, "a key that moves the hand")


def test_the_welcome_card_closes_at_the_first_drag_and_never_returns(
    house: OpenHouse, page_at: PageAt
) -> None:
    opened = house(STILL)
    page = page_at(1024, 768, newcomer=True)
    session = visit(page, opened)
    page.locator(CARD).wait_for()
    plots = page.locator("[data-duet-holds~=plots]").first
    until(page, lambda: plots.evaluate(VISIBILITY) == "hidden", "no plot half seen below the card")
    settled_view(page)
    grab(page, f"/arms/right{WRIST.removesuffix('/j7')}", lambda: session.held is not None)
    page.mouse.up()
    page.locator(CARD).wait_for(state="detached")
    until(page, lambda: plots.evaluate(VISIBILITY) == "visible", "the plots again")
    again = page.context.new_page()
    visit(again, opened)
    comes_not(again)


LOSE = "window.lost = __viserMutable.canvas.getContext('webgl2').getExtension('WEBGL_lose_context')"


def test_a_lost_picture_is_reported_until_it_is_restored(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    visit(page, house(STILL), "lang=en")
    page.evaluate(f"{LOSE}; lost.loseContext()")
    said = page.get_by_role("alert").get_by_text("The picture is lost: the graphics card gave it up.")
    said.wait_for()
    screenshot(page, "picture-lost")
    page.evaluate("lost.restoreContext()")
    said.wait_for(state="detached")
