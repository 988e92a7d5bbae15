"""The ring that the first sentence of the page speaks of is seen: its own colour, where it is, in every look."""

import colorsys
import io

import numpy as np
import pinocchio as pin
from PIL import Image
from playwright.sync_api import Page

from app.session.session import Session
from app.stage.target_place import RADIUS
from app.theme import PALETTES, rgb
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import visit
from tests.browser import PageAt, screenshot, until, world_to_px


def ring_share(page: Page, session: Session, colour: str) -> float:
    """The share of 24 points all along the ring at which its colour is seen; the hand and the handles may hide some."""
    place, rotation = ask(session, lambda s: (s.simulation.place, s.simulation.place_rotation))
    assert place is not None and rotation is not None
    picture = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), float) / 255.0
    wanted = colorsys.rgb_to_hsv(*(c / 255.0 for c in rgb(colour)))[0]
    seen = 0
    for angle in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
        point = pin.SE3(rotation, place).act(RADIUS * np.array([np.cos(angle), np.sin(angle), 0.0]))
        x, y = (round(value) for value in world_to_px(page, point))
        spot = picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
        hues = [colorsys.rgb_to_hsv(*pixel) for pixel in spot]
        seen += any(abs((h - wanted + 0.5) % 1.0 - 0.5) < 0.05 and s > 0.15 for h, s, _ in hues)
    return seen / 24.0


def test_the_ring_is_seen_in_every_look(house: OpenHouse, page_at: PageAt) -> None:
    assert RADIUS >= 0.06, "a wrist of our robots would hide it"
    page = page_at(800, 600)
    session = visit(page, house(), "scene=hold&autopilot=0")
    page.get_by_text("keeps its hand in the ring").wait_for()
    for look in ("light desk fast", "dark projector fast", "dark desk fine", "light desk fine"):
        choice = dict(zip(("theme", "profile", "picture"), look.split(), strict=True))
        ask(session, lambda s, choice=choice: [s.change(key, value) for key, value in choice.items()])
        error = PALETTES[session.settings.page.theme].error
        until(page, lambda error=error: ring_share(page, session, error) > 0.5, f"the ring, {look}")
        screenshot(page, f"ring-{look.replace(' ', '-')}")
