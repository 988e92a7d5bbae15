"""Tabs and plots in a real browser, and a picture that is drawn for a change alone."""

import pytest

from app.page.panels.choice_buttons import MARK
from app.page.panels.hotkeys import hotkeys
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import see_plots, visit
from tests.browser import PageAt, drawn, settled_view, until, wait_frames

TIMES = {
    "λ": "activation λ",
    "q": "joints q [°]",
    "q̇": "joint speeds q̇ [rad/s]",
    "u v w": "speeds along the line [m/s]",
}
"""What stands on a button → the beginning of the plot's title, over time."""

TITLES = TIMES | {"λ(d)": "Fig. 2", "Laws": "each law", "Pairs": "the closest pair", "M": "section III"}


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


@pytest.mark.thorough
def test_tabs_plots_and_the_picture_at_rest(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house())
    shows = {
        "Law": "critical distance d_m [mm]",
        "Arms": "speed limit w_max [m/s]",
        "Compare": "what if",
        "View": "colours",
        "Keys": "one single step",
    }
    for name in ("Arms", "Compare", "View", "Keys", "Law"):
        page.get_by_role("tab", name=name).click()
        for tab, text in shows.items():
            shown = page.get_by_text(text, exact=True)
            shown.wait_for(state="visible" if tab == name else "hidden")
        if name == "Keys":
            for hotkey in hotkeys():
                keyed = page.locator("tr").filter(has=page.locator(f'kbd:text-is("{hotkey.shown}")'))
                assert keyed.filter(has=page.get_by_text(hotkey.text, exact=True)).count() == 1

    def press(label: str) -> None:
        page.get_by_role("button", name=label, exact=True).click()
        page.get_by_role("button", name=f"● {label}", exact=True).wait_for()

    def moves() -> bool:
        drawn, passed = page.evaluate(REST, 2000)
        return drawn > passed / 1000 + 2

    # Every plot. A chart needs room, which the squared error makes for it in a narrow window.
    distance, error = "distance d [m]", "error e² [m²]"
    row = page.locator("[data-floating-window] .mantine-Flex-root .mantine-Button-root")
    offered = [text.removeprefix(MARK) for text in row.all_inner_texts()]
    assert offered[0] == "None" and set(TITLES) <= set(offered[1:])
    for label in offered[1:]:
        press(label)
        see_plots(page, (distance, *([error] if label in TIMES else []), TITLES.get(label, "")))
    press("Laws")
    page.set_viewport_size({"width": 1240, "height": 640})
    see_plots(page, (distance, error, TITLES["Laws"]))
    page.set_viewport_size({"width": 900, "height": 640})
    press("None")
    see_plots(page, (distance, error))
    for label, speed in (("¼×", 0.25), ("½×", 0.5), ("2×", 2.0), ("1×", 1.0)):
        press(label)
        assert session.settings.page.speed == speed
    # While the arms move there is a picture for every one of their changes, though there is no graphics card.
    until(page, moves, "more pictures than its heartbeat")
    # Pause by the button: the picture comes to rest and stays so, to the last pixel. And it moves again afterwards.
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_text("paused", exact=True).wait_for()
    page.mouse.move(20, 20)
    # A note may come late on a busy machine, and covers what is looked at.
    page.add_style_tag(content="[class*=Notification-root] { display: none !important }")
    settled_view(page, 10)

    def heartbeat() -> bool:
        drawn, passed = page.evaluate(REST, 2000)
        # viser draws one a second, come what may.
        return drawn <= passed // 1000 + 1

    until(page, heartbeat, "a page that draws nothing but its heartbeat")
    # One step of the arms is drawn in the beat in which it comes or in the next one.
    page.evaluate("() => { window.moved = (" + MOVED + ")() }")
    ask(session, lambda s: [s.control.single_step() for _ in range(40)])
    beat, counts = page.evaluate("() => window.moved")
    assert beat > 0, "nothing has moved"
    assert counts[beat + 2] > counts[beat - 1]
    pictures: list[bytes] = []

    def corner() -> bytes:
        return page.screenshot(clip={"x": 0, "y": 60, "width": 540, "height": 250}, animations="disabled")

    def at_rest() -> bool:
        pictures.append(corner())
        wait_frames(page, 20)
        return len(pictures) > 2 and pictures[-1] == pictures[-2] == pictures[-3]

    with drawn(page):
        until(page, at_rest, "a picture at rest", 180.0)
        steps, first = session.simulation.steps, pictures[-1]
        wait_frames(page, 20)
        assert corner() == first
        assert session.simulation.steps == steps
        page.get_by_role("button", name="Step", exact=True).click()
        until(page, lambda: session.simulation.steps == steps + 1, "one step")
        page.get_by_role("button", name="Go on", exact=True).click()
        until(page, lambda: corner() != first, "a moving picture")
    page.get_by_role("button", name="Reset", exact=True).click()
    until(page, lambda: session.simulation.steps < steps, "a fresh start")
    # Plots of other experiments.
    ask(session, lambda s: s.change("scene", "master_slave"))
    press("q₁–q₄")
    see_plots(page, (distance, "error", "q, slave [°]"))
    ask(session, lambda s: s.change("scene", "solo"))
    page.get_by_role("button", name="● None", exact=True).wait_for()
    see_plots(page, ("hand error |e| [mm]", "elbow angle"))
