"""The page in a real browser, with a real mouse and a real keyboard.

Nothing waits for a time: `until` looks again after every drawn frame, and gives up after a while.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Dialog, Locator, Page

from app.hosts import House, LectureHost
from app.page.buttons import MARK
from app.page.controls import PICKER, TABS
from app.page.gizmos import NUDGE, swivel_frame
from app.page.keys import HOTKEYS
from app.page.relevance import matters
from app.session import Session
from app.settings import Settings
from scenes.history import COLUMN
from scenes.settings import changed, specs, values
from scenes.targets import HandTarget
from tests.app.conftest import ELBOW, HAND, OpenHouse, ask, live_sessions
from tests.app.page.helpers import another, bring_into_view, page_label
from tests.browser import (
    CAMERA,
    PageAt,
    close_software_note,
    point_at,
    screenshot,
    settled_view,
    take_hold,
    until,
    wait_frames,
    wait_ready,
    world_position,
)

SPECS = specs(Settings)
GIZMO, ARC = 0.22, 0.26 * 0.65
"""Length of the hand's arrows and radius of the elbow's arc [m]."""

GRIP = 0.85
"""Where an arrow is taken: beyond the ends of the arcs that turn the hand, which lie on it at 0.65."""

USUAL = {key: value for key, value in values(Settings()).items() if key != "picture"}
WRIST = "/base/j1/j2/j3/j4/j5/j6/j7"


# viser's browser side applies updates after all else that came with them, so it complains about the last one of a plot that goes.
LATE_UPDATE = r"Tried to update non-existent component"


def visit(page: Page, opened: House, query: str = "") -> Session:
    """Open a house's page; the session that it got."""
    before = set(live_sessions(opened))
    page.set_default_timeout(60_000)
    page.goto(f"{opened.url}/?{query}")
    wait_ready(page, HAND)
    # The page may have come anew, without the fine picture that this machine is too slow for.
    until(page, lambda: len(set(live_sessions(opened)) - before) == 1, "one session")
    close_software_note(page)
    (number,) = set(live_sessions(opened)) - before
    return live_sessions(opened)[number]


def chosen(session: Session) -> dict[str, Any]:
    """All settings but the one that the browser chooses for itself."""
    return {key: value for key, value in values(session.settings).items() if key != "picture"}


def hand(session: Session) -> np.ndarray:
    """Where the guided hand is."""
    return ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())


def run_on(page: Page, session: Session, seconds: float) -> None:
    """Return when so much more time has been simulated."""
    end = session.simulation.time + seconds
    until(page, lambda: session.simulation.time >= end, "simulated time")


def control(page: Page, key: str) -> Locator:
    """The control of a setting."""
    return page.locator("label").filter(has_text=re.compile(f"^{re.escape(page_label(key))}$")).locator("xpath=../../..")


def see_controls(page: Page, session: Session, keys: tuple[str, ...]) -> None:
    """Wait until of these controls, all on the tab in view, exactly those are seen that matter now."""
    settings, labels = session.settings, {page_label(key) for key in keys}
    expected = {page_label(key) for key in keys if matters(key, settings)}

    def as_expected() -> bool:
        return expected == labels & set(page.locator("label:visible").all_inner_texts())

    until(page, as_expected, f"just {sorted(expected)} of {sorted(labels)}")


def set_by_hand(page: Page, session: Session, key: str) -> None:
    """Change a setting as a person does, and wait until the server has it, and nothing else."""
    spec, before = SPECS[key], values(session.settings)
    place = control(page, key)
    sent, expected = another(key, before[key])
    if spec.choices:
        place.locator("input[role=combobox], input:visible").first.click()
        page.get_by_role("option", name=sent, exact=True).click()
    elif isinstance(expected, bool):
        place.locator("input[type=checkbox]").click(force=True)
    else:
        box = place.locator("input[type=text]").last
        box.fill(f"{sent:g}")
        box.press("Enter")
    until(page, lambda: values(session.settings)[key] == pytest.approx(expected, abs=1e-9), key)
    after = values(session.settings)
    assert {k for k in after if after[k] != before[k]} == {key}


def drag_through(page: Page, session: Session, points: list[np.ndarray]) -> None:
    """Take what is at the first point of the scene with the mouse, and pull it through the others."""
    take_hold(page, lambda: points[0], lambda: session.held is not None)
    for point in points[1:]:
        point_at(page, point)


def best_arrow(session: Session, toward: np.ndarray) -> tuple[np.ndarray, float]:
    """The hand's arrow that lies most along a direction, and whether it points there (1) or away (−1)."""
    rotation = ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).rotation.copy())
    along = toward @ rotation
    i = int(np.abs(along).argmax())
    return rotation[:, i], float(np.sign(along[i]))


# --- the handles ---------------------------------------------------------------------------------------------------------------


def test_a_mouse_takes_over_from_the_autopilot(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 760)
    # Slow, so that the arrow is still where the mouse goes.
    session = visit(page, house(), "speed=0.25&wmax=0.05")
    run_on(page, session, 0.1)
    assert session.settings.page.autopilot and session.held is None
    page.get_by_text("The autopilot moves the orange right arm").wait_for()
    arrow, sign = best_arrow(session, np.array([0.0, 1.0, 0.0]))
    before = session.simulation.time
    take_hold(page, lambda: hand(session) + arrow * GRIP * GIZMO, lambda: session.held is not None)
    grip = hand(session) + arrow * GRIP * GIZMO
    for way in np.linspace(0.02, 0.10, 4):
        point_at(page, grip + arrow * sign * way)
    page.mouse.up()
    until(page, lambda: session.held is None and not session.settings.page.autopilot, "letting go")
    assert session.simulation.time > before
    page.get_by_text("Drag the orange right arm").wait_for()
    # The control knows it, too.
    page.get_by_role("tab", name="Arms").click()
    assert not control(page, "autopilot").locator("input[type=checkbox]").is_checked()


def test_a_mouse_drags_the_hand_and_the_other_arm_yields(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 800)
    session = visit(page, house(), "autopilot=0&speed=2")
    start, other = (
        hand(session),
        ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.avoiding).translation.copy()),
    )
    still = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    arrow, sign = best_arrow(session, (other - start) / np.linalg.norm(other - start))
    grip = start + arrow * GRIP * GIZMO
    drag_through(page, session, [grip + arrow * sign * way for way in np.linspace(0.0, 0.45, 24)])
    goal = start + arrow * sign * 0.45
    until(page, lambda: np.linalg.norm(hand(session) - goal) < 0.02, "the hand where the mouse is")
    # Meanwhile the handle is where the mouse is, not where the hand is.
    assert np.linalg.norm(world_position(page, HAND) - goal) < 5e-3
    page.mouse.up()
    # Released: the handle jumps back to the hand, which stays where it came to.
    until(page, lambda: session.held is None, "release")
    run_on(page, session, 0.3)
    assert np.linalg.norm(hand(session) - goal) < 0.03
    until(page, lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3, "the handle on the hand")
    arm_node = world_position(page, f"/arms/right{WRIST}")
    assert np.linalg.norm(arm_node - ask(session, lambda s: s.simulation.kinematics.joint_point(14).copy())) < 2e-3
    table = ask(session, lambda s: s.simulation.history.table())
    q = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    limit = session.settings.run.law.critical_distance
    assert np.abs(q - still).max() > 0.03 and table[:, COLUMN["e2"]].max() > 0.01**2
    assert limit - 1e-4 <= table[:, COLUMN["d"]].min() < limit + 0.1
    # What is told of a second arm that keeps clear is not there, as only one does.
    first = COLUMN["e2_b"]
    assert np.isfinite(table[:, :first]).all() and np.isfinite(session.simulation.history.positions(table)).all()


def test_a_mouse_swivels_the_elbow(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house(), "autopilot=0&speed=2")

    def state(s: Session) -> tuple[np.ndarray, np.ndarray]:
        return swivel_frame(s.simulation)[0], s.simulation.kinematics.joint_point(s.simulation.guided.elbow).copy()

    (frame, elbow), place = ask(session, state), hand(session)
    out, across = (frame[:, 1] + frame[:, 2]) / np.sqrt(2.0), (frame[:, 2] - frame[:, 1]) / np.sqrt(2.0)
    ways = [elbow + ARC * (np.cos(a) * out + np.sin(a) * across) for a in np.linspace(0.0, 0.6, 13)]
    drag_through(page, session, ways)
    run_on(page, session, 3.0)
    assert isinstance(session.held, HandTarget) and session.held.elbow is not None
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the elbow")
    _, now = ask(session, state)
    assert np.linalg.norm(now - elbow) > 0.05
    assert np.linalg.norm(hand(session) - place) < 5e-3
    until(page, lambda: np.linalg.norm(world_position(page, ELBOW) - now) < 5e-3, "the handle on the elbow")


# --- controls ------------------------------------------------------------------------------------------------------------------


TAB_KEYS = {name: keys for name, _, keys in TABS}


def test_every_control_of_the_law_by_hand(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house(), "autopilot=0")
    keys = TAB_KEYS["Law"]
    page.get_by_role("tab", name="Law").click()
    for key in keys:
        bring_into_view(session, key)
        see_controls(page, session, keys)
        set_by_hand(page, session, key)
        see_controls(page, session, keys)
    ask(session, lambda s: s.change("law", "smooth_priority"))
    control(page, "v").wait_for()
    # A slider's thumb by its keys, and by the mouse.
    thumb = control(page, "dm").get_by_role("slider")
    before = session.settings.run.law.critical_distance
    thumb.focus()
    page.keyboard.press("ArrowRight")
    until(page, lambda: session.settings.run.law.critical_distance == pytest.approx(before + 0.005), "the thumb")
    track = control(page, "n").locator(".mantine-Slider-root").bounding_box()
    assert track is not None
    page.mouse.click(track["x"] + 0.75 * track["width"], track["y"] + track["height"] / 2)
    until(page, lambda: abs(session.settings.run.law.order - 15.25) < 1.0, "the track")
    # A number that is impossible stays on the page.
    settings, box = session.settings, control(page, "dm").locator("input[type=text]").last
    box.fill("9999")
    box.press("Enter")
    box.fill("nan")
    box.press("Tab")
    control(page, "v").locator("input[type=text]").last.fill("0.5")
    until(page, lambda: session.settings.run.law.nominal_velocity == 0.5, "v")
    assert 0.03 <= session.settings.run.law.critical_distance <= 0.30
    assert settings.run.law.order == session.settings.run.law.order

    # What is compared with it.
    keys = TAB_KEYS["Compare"]
    page.get_by_role("tab", name="Compare").click()
    for key in keys:
        bring_into_view(session, key)
        see_controls(page, session, keys)
        set_by_hand(page, session, key)
    page.locator(".duet-tiles small").nth(3).wait_for()
    page.locator(".duet-caption").get_by_text("ghost", exact=True).first.wait_for()
    page.get_by_role("button", name="Measure", exact=True).click()
    page.get_by_text("Largest step of q̇").wait_for()
    page.get_by_role("tab", name="Law").click()
    control(page, "dm").locator("input[type=text]").last.fill("200")
    page.get_by_role("tab", name="Compare").click()
    page.get_by_text("as it was", exact=True).wait_for()
    page.get_by_text("With dm = 200 mm.").wait_for()


def test_every_other_control_by_hand(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house())
    ask(session, lambda s: s.toggle_pause())
    control(page, "rig").wait_for()
    see_controls(page, session, PICKER)
    # The experiment last, so that the others are tried in the usual one.
    for key in reversed(PICKER):
        set_by_hand(page, session, key)
        see_controls(page, session, PICKER)
        if key == "rig":
            wait_ready(page, "/room")
            until(page, lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3, "the handle at the table")
            assert session.simulation.room.rig.name == "table"
    keys = TAB_KEYS["Arms"]
    page.get_by_role("tab", name="Arms").click()
    for key in keys:
        bring_into_view(session, key)
        see_controls(page, session, keys)
        set_by_hand(page, session, key)
        see_controls(page, session, keys)
    # The left arm is yours now, and has the handle.
    assert session.simulation.settings.scene == "hold" and session.simulation.guided.name == "left"
    until(page, lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3, "the handle on the left hand")
    ask(session, lambda s: s.toggle_pause())
    keys = TAB_KEYS["View"]
    page.get_by_role("tab", name="View").click()
    see_controls(page, session, keys)
    for key in ("theme", "profile"):
        set_by_hand(page, session, key)
    page.wait_for_function("document.documentElement.dataset.mantineColorScheme === 'dark'")
    page.wait_for_function("getComputedStyle(document.documentElement).getPropertyValue('--duet-k').trim() === '1.3'")
    see_plots(page, ("distance d [m]", "error e² [m²]"))
    for box in page.locator("[data-testid=floating-panel], [data-floating-window]").all():
        place = box.bounding_box()
        assert place is not None and place["x"] >= -1 and place["x"] + place["width"] <= 901
    screenshot(page, "page-900-dark-projector")
    # Last, as shadows take a machine without a graphics card seconds.
    for key in set(keys) - {"theme", "profile"}:
        set_by_hand(page, session, key)


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
    """Wait until these plots, and no others, stand side by side over the whole of their panel, with something drawn in each.

    Args:
        titles: by their beginnings.
    """
    seen: list[dict[str, Any]] = []

    def as_expected() -> bool:
        seen[:] = page.evaluate(PLOTS)
        as_named = len(seen) == len(titles) and all(p["title"].startswith(t) for p, t in zip(seen, titles, strict=True))
        fair = all(p["drawn"] and p["high"] > 60 and p["wide"] > 0.2 for p in seen) and sum(p["wide"] for p in seen) > 0.9
        return as_named and fair and len({p["top"] for p in seen}) == 1

    try:
        until(page, as_expected)
    except AssertionError:
        pytest.fail(f"{titles} expected, seen {seen}")


TITLES = {
    "λ": "activation λ",
    "q": "joints q [°]",
    "q̇": "joint speeds q̇ [°/s]",
    "u v w": "speeds along the line [m/s]",
    "λ(d)": "Fig. 2",
    "Laws": "what each law",
    "Pairs": "the closest pair",
    "M": "section III",
}
"""What stands on a button → the beginning of the plot's title; the first four are over time."""


def test_tabs_plots_and_the_picture_at_rest(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house())
    shows = {"Law": "d_m [mm]", "Arms": "w_max [m/s]", "Compare": "what if", "View": "colours", "Keys": "one single step"}
    for name in ("Arms", "Compare", "View", "Keys", "Law"):
        page.get_by_role("tab", name=name).click()
        for tab, text in shows.items():
            shown = page.get_by_text(text, exact=True)
            shown.wait_for(state="visible" if tab == name else "hidden")
        if name == "Keys":
            for hotkey in HOTKEYS:
                keyed = page.locator("tr").filter(has=page.locator(f'kbd:text-is("{hotkey.shown}")'))
                assert keyed.filter(has=page.get_by_text(hotkey.text, exact=True)).count() == 1

    def press(label: str) -> None:
        page.get_by_role("button", name=label, exact=True).click()
        page.get_by_role("button", name=f"● {label}", exact=True).wait_for()

    # Every plot. A chart needs room, which the squared error makes for it in a narrow window.
    distance, error = "distance d [m]", "error e² [m²]"
    row = page.locator("[data-floating-window] .mantine-Flex-root .mantine-Button-root")
    offered = [text.removeprefix(MARK) for text in row.all_inner_texts()]
    assert offered[0] == "None" and set(TITLES) <= set(offered[1:])
    for label in offered[1:]:
        press(label)
        over_time = label in list(TITLES)[:4]
        see_plots(page, (distance, *([error] if over_time else []), TITLES.get(label, "")))
    press("Laws")
    page.set_viewport_size({"width": 1240, "height": 640})
    see_plots(page, (distance, error, TITLES["Laws"]))
    page.set_viewport_size({"width": 900, "height": 640})
    press("None")
    see_plots(page, (distance, error))
    for label, speed in (("¼×", 0.25), ("½×", 0.5), ("2×", 2.0), ("1×", 1.0)):
        press(label)
        assert session.settings.page.speed == speed
    # Pause by the button: the picture comes to rest and stays so, to the last pixel. And it moves again afterwards.
    press("Pause")
    page.get_by_text("paused", exact=True).wait_for()
    page.mouse.move(20, 20)
    # A note may come late on a busy machine, and covers what is looked at.
    page.add_style_tag(content="[class*=Notification-root] { display: none !important }")
    settled_view(page, 10)
    corner = {"x": 0, "y": 60, "width": 540, "height": 250}
    pictures: list[bytes] = []

    def at_rest() -> bool:
        pictures.append(page.screenshot(clip=corner, animations="disabled"))  # type: ignore[arg-type]
        wait_frames(page, 20)
        return len(pictures) > 2 and pictures[-1] == pictures[-2] == pictures[-3]

    until(page, at_rest, "a picture at rest")
    steps, first = session.simulation.steps, pictures[-1]
    wait_frames(page, 20)
    assert page.screenshot(clip=corner, animations="disabled") == first  # type: ignore[arg-type]
    assert session.simulation.steps == steps
    page.get_by_role("button", name="Step", exact=True).click()
    until(page, lambda: session.simulation.steps == steps + 1, "one step")
    page.get_by_role("button", name="● Pause", exact=True).click()
    until(page, lambda: page.screenshot(clip=corner, animations="disabled") != first, "a moving picture")  # type: ignore[arg-type]
    page.get_by_role("button", name="Reset", exact=True).click()
    until(page, lambda: session.simulation.steps < steps, "a fresh start")
    # Plots of other experiments.
    ask(session, lambda s: s.change("scene", "master_slave"))
    press("q₁–q₄")
    see_plots(page, (distance, "error", "q, slave [°]"))
    ask(session, lambda s: s.change("scene", "solo"))
    page.get_by_role("button", name="● None", exact=True).wait_for()
    see_plots(page, ("hand error |e| [mm]", "elbow angle"))


# --- keys ----------------------------------------------------------------------------------------------------------------------


REST = """ms => new Promise(done => {
  const drawn = __viserTestpoints.rendererInfo.render, first = drawn.frame, begin = performance.now();
  setTimeout(() => done([drawn.frame - first, performance.now() - begin]), ms);
})"""
"""How many pictures are drawn in so much time, and how much it was [ms]."""

MOVED = """() => new Promise(done => {
  const drawn = __viserTestpoints.rendererInfo.render, pictures = [], begin = performance.now(), all = __viserMutable.nodeRefFromName;
  const joints = Object.keys(all).filter(name => /^.arms.*j[1-7]$/.test(name));
  const place = () => joints.flatMap(name => all[name].quaternion.toArray()).join();
  const first = place();
  let moved = -1;
  const look = () => {
    pictures.push(drawn.frame);
    if (moved < 0 && place() !== first) moved = pictures.length - 1;
    if (moved > 0 && pictures.length > moved + 4 || performance.now() - begin > 60000) done([moved, pictures]);
    else requestAnimationFrame(look);
  };
  look();
})"""
"""The number of the beat of the screen at which a joint has moved, and how many pictures had been drawn at every beat."""


def test_without_a_graphics_card_a_picture_is_drawn_for_a_change_alone(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(700, 500)
    session = visit(page, house())
    # While the arms move there is a picture for every one of their changes.
    drawn, passed = page.evaluate(REST, 2000)
    assert drawn > passed / 1000 + 2
    ask(session, lambda s: s.toggle_pause())
    page.get_by_text("paused", exact=True).wait_for()
    settled_view(page, 10)

    def at_rest() -> bool:
        drawn, passed = page.evaluate(REST, 2000)
        # viser draws one a second, come what may.
        return drawn <= passed // 1000 + 1

    until(page, at_rest, "a page that draws nothing but its heartbeat")
    # One step of the arms is drawn in the beat in which it comes or in the next one.
    page.evaluate("() => { window.moved = (" + MOVED + ")() }")
    ask(session, lambda s: [s.single_step() for _ in range(40)])
    beat, pictures = page.evaluate("() => window.moved")
    assert beat > 0, "nothing has moved"
    assert pictures[beat + 2] > pictures[beat - 1]


def test_every_key_on_the_canvas_and_none_in_an_input(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house())
    page.mouse.click(520, 90)
    view, done = settled_view(page), set[str]()

    def press(action: str, key: str, effect: Callable[[], object]) -> None:
        done.add(action)
        # Held for some frames, as a finger does.
        page.keyboard.down(key)
        wait_frames(page, 4)
        page.keyboard.up(key)
        until(page, effect, f"the key {key}")
        if action not in ("view", *SPECS["scene"].choices):
            assert np.allclose(page.evaluate(CAMERA), view, atol=2e-3), f"{key} moves the camera"

    def paused() -> bool:
        return session.paused

    def driven() -> bool:
        return session.settings.page.autopilot

    press("pause", " ", paused)
    steps = ask(session, lambda s: s.simulation.steps)
    press("step", ".", lambda: session.simulation.steps == steps + 1)
    press("slower", "[", lambda: session.settings.page.speed == 0.5)
    press("faster", "]", lambda: session.settings.page.speed == 1.0)
    press("law", "l", lambda: session.settings.run.law.law == "unprotected")
    press("law", "l", lambda: session.settings.run.law.law == "smooth_priority")
    press("autopilot", "a", lambda: not driven())
    press("autopilot", "a", driven)
    place = hand(session)
    ways = {
        ("left", "ArrowLeft"): (0, -1, 0),
        ("right", "ArrowRight"): (0, 1, 0),
        ("up", "ArrowUp"): (0, 0, 1),
        ("down", "ArrowDown"): (0, 0, -1),
        ("away", "PageUp"): (-1, 0, 0),
        ("near", "PageDown"): (1, 0, 0),
    }
    for (action, key), way in ways.items():
        press(
            action,
            key,
            lambda place=place: (
                isinstance(session.held, HandTarget) and np.linalg.norm(session.held.position - place) > NUDGE / 2
            ),
        )
        held = session.held
        assert isinstance(held, HandTarget) and np.linalg.norm(held.position - place) == pytest.approx(NUDGE, rel=1e-6)
        assert (held.position - place) @ np.array(way) > 0.85 * NUDGE, action
        place = held.position.copy()
    assert not driven()

    def elbow() -> np.ndarray | None:
        return session.held.elbow if isinstance(session.held, HandTarget) else None

    press("elbow_up", "j", lambda: elbow() is not None)
    swung = elbow()
    assert swung is not None
    press("elbow_down", "k", lambda: not np.allclose(elbow() if elbow() is not None else swung, swung, atol=1e-4))
    press("reset", "r", lambda: session.simulation.steps == 0)
    assert session.paused

    # Turn the view with the mouse, and take it back.
    page.mouse.move(520, 90)
    page.mouse.down()
    for i in range(6):
        page.mouse.move(520 - 25 * i, 90 + 5 * i)
        wait_frames(page, 2)
    page.mouse.up()
    until(page, lambda: not np.allclose(page.evaluate(CAMERA), view, atol=0.05), "a turned view")
    press("view", "v", lambda: np.allclose(page.evaluate(CAMERA), view, atol=2e-3))
    press("ghost", "g", lambda: session.ghost is not None)
    press("ghost", "g", lambda: session.ghost is None)
    # Another scene is seen from elsewhere; the one from before is seen as before.
    scenes = dict(zip(SPECS["scene"].choices, "12345", strict=True))
    for scene in (*scenes, "hold"):
        page.keyboard.press(scenes[scene])
        until(page, lambda scene=scene: session.simulation.settings.scene == scene, scene)
        done.add(scene)
    until(page, lambda: np.allclose(page.evaluate(CAMERA), view, atol=2e-3), "the first view")
    assert done == {hotkey.action for hotkey in HOTKEYS}

    # In an input they are letters and moves of the caret.
    box = control(page, "dm").locator("input[type=text]").last
    before = ask(session, lambda s: (s.settings, s.paused, s.held, s.simulation.steps))
    box.click()
    for key in (" ", ".", "[", "]", "r", "a", "l", "v", "g", "1", "4", "PageUp", "ArrowLeft", "ArrowRight"):
        page.keyboard.press(key)
        wait_frames(page, 2)
    box.fill("120")
    box.press("Enter")
    until(page, lambda: session.settings.run.law.critical_distance == pytest.approx(0.12), "d_m")
    settings, *rest = ask(session, lambda s: (s.settings, s.paused, s.held, s.simulation.steps))
    assert rest == list(before[1:])
    assert {k: v for k, v in values(settings).items() if k != "dm"} == {k: v for k, v in values(before[0]).items() if k != "dm"}
    page.mouse.click(520, 90)
    page.keyboard.press(" ")
    until(page, lambda: not session.paused, "going on")


# --- who sees what -------------------------------------------------------------------------------------------------------------


def test_a_second_tab_is_private_and_a_link_sets_it(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    one = page_at(900, 640)
    first = visit(one, opened, "autopilot=0")
    other = page_at(900, 640)
    alerts: list[str] = []

    def dismiss(dialog: Dialog) -> None:
        alerts.append(dialog.message)
        dialog.dismiss()

    other.on("dialog", dismiss)
    bad = "law=%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E"
    second = visit(other, opened, f"rig=table&dm=0.1&n=10&theme=dark&plot=lambda&{bad}")
    expected = {"rig": "table", "dm": 0.1, "n": 10.0, "theme": "dark", "plot": "lambda"}
    assert chosen(second) == USUAL | expected
    # What could not be done is named, as plain text.
    other.get_by_text("law = '<img src=x onerror=alert(1)>'").wait_for()
    assert other.locator("img[src=x]").count() == 0 and alerts == []
    other.wait_for_function("document.documentElement.dataset.mantineColorScheme === 'dark'")
    assert control(other, "dm").locator("input[type=text]").last.input_value() == "100"
    assert control(other, "n").locator("input[type=text]").last.input_value() == "10"
    see_plots(other, ("distance", "error", "activation λ"))
    # Neither sees the other.
    assert chosen(first) == USUAL | {"autopilot": False}
    assert one.evaluate("document.documentElement.dataset.mantineColorScheme") == "light"
    set_by_hand(one, first, "v")
    assert second.settings.run.law.nominal_velocity == 0.30
    assert not np.allclose(world_position(one, f"/arms/left{WRIST}"), world_position(other, f"/arms/left{WRIST}"), atol=0.05)
    other.close()
    until(one, lambda: len(live_sessions(opened)) == 1, "the session of the closed tab")
    run_on(one, first, 0.1)


def test_a_lecture_in_two_tabs(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(changed(Settings(), "picture", "fast"), lecture=True)
    assert isinstance(opened.host, LectureHost)
    session = opened.host.session
    lecturer, listener = page_at(900, 640), page_at(900, 640)
    lecturer.goto(opened.url)
    wait_ready(lecturer, HAND)
    listener.goto(opened.url)
    wait_ready(listener, f"/arms/right{WRIST}")
    see_plots(listener, ("distance", "error"))
    listener.get_by_text("real time").wait_for()
    lecturer.mouse.click(520, 90)
    lecturer.keyboard.press(" ")
    until(lecturer, lambda: session.paused, "a pause")
    listener.get_by_text("paused", exact=True).wait_for()
    for side, joint in (("left", 7), ("right", 14)):
        place = ask(session, lambda s, joint=joint: s.simulation.kinematics.joint_point(joint).copy())
        for page in (lecturer, listener):
            until(page, lambda p=page, s=side, x=place: np.allclose(world_position(p, f"/arms/{s}{WRIST}"), x, atol=1e-3), side)
    assert lecturer.get_by_role("tab", name="Arms").count() == 1 and control(lecturer, "dm").count() == 1
    assert listener.get_by_role("tab", name="Arms").count() == 0 and control(listener, "dm").count() == 0
    assert listener.get_by_role("button", name="Pause").count() == 0
    assert not listener.evaluate(f"!!__viserMutable.nodeRefFromName['{HAND}']")
    # The listener's keys do nothing; the lecturer's do.
    steps = session.simulation.steps
    listener.mouse.click(520, 90)
    for key in (" ", "r", ".", "l", "1"):
        listener.keyboard.press(key)
        wait_frames(listener, 3)
    lecturer.keyboard.press("[")
    until(lecturer, lambda: session.settings.page.speed == 0.5, "slower")
    assert session.paused and session.simulation.steps == steps and session.settings.run == Settings().run
    # The lecturer leaves, and the listener has the controls.
    lecturer.close()
    wait_ready(listener, HAND)
    control(listener, "dm").wait_for()
    listener.keyboard.press(" ")
    until(listener, lambda: not session.paused, "going on")


# --- looks -----------------------------------------------------------------------------------------------------------------------

FREE = """names => names.map(name => {
  const { camera, nodeRefFromName, canvas } = __viserMutable, box = canvas.getBoundingClientRect(), node = nodeRefFromName[name];
  if (!node) return name + ' is not there';
  const v = camera.position.clone(); node.updateWorldMatrix(true, false); node.getWorldPosition(v); v.project(camera);
  const x = box.left + (1 + v.x) / 2 * box.width, y = box.top + (1 - v.y) / 2 * box.height;
  const top = document.elementFromPoint(x, y);
  return top === canvas ? '' : `${name} at ${x.toFixed(0)}, ${y.toFixed(0)} is under ${top && top.outerHTML.slice(0, 90)}`;
}).filter(text => text)"""

CUT = """() => {
  const wrong = [], wide = innerWidth, high = innerHeight;
  for (const part of document.querySelectorAll('[data-testid=floating-panel], [data-floating-window]')) {
    const b = part.getBoundingClientRect();
    if (b.width && (b.left < -1 || b.top < -1 || b.right > wide + 1 || b.bottom > high + 1))
      wrong.push(`panel ${part.dataset.testid ?? 'plots'} ${[b.left, b.top, b.right, b.bottom].map(Math.round)} of ${wide}×${high}`);
  }
  for (const part of document.querySelectorAll('.duet, .duet *, .duet-caption, .duet-caption *')) {
    if (part.closest('svg') || !part.clientWidth) continue;
    if (part.scrollWidth > part.clientWidth + 1)
      wrong.push(`${part.className} “${part.textContent.slice(0, 60)}” ${part.scrollWidth} > ${part.clientWidth}`);
  }
  if (document.documentElement.scrollWidth > wide + 1) wrong.push('the page itself is too wide');
  return wrong;
}"""

LINKS = [f"/arms/{side}/base" + "".join(f"/j{i}" for i in range(1, n + 1)) for side in ("left", "right") for n in range(8)]


@pytest.mark.parametrize(
    ("width", "height", "rigs"),
    [(1440, 900, ("torso", "table")), (1024, 768, ("table", "torso")), (390, 844, ("torso", "table"))],
)
def test_first_sight(house: OpenHouse, page_at: PageAt, width: int, height: int, rigs: tuple[str, ...]) -> None:
    """Of one rig when the page opens, and of the other when it is chosen."""
    page = page_at(width, height)
    session = visit(page, house(), f"rig={rigs[0]}&speed=2")
    if width > 576:
        see_plots(page, ("distance", "error"))
    close_software_note(page)
    for rig in rigs:
        ask(session, lambda s, rig=rig: s.change("rig", rig))
        hidden: list[str] = []

        def free(hidden: list[str] = hidden) -> bool:
            hidden[:] = page.evaluate(FREE, LINKS)
            return not hidden

        # The view is corrected once the panels have found their places.
        try:
            until(page, free, "both arms in free sight", 30.0)
        except AssertionError:
            pytest.fail(f"{rig}: " + "\n".join(hidden))
        # On its way back the hand moves away from the other arm: the numbers are longest then.
        until(page, lambda: session.simulation.time > 3.0 and session.simulation.sample().law_approach < -0.02, "a retreat", 60.0)
        ask(session, lambda s: s.toggle_pause())
        page.get_by_text("paused", exact=True).wait_for()
        faults: dict[str, list[str]] = {}
        for theme in ("light", "dark"):
            ask(session, lambda s, theme=theme: s.change("theme", theme))
            page.wait_for_function("theme => document.documentElement.dataset.mantineColorScheme === theme", arg=theme)
            wait_frames(page, 6)
            screenshot(page, f"page-{width}-{rig}-{theme}")
            faults[theme] = page.evaluate(CUT)
        assert faults == {"light": [], "dark": []}, rig
        assert page.evaluate(FREE, LINKS) == [], rig
        ask(session, lambda s: s.toggle_pause())
