"""Helpers that operate a page with a real mouse and keyboard, and check the result."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Locator, Page

from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import Settings
from app.start import App
from controllers.kinematics import Array
from scenes.settings import values
from tests.app.conftest import HAND, ask, live_sessions
from tests.app.page.helpers import SPECS, another, page_label
from tests.browser import (
    close_software_note,
    point_at,
    take_hold,
    until,
    wait_ready,
    world_position,
    world_to_px,
)

USUAL = {key: value for key, value in values(Settings()).items() if key != "picture"}
WRIST = "/base/j1/j2/j3/j4/j5/j6/j7"

# viser's client applies updates last: it complains about the update of a plot that was just removed.
LATE_UPDATE = r"Tried to update non-existent component"


def visit(page: Page, opened: App, query: str = "", url: str = "") -> Session:
    """Session of a completely opened page. `url`: another address of the server."""
    before = set(live_sessions(opened))
    page.set_default_timeout(60_000)
    page.goto(f"{url or opened.url}/?{query}")
    wait_ready(page, HAND if "gizmo=1" in query else "/room")
    # The page may have reconnected, without the fine picture that this machine is too slow for.
    until(page, lambda: len(set(live_sessions(opened)) - before) == 1, "one session")
    close_software_note(page)
    (number,) = set(live_sessions(opened)) - before
    return live_sessions(opened)[number]


def hands_of(session: Session) -> tuple[Array, Array]:
    """Places of the guided and of the other hand, (3,) each [m]; twice the same if there is one arm."""
    now = session.simulation
    own, other = (now.kinematics.hand_pose(arm).translation.copy() for arm in (now.guided, now.avoiding))
    return own, other


def chosen(session: Session) -> dict[str, Any]:
    """All settings except the one that the browser chooses."""
    return {key: value for key, value in values(session.settings).items() if key != "picture"}


def hand(session: Session) -> np.ndarray:
    return ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())


def run_on(page: Page, session: Session, seconds: float) -> None:
    end = session.simulation.time + seconds
    until(page, lambda: session.simulation.time >= end, "simulated time")


def row_of(page: Page, label: str) -> Locator:
    """Row of a visible control, by its label."""
    return page.locator("label:visible").get_by_text(label, exact=True).locator("xpath=../../..")


def control(page: Page, key: str) -> Locator:
    return row_of(page, page_label(key))


def see_controls(page: Page, session: Session, keys: tuple[str, ...]) -> None:
    """Wait until exactly those of `keys` are visible that matter now. All are on the open tab."""
    labels, expected = (
        {page_label(key) for key in keys},
        {page_label(key) for key in keys if matters(key, session.settings)},
    )
    seen = page.locator("label:visible")
    until(
        page,
        lambda: expected == labels & set(seen.all_inner_texts()),
        f"just {sorted(expected)} of {sorted(labels)}",
    )


def set_by_hand(page: Page, session: Session, key: str) -> None:
    """Change a setting by mouse or keys; wait until the server has changed it, and no other."""
    spec, before = SPECS[key], values(session.settings)
    place = control(page, key)
    sent, expected = another(key, before[key])
    if spec.choices:
        place.locator("input[role=combobox], input:visible").first.click()
        page.get_by_role("option", name=sent, exact=True).click()
    elif isinstance(expected, bool):
        place.locator("input[type=checkbox]").dispatch_event("click")
    else:
        box = place.get_by_role("textbox").last
        box.fill(sent if isinstance(sent, str) else f"{sent:g}")
        box.press("Enter")
    until(page, lambda: values(session.settings)[key] == pytest.approx(expected, abs=1e-9), key)
    after = values(session.settings)
    different = {k: after[k] for k in after if after[k] != before[k]}
    assert set(different) == {key}, different


def drag_through(page: Page, session: Session, points: list[np.ndarray]) -> None:
    """Take hold at the first point of the scene with the mouse, and drag through the others."""
    take_hold(page, lambda: points[0], lambda: session.held is not None)
    for point in points[1:]:
        point_at(page, point)


def drag(page: Page, places: Sequence[tuple[float, float]]) -> None:
    """Drag the mouse from the first place through the others [CSS px in the window]."""
    page.mouse.move(*places[0])
    page.mouse.down()
    for place in places[1:]:
        page.mouse.move(*place, steps=4)
    page.mouse.up()


CURSOR = "getComputedStyle(__viserMutable.canvas).cursor"


def grab(page: Page, node: str, held: Callable[[], bool]) -> tuple[float, float]:
    """Take hold of a link, which may move, with the mouse. Return the place of the press [CSS px]."""
    x = y = 0.0

    def over_it() -> bool:
        nonlocal x, y
        x, y = world_to_px(page, world_position(page, node))
        page.mouse.move(x, y)
        return page.evaluate(CURSOR) == "grab"

    until(page, over_it, "a hand over the arm")
    page.mouse.down()
    page.mouse.move(x + 6, y)
    until(page, held, "taking hold")
    return x, y


Touch = Callable[[str, float, float], None]


def finger(page: Page) -> Touch:
    """Sender of `touchStart`, `touchMove` or `touchEnd` at a place of the window [CSS px]."""
    protocol = page.context.new_cdp_session(page)

    def touch(kind: str, x: float, y: float) -> None:
        points = [] if kind == "touchEnd" else [{"x": x, "y": y, "id": 1}]
        protocol.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    return touch


def drag_by_finger(page: Page, places: Sequence[tuple[float, float]]) -> None:
    touch = finger(page)
    for kind, place in (
        ("touchStart", places[0]),
        *(("touchMove", place) for place in places[1:]),
        ("touchEnd", places[-1]),
    ):
        touch(kind, *place)


PLOTS = """() => [...document.querySelectorAll('.duet-title')].map(title => {
  const caption = title.parentElement.parentElement, plot = caption.nextElementSibling, canvas = plot?.querySelector('canvas');
  const box = caption.getBoundingClientRect(), high = plot?.getBoundingClientRect().height ?? 0;
  const wide = box.width / title.closest('[data-floating-window]').clientWidth;
  const seen = { title: title.textContent, top: Math.round(box.top), high, wide, drawn: false };
  if (!box.height) return null;
  if (canvas?.width) {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    // Axes and the grid are grey, lines are not.
    let coloured = 0;
    for (let i = 0; i < data.length && coloured <= 50; i += 4)
      coloured += data[i + 3] > 99 && Math.abs(data[i] - data[i + 1]) + Math.abs(data[i + 1] - data[i + 2]) > 60;
    seen.drawn = coloured > 50;
  } else seen.drawn = !!plot?.querySelector('svg path') || (plot?.textContent ?? '').length > 80;
  return seen;
}).filter(seen => seen)"""


def see_plots(page: Page, titles: tuple[str, ...]) -> None:
    """Wait until exactly these plots (beginnings of titles) are drawn side by side and fill their panel."""

    def as_expected() -> bool:
        seen: list[dict[str, Any]] = page.evaluate(PLOTS)
        as_named = len(seen) == len(titles) and all(
            p["title"].startswith(t) for p, t in zip(seen, titles, strict=True)
        )
        fair = (
            all(p["drawn"] and p["high"] > 60 and p["wide"] > 0.2 for p in seen)
            and sum(p["wide"] for p in seen) > 0.9
        )
        return as_named and fair and len({p["top"] for p in seen}) == 1

    try:
        until(page, as_expected)
    except AssertionError:
        pytest.fail(f"{titles} expected, seen {page.evaluate(PLOTS)}")


FREE = """names => names.map(name => {
  const { camera, nodeRefFromName, canvas } = __viserMutable, box = canvas.getBoundingClientRect(), node = nodeRefFromName[name];
  if (!node) return name + ' is not there';
  const v = camera.position.clone(); node.updateWorldMatrix(true, false); node.getWorldPosition(v); v.project(camera);
  const x = box.left + (1 + v.x) / 2 * box.width, y = box.top + (1 - v.y) / 2 * box.height;
  const top = document.elementFromPoint(x, y);
  return top === canvas ? '' : `${name} at ${x.toFixed(0)}, ${y.toFixed(0)} is under ${top && top.outerHTML.slice(0, 90)}`;
}).filter(text => text)"""


def see_free(page: Page, nodes: list[str], where: str) -> None:
    """Wait until nothing covers these nodes, or fail with the cover. The view follows the panels' layout."""
    try:
        until(page, lambda: not page.evaluate(FREE, nodes), "all in free sight", 30.0)
    except AssertionError:
        pytest.fail(f"{where}: " + "\n".join(page.evaluate(FREE, nodes)))
