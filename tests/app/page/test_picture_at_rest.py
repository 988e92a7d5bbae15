"""Tabs and plots in a real browser, and a picture that is drawn only after a change."""

import pytest
from playwright.sync_api import Page

from app.page.panels.choice_buttons import MARK
from app.page.panels.hotkeys import hotkeys
from tests.app.conftest import ask
from tests.app.page.by_hand import see_plots
from tests.app.page.shared_page import Shared, SharedPage
from tests.browser import drawn, settled_view, until, wait_frames

pytestmark = pytest.mark.thorough

SHARED = SharedPage(900, 640)
TABS = {
    "Law": "critical distance d_m [mm]",
    "Arms": "speed limit w_max [m/s]",
    "Compare": "what if",
    "View": "colours",
    "Keys": "one single step",
}
"""Name of a tab → a text that is only on this tab."""

DISTANCE, ERROR = "distance d [m]", "error e² [m²]"

TIMES = {
    "λ": "activation λ",
    "q": "joints q [°]",
    "q̇": "joint speeds q̇ [rad/s]",
    "u v w": "speeds along the line [m/s]",
}
"""Label of a button → beginning of the title of its plot over time."""

TITLES = TIMES | {"λ(d)": "Fig. 2", "Laws": "each law", "Pairs": "the closest pair", "M": "section III"}


REST = """ms => new Promise(done => {
  const drawn = __viserTestpoints.rendererInfo.render, first = drawn.frame, begin = performance.now();
  setTimeout(() => done([drawn.frame - first, performance.now() - begin]), ms);
})"""
"""Number of pictures drawn in `ms`, and the measured time [ms]."""

MOVED = """() => new Promise(done => {
  const drawn = __viserTestpoints.rendererInfo.render, pictures = [], begin = performance.now(), all = __viserMutable.nodeRefFromName;
  const joints = Object.keys(all).filter(name => all[name] && /^.arms.*j[1-7]$/.test(name));
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
"""Index of the screen refresh at which a joint had moved, and the picture count at each refresh."""


def press(page: Page, label: str) -> None:
    """Press a button of a group, and wait until it is the chosen one."""
    page.get_by_role("button", name=MARK + label, exact=True).or_(
        page.get_by_role("button", name=label, exact=True)
    ).click()
    page.get_by_role("button", name=MARK + label, exact=True).wait_for()


def pause(page: Page) -> None:
    """Pause by the button, and move the mouse to a place without effect."""
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_text("paused", exact=True).wait_for()
    page.mouse.move(20, 20)


def is_moving(page: Page) -> bool:
    pictures, passed = page.evaluate(REST, 2000)
    return pictures > passed / 1000 + 2


def is_still(page: Page) -> bool:
    pictures, passed = page.evaluate(REST, 2000)
    # viser always draws one a second.
    return pictures <= passed // 1000 + 1


def test_a_tab_shows_only_its_own_contents(shared: Shared) -> None:
    page = shared.page
    for name in ("Arms", "Compare", "View", "Keys", "Law"):
        page.get_by_role("tab", name=name).click()
        for tab, text in TABS.items():
            shown = page.get_by_text(text, exact=True)
            shown.wait_for(state="visible" if tab == name else "hidden")


def test_the_tab_of_keys_has_a_row_for_each(shared: Shared) -> None:
    page = shared.page
    page.get_by_role("tab", name="Keys").click()
    page.get_by_text(TABS["Keys"], exact=True).wait_for()
    for hotkey in hotkeys():
        keyed = page.locator("tr").filter(has=page.locator(f'kbd:text-is("{hotkey.shown}")'))
        assert keyed.filter(has=page.get_by_text(hotkey.text, exact=True)).count() == 1


def test_every_plot_is_drawn_next_to_the_distance(shared: Shared) -> None:
    """In a narrow window a chart takes the place of the squared error."""
    page = shared.page
    row = page.locator("[data-floating-window] .mantine-Flex-root .mantine-Button-root")
    offered = [text.removeprefix(MARK) for text in row.all_inner_texts()]
    assert offered[0] == "None" and set(TITLES) <= set(offered[1:])
    for label in offered[1:]:
        press(page, label)
        see_plots(page, (DISTANCE, *([ERROR] if label in TIMES else []), TITLES.get(label, "")))
    press(page, "Laws")
    page.set_viewport_size({"width": 1240, "height": 640})
    see_plots(page, (DISTANCE, ERROR, TITLES["Laws"]))
    page.set_viewport_size({"width": 900, "height": 640})
    press(page, "None")
    see_plots(page, (DISTANCE, ERROR))


def test_other_experiments_have_other_plots(shared: Shared) -> None:
    page = shared.page
    ask(shared.session, lambda s: s.change("scene", "master_slave"))
    press(page, "q₁–q₄")
    see_plots(page, (DISTANCE, "error", "q, slave [°]"))
    ask(shared.session, lambda s: s.change("scene", "solo"))
    page.get_by_role("button", name=f"{MARK}None", exact=True).wait_for()
    see_plots(page, ("hand error |e| [mm]", "elbow angle"))


def test_a_button_chooses_the_speed(shared: Shared) -> None:
    for label, speed in (("¼×", 0.25), ("½×", 0.5), ("2×", 2.0), ("1×", 1.0)):
        press(shared.page, label)
        assert shared.session.settings.page.speed == speed


def test_many_pictures_are_drawn_while_arms_move_and_few_at_rest(shared: Shared) -> None:
    """Without a graphics card, too, moving arms are drawn more often than viser's heartbeat."""
    page = shared.page
    until(page, lambda: is_moving(page), "more pictures than its heartbeat")
    pause(page)
    settled_view(page, 10)
    until(page, lambda: is_still(page), "a page that draws nothing but its heartbeat")


def test_steps_are_drawn_at_once(shared: Shared) -> None:
    """At the screen refresh of their arrival, or at the next one."""
    page = shared.page
    pause(page)
    settled_view(page, 10)
    until(page, lambda: is_still(page), "a page that draws nothing but its heartbeat")
    page.evaluate("() => { window.moved = (" + MOVED + ")() }")
    ask(shared.session, lambda s: [s.control.single_step() for _ in range(40)])
    beat, counts = page.evaluate("() => window.moved")
    assert beat > 0, "nothing has moved"
    assert counts[beat + 2] > counts[beat - 1]


def test_a_paused_picture_does_not_change_a_pixel_and_moves_again_later(shared: Shared) -> None:
    page, session = shared.page, shared.session
    # On a busy machine a late note could cover the compared part.
    page.add_style_tag(content="[class*=Notification-root] { display: none !important }")
    pause(page)
    settled_view(page, 10)
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
        page.get_by_role("button", name="Continue", exact=True).click()
        until(page, lambda: corner() != first, "a moving picture")
    page.get_by_role("button", name="Reset", exact=True).click()
    until(page, lambda: session.simulation.steps < steps, "a fresh start")
