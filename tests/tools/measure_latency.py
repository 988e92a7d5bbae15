"""Time from a mouse movement to its picture: `python -m tests.tools.measure_latency`.

A figure of this machine at this moment, not a test. In a small window single mouse moves pull the hand's
handle while everything else is at rest; each is timed from the pointer's event to the first drawn frame with
a turned link of the guided arm. Two lower limits are measured alternately with it: a plain viser server with
a handle that turns one frame, and one that draws the same room and arms and turns one arm; neither computes
anything. Of Duet's time the server's part is given, too: from the handle's message to the end of the
answering frame.
"""

import multiprocessing
import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from unittest.mock import patch

import numpy as np
import pinocchio as pin
import viser
from playwright.sync_api import Browser, Page

from app.features import FEATURES
from app.hosting.frame_loop import FrameLoop
from app.hosting.serve_options import ServeOptions
from app.session.actions import Action, Drag
from app.session.session import Session
from app.settings import PageSettings
from app.stage.arms import ArmView
from app.stage.stage import light_room
from app.start import start_app
from controllers.kinematics import Array
from scenes.room_shells import furniture_glb
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
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
TURNS = 3
"""Number of measurements of each, in turns."""

HANDLE = 0.22
GRIP = 0.9 * HANDLE
"""Length of the handle's arrows, and grip distance along one [m]."""

LINKS = ["/arms/right/base" + "".join(f"/j{j}" for j in range(1, i + 1)) for i in range(1, 8)]
FLOOR = "/turned"
ROOM, POINTER, SERVER = "the same room and arms on plain viser", "pointer to picture", "of it on the server"

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


def measure(
    page: Page, place: Array, arrows: Array, held: Callable[[], object], links: list[str]
) -> list[float]:
    """Delays of single mouse moves [ms].

    Args:
        place: of the handle (3,) [m].
        arrows: its directions (3, 3), one per row.
        held: gives True while it is dragged.
        links: nodes, one of which turns.
    """
    close_software_note(page)
    settled_view(page)
    # The most visible arrow.
    middle = np.array(world_to_px(page, place))
    arrow = max(
        arrows, key=lambda along: float(np.linalg.norm(world_to_px(page, place + GRIP * along) - middle))
    )
    grip = place + GRIP * arrow
    take_hold(page, lambda: grip, held)
    x, y = world_to_px(page, grip)
    page.evaluate(_WATCH, links)
    ahead = np.array(world_to_px(page, grip + arrow * 0.05)) - (x, y)
    for i in range(MOVES):
        page.wait_for_function("() => latency.still > 3")
        shift = ahead * (1.0 if i % 2 == 0 else 0.4)
        page.mouse.move(x + shift[0], y + shift[1])
        # A move that does not reach the handle (a pixel off) is omitted.
        wait_frames(page, 8)
    page.mouse.up()
    return page.evaluate("latency.seen")


def of_duet(browser: Browser) -> dict[str, list[float]]:
    """Delays in Duet, and the server's part [ms]."""
    with watched_server() as served, closing(start_app(ServeOptions(), features=FEATURES)) as house:
        page = browser.new_page(viewport={"width": 700, "height": 500})
        # The welcome would cover the handle.
        page.add_init_script(WELCOMED)
        session = visit(page, house, "autopilot=0&gizmo=1")
        pose = session.simulation.kinematics.hand_pose(session.simulation.guided)
        delays = measure(
            page,
            pose.translation.copy(),
            pose.rotation.T.copy(),
            lambda: session.hand.held is not None,
            LINKS,
        )
        page.close()
    return {POINTER: delays, SERVER: served}


@contextmanager
def watched_server() -> Iterator[list[float]]:
    """Gives a growing list of times from a handle's message to the end of the answering frame [ms]."""
    times: list[float] = []
    came: list[float] = []
    answered: list[float] = []
    post, take, frame = Session.post, Session.take_actions, FrameLoop.round

    def posted(session: Session, action: Action) -> None:
        if isinstance(action, Drag):
            came.append(time.perf_counter())
        post(session, action)

    def taken(session: Session, elapsed: float) -> None:
        answered.extend(came)
        came.clear()
        take(session, elapsed)

    def framed(loop: FrameLoop) -> tuple[float, float]:
        result = frame(loop)
        times.extend(1e3 * (time.perf_counter() - one) for one in answered)
        answered.clear()
        return result

    with (
        patch.object(Session, "post", posted),
        patch.object(Session, "take_actions", taken),
        patch.object(FrameLoop, "round", framed),
    ):
        yield times


def of_viser(browser: Browser) -> dict[str, list[float]]:
    """Delays of a plain viser server that turns one frame [ms]."""
    return {"viser's own floor": _of_plain(browser, arms=False, links=[FLOOR])}


def of_room(browser: Browser) -> dict[str, list[float]]:
    """Delays of a plain viser server with Duet's room and arms [ms]."""
    return {ROOM: _of_plain(browser, arms=True, links=LINKS)}


def _of_plain(browser: Browser, arms: bool, links: list[str]) -> list[float]:
    with plain_viser(arms) as (url, held):
        page = browser.new_page(viewport={"width": 700, "height": 500})
        page.goto(url)
        wait_ready(page, links[-1])
        delays = measure(page, np.zeros(3), np.eye(3), held.is_set, links)
        page.close()
        return delays


@contextmanager
def plain_viser(arms: bool) -> Iterator[tuple[str, Event]]:
    """A plain viser server in its own process, without Duet's changes; gives address and "held" event."""
    context = multiprocessing.get_context("spawn")
    held, (ours, theirs) = context.Event(), context.Pipe()
    process = context.Process(target=_serve_plain, args=(theirs, held, arms), daemon=True)
    process.start()
    try:
        yield f"http://127.0.0.1:{ours.recv()}", held
    finally:
        process.terminate()
        process.join()


def _serve_plain(parent: Connection, held: Event, arms: bool) -> None:
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    server.initial_camera.position = (1.0, 0.8, 0.6)
    server.initial_camera.look_at = (0.0, 0.0, 0.0)
    turn = _add_room(server) if arms else _add_frame(server)
    handle = server.scene.add_transform_controls("/handle", scale=HANDLE, disable_rotations=True)

    @handle.on_update
    async def _(event: viser.TransformControlsEvent) -> None:
        held.set()
        turn(float(np.sum(event.target.position)))
        server.flush()

    parent.send(server.get_port())
    parent.poll(None)


def _add_frame(server: viser.ViserServer) -> Callable[[float], None]:
    turned = server.scene.add_frame(FLOOR, axes_length=0.1, axes_radius=0.005)

    def turn(angle: float) -> None:
        turned.wxyz = (np.cos(angle), np.sin(angle), 0.0, 0.0)

    return turn


def _add_room(server: viser.ViserServer) -> Callable[[float], None]:
    """Draw room and arms as Duet does without a graphics card. Returns the function that turns one arm."""
    simulation = Simulation(RunSettings())
    room, views = simulation.room, dict[str, ArmView]()
    light_room(server.scene, changed(PageSettings(), "picture", "fast"))
    # The handle is at the origin, in front of the arms.
    server.scene.add_glb("/room", furniture_glb(room.rig, coarse=True), position=(0.0, 0.0, -1.0))
    for arm, base, made in zip(room.arms, room.rig.bases, room.robots, strict=True):
        lower = pin.SE3(base.rotation, base.translation - np.array([0.0, 0.0, 1.0]))
        palette = "orange" if arm is simulation.guided else "silver"
        views[arm.name] = ArmView(server.scene, f"/arms/{arm.name}", lower, palette, False, made.key)
        views[arm.name].show(simulation.positions[arm.joints])
    start = simulation.positions[simulation.guided.joints].copy()
    return lambda angle: views[simulation.guided.name].show(start + angle)


def figure(delays: list[float]) -> str:
    if not delays:
        raise SystemExit(
            "no move of the mouse turned a link within 8 frames; this machine is too slow to be measured like this"
        )
    return f"{len(delays)} moves: median {statistics.median(delays):.0f} ms, p90 {np.percentile(delays, 90):.0f} ms"


def main() -> None:
    delays: defaultdict[str, list[float]] = defaultdict(list)
    with started_playwright() as playwright:
        browser = launch(playwright)
        for measured in (of_viser, of_room, of_duet) * TURNS:
            for name, some in measured(browser).items():
                delays[name] += some
        browser.close()
    for name, some in delays.items():
        print(f"{name}, {figure(some)}")
    ratios = [
        part(delays[POINTER]) / part(delays[ROOM])
        for part in (statistics.median, lambda some: float(np.percentile(some, 90)))
    ]
    print("pointer to picture beside the same on plain viser: median × {:.2f}, p90 × {:.2f}".format(*ratios))


if __name__ == "__main__":
    main()
