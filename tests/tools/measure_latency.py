"""How long a movement of the mouse takes to become a picture: `python -m tests.tools.measure_latency`.

A figure for a person to read, not a test: it says what this machine does at this moment. In a small window, the hand's handle is
pulled by single moves of the mouse while everything else stands still; each is timed from the pointer's event to the first drawn
frame in which a link of the guided arm has turned.
"""

import statistics

import numpy as np
from playwright.sync_api import Page, sync_playwright

from app.hosting.private_host import PrivateHost
from app.settings import Settings, from_query
from app.start import start_app
from tests.browser import (
    close_software_note,
    launch,
    settled_view,
    take_hold,
    until,
    wait_frames,
    wait_ready,
    world_to_px,
)

MOVES = 60
GRIP = 0.22 * 0.9
"""How far out on the arrow, which is 0.22 m long, it is taken [m]."""

_WATCH = """() => {
  const links = ["j1", "j2", "j3", "j4", "j5", "j6", "j7"].map((_, i, all) => "/arms/right/base/" + all.slice(0, i + 1).join("/"));
  const pose = () => links.flatMap(name => __viserMutable.nodeRefFromName[name].quaternion.toArray());
  const differ = (a, b) => Math.max(...a.map((x, i) => Math.abs(x - b[i])));
  window.duet = { seen: [], still: 0 };
  addEventListener("pointermove", event => { duet.moved = event.timeStamp; duet.from = pose(); }, true);
  let last = pose();
  const frame = () => {
    const now = pose();
    duet.still = differ(now, last) < 1e-6 ? duet.still + 1 : 0;
    if (duet.from && differ(now, duet.from) > 1e-5) {
      duet.seen.push(performance.now() - duet.moved);
      duet.from = null;
    }
    last = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}"""


def measure(page: Page, host: PrivateHost) -> list[float]:
    """Return the delays of single mouse moves [ms]."""
    # The page may have come anew, without the fine picture that a machine without a graphics card is too slow for.
    until(page, lambda: len(host.sessions) == 1, "one session")
    (session,) = host.sessions.values()
    simulation = session.simulation
    close_software_note(page)
    settled_view(page)
    pose = simulation.kinematics.hand_pose(simulation.guided)
    place, arrows = pose.translation.copy(), pose.rotation.T.copy()
    # The arrow that is seen best.
    middle = np.array(world_to_px(page, place))
    arrow = max(arrows, key=lambda along: float(np.linalg.norm(world_to_px(page, place + GRIP * along) - middle)))
    grip = place + GRIP * arrow
    take_hold(page, lambda: grip, lambda: session.held is not None)
    x, y = world_to_px(page, grip)
    page.evaluate(_WATCH)
    ahead = np.array(world_to_px(page, grip + arrow * 0.05)) - (x, y)
    for i in range(MOVES):
        page.wait_for_function("() => duet.still > 3")
        shift = ahead * (1.0 if i % 2 == 0 else 0.4)
        page.mouse.move(x + shift[0], y + shift[1])
        # A move that the handle does not feel (a pixel beside it) is left out.
        wait_frames(page, 8)
    page.mouse.up()
    return page.evaluate("duet.seen")


def main() -> None:
    """Measure and print."""
    settings, _ = from_query({"autopilot": "0", "gizmo": "1"}, Settings())
    house = start_app("127.0.0.1", 0, settings)
    assert isinstance(house.host, PrivateHost)
    try:
        with sync_playwright() as playwright:
            browser = launch(playwright)
            page = browser.new_page(viewport={"width": 700, "height": 500})
            page.goto(house.url)
            wait_ready(page, "/gizmo/hand")
            delays = measure(page, house.host)
            browser.close()
    finally:
        house.close()
    if not delays:
        raise SystemExit("no move of the mouse turned a link within 8 frames; this machine is too slow to be measured like this")
    print(
        f"pointer to picture, {len(delays)} moves: median {statistics.median(delays):.0f} ms, p90 {np.percentile(delays, 90):.0f} ms"
    )


if __name__ == "__main__":
    main()
