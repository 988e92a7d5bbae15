"""The first screen: its content, its limits, and its controls."""

import pytest
from playwright.sync_api import Page, expect

from app.page.panels.controls import SMALL
from app.page.panels.law_choice import MORE
from scenes.laws import LAWS
from tests.accessibility import accessible
from tests.app.conftest import Arrive, OpenHouse, ask
from tests.app.page.by_hand import visit
from tests.app.page.helpers import Client, bodies, page_label, press
from tests.browser import CAMERA, PageAt, lasting, screenshot, settled_view, until
from tests.tools.page_flaws import flaws

MOST_CONTROLS, MOST_WORDS = 20, 80

SEEN = """() => {
  const seen = element => element.checkVisibility({ opacityProperty: true, visibilityProperty: true })
    && element.getBoundingClientRect().width > 2;
  const kinds = 'button, [role=button], a[href], input, select, textarea, [role=slider]';
  const name = one => one.getAttribute('aria-label') || one.textContent.trim() || one.value || one.outerHTML.slice(0, 80);
  return {
    controls: [...document.querySelectorAll(kinds)].filter(one => seen(one) && !one.ariaHidden)
      .map(name),
    words: document.body.innerText.split(/\\s+/).filter(word => /\\p{L}/u.test(word)),
  };
}"""
"""Names of all visible controls (a slider and its number box are two), and all words with a letter."""


def groups(visitor: Client) -> list[tuple[str, ...]]:
    return [tuple(group["options"]) for group in bodies(visitor, "GuiButtonGroupMessage")]


def law_options(visitor: Client) -> list[str]:
    (options,) = (box["options"] for box in bodies(visitor, "GuiDropdownMessage") if box["label"] == "law")
    return list(options)


def test_the_small_panel_has_four_sliders_the_clock_and_four_laws(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "panel=small")
    visitor = guest.visitor
    assert {"dm", "n", "v", "k", "law"} < set(SMALL)
    sliders = {str(slider["label"]) for slider in bodies(visitor, "GuiSliderMessage")}
    assert sliders == {page_label(key) for key in ("dm", "n", "v", "k")}
    assert {("Pause", "Reset"), ("More plots",), ("All settings",)} <= set(groups(visitor))
    press(guest, "pause")
    visitor.wait_for(lambda v: ("Continue", "Reset") in groups(v))
    press(guest, "pause")
    visitor.wait_for(lambda v: ("Pause", "Reset") in groups(v))
    labels = {name: law.label for name, law in LAWS.items()}
    assert law_options(visitor) == [*(labels[name] for name in labels if LAWS[name].offered_first), MORE]
    visitor.set_value("law", MORE)
    visitor.wait_for(lambda v: law_options(v) == list(labels.values()))
    assert guest.session.settings.run.law.law == "smooth_priority"
    assert visitor.mirror.labelled("law")["value"] == labels["smooth_priority"]
    visitor.set_value("law", labels["barrier_qp"])
    guest.wait(lambda s: s.settings.run.law.law == "barrier_qp")
    # Another page offers few laws again, including the one in its link.
    other = arrive(house(), "panel=small&law=barrier_qp").visitor
    assert law_options(other) == [
        *(labels[name] for name in labels if LAWS[name].offered_first or name == "barrier_qp"),
        MORE,
    ]


def test_more_plots_need_a_button_and_stay_once_one_is_chosen(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    guest = arrive(opened, "panel=small")
    visitor = guest.visitor
    (opener,) = (
        group for group in bodies(visitor, "GuiButtonGroupMessage") if "More plots" in group["options"]
    )
    visitor.send({"type": "GuiUpdateMessage", "uuid": opener["uuid"], "updates": {"value": "More plots"}})
    visitor.wait_for(
        lambda v: any("Laws" in group for group in groups(v)) and ("More plots",) not in groups(v)
    )
    chosen = arrive(opened, "panel=small&plot=lambda").visitor
    assert any("● λ" in group for group in groups(chosen)) and ("More plots",) not in groups(chosen)
    whole = arrive(opened, "panel=all").visitor
    assert any("Laws" in group for group in groups(whole)) and ("More plots",) not in groups(whole)
    assert ("Pause", "Step", "Reset") in groups(whole)


def seen(page: Page) -> dict[str, list[str]]:
    found: dict[str, list[str]] = page.evaluate(SEEN)
    return found


# The notice of a busy machine must not be counted.
@pytest.mark.usefixtures("fast_machine")
def test_the_first_screen_has_at_most_twenty_controls_and_eighty_words(
    house: OpenHouse, page_at: PageAt
) -> None:
    page, opened = page_at(1440, 900), house()
    session = visit(page, opened, "panel=small")
    page.mouse.move(700, 300)
    page.get_by_role("button", name="More plots").wait_for()
    page.locator(".duet-eq .live").first.wait_for(state="attached")
    # Without a graphics card, the page shows a note for some seconds.
    page.locator("#duet-note").wait_for(state="detached")
    found = seen(page)
    assert len(found["controls"]) <= MOST_CONTROLS, "; ".join(found["controls"])
    assert len(found["words"]) <= MOST_WORDS, " ".join(found["words"])
    asked = "Lessons", "Pause", "Reset", "First view", "Copy link", "All settings", "More plots"
    assert set(asked) <= set(found["controls"])
    # The equation's numbers appear under the pointer, the card's terms with all settings.
    number, terms = page.locator(".duet-eq .live").first, page.locator("#duet-contact .terms")
    expect(number).to_be_hidden()
    expect(terms).to_be_hidden()
    page.locator(".duet-eq").hover()
    expect(number).to_be_visible()
    # The button names its next action, and keeps its place.
    pause = page.get_by_role("button", name="Pause", exact=True)
    place = pause.bounding_box()
    pause.click()
    until(page, lambda: session.paused, "a pause")
    go_on = page.get_by_role("button", name="Continue", exact=True)
    assert go_on.bounding_box() == place
    go_on.click()
    until(page, lambda: not session.paused, "a run that goes on")
    # "More laws": the complete list opens by itself.
    law = page.get_by_role("combobox", name="law")
    law_place = law.bounding_box()
    law.click()
    page.get_by_role("option", name=MORE).click()
    page.get_by_role("option", name=LAWS["set_based_task"].label).click()
    until(page, lambda: session.settings.run.law.law == "set_based_task", "another law")
    # Its equation is longer by two lines, but nothing has moved.
    page.locator(".duet-eq").get_by_text("Moe et al. 2016").wait_for()
    assert page.get_by_role("button", name="Pause", exact=True).bounding_box() == place
    assert law.bounding_box() == law_place


def test_two_buttons_restore_the_first_view_and_copy_the_link(house: OpenHouse, page_at: PageAt) -> None:
    page, opened = page_at(1024, 768, permissions=["clipboard-read", "clipboard-write"]), house()
    session = visit(page, opened, "panel=small&dm=0.12")
    first = settled_view(page)
    ask(session, lambda s: s.change("autopilot", False))
    page.mouse.move(60, 500)
    page.mouse.down()
    page.mouse.move(260, 500, steps=4)
    page.mouse.up()
    until(page, lambda: abs(page.evaluate(CAMERA)[0] - first[0]) > 0.05, "a turned view")
    page.get_by_role("button", name="First view").click()
    until(
        page,
        lambda: max(abs(page.evaluate(CAMERA)[i] - first[i]) for i in (3, 4, 5, 6)) < 2e-3,
        "the first view",
    )
    # The link is updated a moment later, and its row is rebuilt.
    page.locator(".duet-view-row input[value*='autopilot=0']").wait_for(state="attached")
    copy = page.get_by_role("button", name="Copy link")
    place = copy.bounding_box()
    copy.click()
    done = page.get_by_role("button", name="Copied")
    done.wait_for()
    assert done.bounding_box() == place
    link = page.evaluate("navigator.clipboard.readText()")
    assert link.startswith(opened.url) and "dm=0.12" in link


@pytest.mark.thorough
@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 768), (390, 844)])
@pytest.mark.parametrize("look", ["lang=de&theme=dark", "lang=sl&theme=light", "lang=de&profile=projector"])
def test_no_text_of_the_first_screen_is_cut_off(
    house: OpenHouse, page_at: PageAt, width: int, height: int, look: str
) -> None:
    page = page_at(width, height)
    visit(page, house(), f"panel=small&v=0.05&{look}")
    page.locator(".duet-view-row").wait_for()
    page.locator("#duet-note").wait_for(state="detached")
    assert lasting(page, lambda: flaws(page)) == []
    accessible(page)
    screenshot(page, f"first-screen-{width}-{look.replace('&', '-')}")
