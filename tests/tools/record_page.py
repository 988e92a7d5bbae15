"""Record the README's moving picture from the real page: `python -m tests.tools.record_page [--out FILE.webp]`.

A mouse pulls the orange arm's hand towards the silver one and back; what the browser shows becomes an animated WebP.
"""

from __future__ import annotations

import argparse
import base64
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from PIL import Image, ImageDraw
from playwright.sync_api import Page, sync_playwright

from app.settings import Settings
from app.start import start_app
from tests.app.page.by_hand import hand, visit
from tests.browser import launch, until, wait_frames, world_to_px

SIZE: Final = (1120, 700)
WIDTH: Final = 880
"""Of the picture [px]."""

PERIOD: Final = 0.1
"""Between two frames of the picture [s]."""

LARGEST: Final = 3_000_000
"""[B]"""

LINK: Final = "picture=fine&autopilot=0&theme=light"


@contextmanager
def frames(page: Page) -> Iterator[list[tuple[float, Image.Image]]]:
    """What the page shows while open: (time [s], picture)."""
    shown: list[tuple[float, Image.Image]] = []
    chrome = page.context.new_cdp_session(page)

    def keep(event: dict[str, Any]) -> None:
        shown.append(
            (float(event["metadata"]["timestamp"]), Image.open(io.BytesIO(base64.b64decode(event["data"]))).convert("RGB"))
        )
        chrome.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})

    chrome.on("Page.screencastFrame", keep)
    chrome.send("Page.startScreencast", {"format": "png", "everyNthFrame": 1})
    yield shown
    chrome.send("Page.stopScreencast")
    chrome.detach()


def with_pointer(picture: Image.Image, at: tuple[float, float] | None) -> Image.Image:
    """Return a frame with the pointer of the mouse, which a browser without a window does not draw."""
    if at is not None:
        x, y = at
        shape = [(0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12)]
        ImageDraw.Draw(picture).polygon([(x + dx, y + dy) for dx, dy in shape], fill=(20, 20, 20), outline=(255, 255, 255))
    return picture


def record(page: Page, session: Any) -> list[Image.Image]:
    """Pull the hand to the silver arm's hand and back, and return the frames, one every `PERIOD`."""
    kinematics, other = session.simulation.kinematics, session.simulation.avoiding
    start, goal = hand(session), kinematics.hand_pose(other).translation.copy()
    way = [start + (goal - start) * share for share in (0.0, 0.3, 0.6, 0.85, 1.0, 1.0, 0.7, 0.35, 0.0)]
    pixels = [world_to_px(page, point) for point in way]
    places: list[tuple[float, tuple[float, float]]] = []
    with frames(page) as shown:
        page.mouse.move(*pixels[0])
        wait_frames(page, 6)
        page.mouse.down()
        until(page, lambda: session.held is not None, "the hand is taken")
        for a, b in pairwise(pixels):
            for share in np.linspace(0.0, 1.0, 13)[1:]:
                x, y = (p + (q - p) * float(share) for p, q in zip(a, b, strict=True))
                page.mouse.move(x, y)
                end = session.simulation.time + PERIOD
                until(page, lambda end=end: session.simulation.time >= end, "simulated time")
                places.append((shown[-1][0] if shown else 0.0, (x, y)))
        page.mouse.up()
        end = session.simulation.time + 1.0
        until(page, lambda: session.simulation.time >= end, "simulated time")
    found: list[Image.Image] = []
    times = np.array([time for time, _ in shown])
    for time in np.arange(times[0], times[-1], PERIOD).tolist():
        picture = shown[int(np.searchsorted(times, time, "right")) - 1][1].copy()
        at = next((place for moment, place in reversed(places) if moment <= time), pixels[0])
        found.append(with_pointer(picture, at).resize((WIDTH, WIDTH * picture.height // picture.width), Image.Resampling.LANCZOS))
    return found


def save(pictures: list[Image.Image], out: Path) -> None:
    """Save an animated WebP that is no larger than `LARGEST`."""
    for quality in (80, 65, 50, 35):
        first, *others = pictures
        first.save(
            out,
            save_all=True,
            append_images=others,
            duration=round(1000 * PERIOD),
            loop=0,
            quality=quality,
            method=4,
        )
        if out.stat().st_size <= LARGEST:
            return
    raise SystemExit(f"{out}: larger than {LARGEST} bytes")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(".readme/duet.webp"))
    given = parser.parse_args()
    house = start_app("127.0.0.1", 0, Settings())
    with sync_playwright() as playwright:
        browser = launch(playwright)
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        pictures = record(page, visit(page, house, LINK))
        save(pictures, given.out)
        print(f"{given.out}: {len(pictures)} frames, {given.out.stat().st_size} bytes")
        browser.close()
    house.close()
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)
