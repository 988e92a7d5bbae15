"""The visitor is λ, in a real browser: from the first page, by mouse, finger and keys, with the outcome."""

import pytest
from playwright.sync_api import Page, expect

from app.features.lessons.bookmark import Phase
from app.session.frame import freeze
from app.start import App
from scenes.history import COLUMN
from scenes.laws import LEVER_LAW
from tests.app.conftest import OpenHouse, ask, live_sessions, private_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.by_hand import drag, drag_by_finger, run_on, visit
from tests.browser import PageAt, screenshot, settled_box, until

LEVER = "#duet-contact .lever"


def on_lever(page: Page, shares: tuple[float, ...]) -> list[tuple[float, float]]:
    """Pixel positions of the lever at these shares; half of its thumb stays inside at both ends."""
    left, top, wide, high = settled_box(page, page.locator(f"{LEVER} input"))
    return [(left + wide / 2, top + 11 + (1.0 - share) * (high - 22)) for share in shares]


class Game:
    """A game in which the visitor is λ."""

    def __init__(self, page: Page, opened: App) -> None:
        self.page, self.session = page, visit(page, opened, "theme=light")
        self.run = lessons_of(private_of(opened).visitors[max(live_sessions(opened))])
        self.slider = page.get_by_role("slider", name="λ: your lever")

    def share(self) -> float:
        return ask(self.session, lambda one: one.settings.run.law.hand_lever)

    def phase(self) -> Phase:
        return ask(self.session, lambda _: self.run.walk.phase)

    def lever_is_at(self, share: float, how: str, within: float = 0.02) -> None:
        until(self.page, lambda: abs(self.share() - share) <= within, how)


@pytest.mark.thorough
def test_a_visitor_plays_lambda_in_a_browser(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1440, 900, newcomer=True)
    game = Game(page, house())
    session = game.session
    page.get_by_role("button", name="Be λ yourself").click()
    game.slider.wait_for()
    assert ask(session, lambda one: (one.settings.run.law.law, one.paused)) == (LEVER_LAW, True)
    screenshot(page, "lever-begins")
    page.get_by_role("button", name="Run", exact=True).click()
    ask(session, lambda one: one.change("speed", 2.0))
    # The first attack meets an unprotected arm.
    until(page, lambda: ask(session, lambda one: one.simulation.sample().distance) < 0.0, "a touch")
    move_the_lever(game)
    run_on(page, session, 1.0)
    assert game.phase() is Phase.DO, "a slip of the finger must not end the game"
    assert ask(session, lambda one: freeze(one, 0.0).ghost) is None
    screenshot(page, "lever-plays")
    see_the_outcome(game)
    page.set_viewport_size({"width": 390, "height": 844})
    until(page, lambda: is_free_below_the_card(page), "on a phone below the card")
    screenshot(page, "lever-phone")


def move_the_lever(game: Game) -> None:
    """By keys of the page, mouse, its own keys and a finger."""
    page = game.page
    page.keyboard.press("ArrowUp")
    game.lever_is_at(0.1, "a key while a button has the focus", 1e-9)
    drag(page, on_lever(page, (0.1, 0.4, 0.6)))
    game.lever_is_at(0.6, "by mouse")
    before = game.share()
    page.keyboard.press("ArrowDown")
    game.lever_is_at(before - 0.1, "the keys of the page go on after a drag", 1e-9)
    shown = lambda: float(game.slider.input_value()) / 100.0  # noqa: E731
    until(page, lambda: abs(shown() - game.share()) < 0.006, "the lever follows the keys")
    game.slider.focus()
    page.keyboard.press("ArrowUp")
    game.lever_is_at(before, "by its own keys")
    drag_by_finger(page, on_lever(page, (before, 0.9)))
    game.lever_is_at(0.9, "by a finger")
    game.slider.blur()
    page.keyboard.press("ArrowRight")


def see_the_outcome(game: Game) -> None:
    """The paper's law beside the visitor's λ at the moment of the smallest distance."""
    page, session = game.page, game.session
    page.get_by_role("button", name="Skip the run").click()
    until(page, lambda: game.phase() is Phase.OBSERVE, "the end of the run")
    page.locator(".duet-lesson .duet-chart path").nth(3).wait_for(state="attached")
    page.locator(".duet-lesson .duet-caption").get_by_text("Smooth priority (paper)").wait_for()
    table = ask(session, lambda one: one.simulation.history.table())
    lams, nearest = set(table[:, COLUMN["lambda"]]), float(table[table[:, COLUMN["d"]].argmin(), COLUMN["t"]])
    assert {0.0, 0.1} < lams and len(lams) > 4

    def shown() -> float:
        replay = ask(session, lambda one: one.player and one.player.replay)
        return float("nan") if replay is None else replay.time

    assert nearest < 38.0, "the moment must be older than the plots show"
    until(page, lambda: abs(shown() - nearest) < 0.1, "the moment of the smallest distance")
    expect(game.slider).to_be_disabled(timeout=60_000)
    screenshot(page, "lever-over")


def is_free_below_the_card(page: Page) -> bool:
    lever, card = page.locator(LEVER).bounding_box(), page.locator("#duet-contact-picture").bounding_box()
    if lever is None or card is None:
        return False
    return 0.0 <= lever["x"] <= 390.0 - lever["width"] and lever["y"] >= card["y"] + card["height"]
