"""How long a movement of the mouse takes to become a picture: `python -m tests.tools.measure_latency`.

A figure for a person to read, not a test: it says what this machine does at this moment. In a small window, the hand's handle is
pulled by single moves of the mouse while everything else stands still; each is timed from the pointer's event to the first drawn
frame in which a link of the guided arm has turned. Beside it stands viser's own floor: the same on a plain viser server, on which
a handle turns one frame and nothing is computed.
"""

import multiprocessing
import statistics
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from typing import Any

import numpy as np
import viser
from playwright.sync_api import Browser, Page

from app.features import FEATURES
from app.hosting.serve_options import ServeOptions
from app.start import start_app
from controllers.kinematics import Array
from tests.app.page.by_hand import visit
from tests.browser import (
    WELCOMED,
    close_software_note,
    free_port,
    launch,
    settled_view,
    started_playwright,
    take_hold,
    wait_frames,
    wait_ready,
    world_to_px,
)

MOVES = 60
HANDLE = 0.22
GRIP = 0.9 * HANDLE
"""Length of the handle's arrows, and how far out on one it is taken [m]."""

LINKS = ["/arms/right/base" + "".join(f"/j{j}" for j in range(1, i + 1)) for i in range(1, 8)]
FLOOR = "/turned"

_WATCH = """links => {
  const pose = () => links.flatMap(name => __viserMutable.nodeRefFromName[name].quaternion.toArray());
  const differ = (a, b) => Math.max(...a.map((x, i) => Math.abs(x - b[i])));
  window.latency = { seen: [], still: 0 };
  addEventListener("pointermove", event => { latency.moved = event.timeStamp; latency.from = pose(); }, true);
  let last = pose();
  const frame = () => {
    const now = pose();
    latency.still = differ(now, last) < 1e-6 ? latency.still + 1 : 0;
    if (latency.from && differ(now, latency.from) > 1e-5) {
      latency.seen.push(performance.now() - latency.moved);
      latency.from = null;
    }
    last = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}"""


def measure(page: Page, place: Array, arrows: Array, held: Callable[[], object], links: list[str]) -> list[float]:
    """Return the delays of single mouse moves [ms].

    Args:
        place: of the handle (3,) [m].
        arrows: its directions (3, 3), one a row.
        held: whether it is dragged.
        links: the nodes of which one turns.
    """
    close_software_note(page)
    settled_view(page)
    # The arrow that is seen best.
    middle = np.array(world_to_px(page, place))
    arrow = max(arrows, key=lambda along: float(np.linalg.norm(world_to_px(page, place + GRIP * along) - middle)))
    grip = place + GRIP * arrow
    take_hold(page, lambda: grip, held)
    x, y = world_to_px(page, grip)
    page.evaluate(_WATCH, links)
    ahead = np.array(world_to_px(page, grip + arrow * 0.05)) - (x, y)
    for i in range(MOVES):
        page.wait_for_function("() => latency.still > 3")
        shift = ahead * (1.0 if i % 2 == 0 else 0.4)
        page.mouse.move(x + shift[0], y + shift[1])
        # A move that the handle does not feel (a pixel beside it) is left out.
        wait_frames(page, 8)
    page.mouse.up()
    return page.evaluate("latency.seen")


def of_duet(browser: Browser) -> list[float]:
    """Return the delays in Duet [ms]."""
    house = start_app(ServeOptions(), features=FEATURES)
    try:
        page = browser.new_page(viewport={"width": 700, "height": 500})
        # The welcome would lie over the handle.
        page.add_init_script(WELCOMED)
        session = visit(page, house, "autopilot=0&gizmo=1")
        pose = session.simulation.kinematics.hand_pose(session.simulation.guided)
        delays = measure(page, pose.translation.copy(), pose.rotation.T.copy(), lambda: session.held is not None, LINKS)
        page.close()
        return delays
    finally:
        house.close()


def of_viser(browser: Browser) -> list[float]:
    """Return the delays of a plain viser server [ms]."""
    with plain_viser() as (url, held):
        page = browser.new_page(viewport={"width": 700, "height": 500})
        page.goto(url)
        wait_ready(page, FLOOR)
        delays = measure(page, np.zeros(3), np.eye(3), held.is_set, [FLOOR])
        page.close()
        return delays


@contextmanager
def plain_viser() -> Iterator[tuple[str, Event]]:
    """A plain viser server in a process of its own, as Duet adapts viser in this one; gives its address, and whether its handle is held."""
    context = multiprocessing.get_context("spawn")
    held, (ours, theirs) = context.Event(), context.Pipe()
    process = context.Process(target=_serve_plain, args=(theirs, held), daemon=True)
    process.start()
    try:
        yield f"http://127.0.0.1:{ours.recv()}", held
    finally:
        process.terminate()
        process.join()


def _serve_plain(parent: Connection, held: Event) -> None:
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    server.initial_camera.position = (1.0, 0.8, 0.6)
    server.initial_camera.look_at = (0.0, 0.0, 0.0)
    turned = server.scene.add_frame(FLOOR, axes_length=0.1, axes_radius=0.005)
    handle = server.scene.add_transform_controls("/handle", scale=HANDLE, disable_rotations=True)

    @handle.on_update
    async def _(event: viser.TransformControlsEvent) -> None:
        held.set()
        angle = float(np.sum(event.target.position))
        turned.wxyz = (np.cos(angle), np.sin(angle), 0.0, 0.0)
        server.flush()

    parent.send(server.get_port())
    parent.poll(None)


def figure(delays: list[float]) -> str:
    """Return what is printed of some delays [ms]."""
    if not delays:
        raise SystemExit("no move of the mouse turned a link within 8 frames; this machine is too slow to be measured like this")
    return f"{len(delays)} moves: median {statistics.median(delays):.0f} ms, p90 {np.percentile(delays, 90):.0f} ms"


def main() -> None:
    """Measure and print."""
    measures: dict[str, Callable[[Any], list[float]]] = {"viser's own floor": of_viser, "pointer to picture": of_duet}
    with started_playwright() as playwright:
        browser = launch(playwright)
        for name, delays_of in measures.items():
            print(f"{name}, {figure(delays_of(browser))}")
        browser.close()


if __name__ == "__main__":
    main()
