"""Take the README's pictures from the real page: `python -m tests.tools.record_page [--out FOLDER]`.

`duet.webp` is animated: a mouse pulls the orange arm towards the silver one and back. The run's clock
advances by a constant time per picture, at which they are played: a slow machine records the same.
"""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image, ImageDraw
from playwright.sync_api import Page

from app.features import FEATURES
from app.hosting.serve_options import ServeOptions
from app.session.session import Session
from app.start import start_app
from tests.app.conftest import ask
from tests.app.page.by_hand import grab, visit
from tests.browser import launch, settled_view, started_playwright, wait_frames, world_position, world_to_px

SIZE: Final = (1180, 740)
WIDTH: Final = 885
"""Width of the picture [px]."""

LARGEST: Final = 3_000_000
"""Largest file [B]."""

FRAME: Final = 0.025
"""Wall time per frame, as given to the run [s]."""

FRAMES: Final = 4
"""Frames per picture."""

PATIENT: Final = 60.0
"""Largest real wall time of a frame [s]."""

LINK: Final = "picture=fine&autopilot=0&theme=light"
WRIST: Final = "/arms/right/base/j1/j2/j3/j4/j5/j6"
GOAL: Final = "/arms/left/base/j1/j2/j3/j4/j5/j6"

WAY: Final = (0.0, 0.2, 0.4, 0.6, 0.75, 0.88, 1.0, 1.0, 1.0, 0.8, 0.5, 0.2, 0.0, 0.0)
"""Places of the mouse, as shares of the way between the wrists, every half second of simulated time."""

STILLS: Final = {
    "solo": ("scene=solo", 6.0),
    "ball": ("scene=ball", 5.0),
    "duet": ("scene=hold", 7.0),
    "master_slave": ("scene=master_slave", 5.0),
    "imitation": ("scene=imitation", 4.0),
    "first_task": ("scene=first_task&first=wall", 4.0),
    "two_makes": ("scene=master_slave&robot=ur5_panda&rig=table", 6.0),
}
"""Name of a picture → link of the page, and shown simulated time [s]."""

STILL_SIZE: Final = (1440, 900)

Shot = tuple[float, Image.Image]
"""Simulated time [s] and picture."""


def shot(page: Page, session: Session, x: float, y: float) -> Shot:
    """Picture with a mouse pointer, which a browser without a window does not draw."""
    time, picture = session.simulation.time, Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    pointer = [(0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12)]
    ImageDraw.Draw(picture).polygon(
        [(x + dx, y + dy) for dx, dy in pointer], fill=(20, 20, 20), outline=(255, 255, 255)
    )
    return time, picture.resize((WIDTH, WIDTH * picture.height // picture.width), Image.Resampling.LANCZOS)


def by_hand(session: Session) -> Callable[[float, float], int]:
    """Stop a run's clock without a visible pause. Returns the function that advances it."""
    step = session.control.step
    session.control.step = lambda elapsed, budget=0.0: 0
    return step


def record(page: Page, session: Session) -> list[Shot]:
    """Pull the wrist to the silver arm's and back."""
    settled_view(page)
    step = by_hand(session)
    x, y = world_to_px(page, world_position(page, WRIST))
    goal = world_to_px(page, world_position(page, GOAL))
    shots = [shot(page, session, x, y)]
    grab(page, WRIST, lambda: session.held is not None)
    begin = session.simulation.time
    times = begin + 0.5 * np.arange(len(WAY))
    while session.simulation.time < times[-1]:
        share = float(np.interp(session.simulation.time, times, WAY))
        at = x + 6 + share * (goal[0] - x), y + share * (goal[1] - y)
        page.mouse.move(*at)
        wait_frames(page, 2)
        ask(session, lambda _: [step(FRAME, PATIENT) for _ in range(FRAMES)])
        wait_frames(page, 2)
        shots.append(shot(page, session, *at))
    page.mouse.up()
    return shots


def take_still(page: Page, session: Session, time: float, out: Path) -> None:
    """Save a picture of a run at a time [s]."""
    step = by_hand(session)
    ask(session, lambda s: [s.reset(), *(step(FRAME, PATIENT) for _ in range(round(time / FRAME)))])
    settled_view(page)
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    picture.resize((960, 960 * picture.height // picture.width), Image.Resampling.LANCZOS).save(
        out, quality=86
    )


def save(shots: list[Shot], out: Path) -> None:
    """Save an animated WebP of at most `LARGEST`."""
    durations = [max(round(1000.0 * (later - earlier)), 20) for (earlier, _), (later, _) in pairwise(shots)]
    first, *others = [picture for _, picture in shots]
    for quality in (82, 70, 55, 40):
        # The last picture is shown longer before the loop restarts.
        every = [*durations, 900]
        first.save(
            out, save_all=True, append_images=others, duration=every, loop=0, quality=quality, method=4
        )
        if out.stat().st_size <= LARGEST:
            return
    raise SystemExit(f"{out}: larger than {LARGEST} bytes")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path(".readme"))
    given = parser.parse_args()
    house = start_app(ServeOptions(), features=FEATURES)
    with started_playwright() as playwright:
        browser = launch(playwright)
        for name, (query, time) in STILLS.items():
            page = browser.new_page(viewport={"width": STILL_SIZE[0], "height": STILL_SIZE[1]})
            take_still(
                page, visit(page, house, f"{query}&picture=fine&theme=light"), time, given.out / f"{name}.jpg"
            )
            page.close()
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        save(record(page, visit(page, house, LINK)), given.out / "duet.webp")
        browser.close()
    house.close()
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)
