"""A browser whose WebGL is switched off: everything but the picture is there, and the page says what to switch on."""

from playwright.sync_api import Browser

from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import hand, see_plots
from tests.browser import FLAGS, installed_browser, until
from tests.tools.lesson_hands import Keys
from tests.tools.lesson_walker import Walker, enter

WITHOUT_WEBGL = ("--disable-gpu", "--disable-software-rasterizer", "--disable-3d-apis")


def test_lessons_plots_numbers_and_keys_work_without_webgl(house: OpenHouse, browser: Browser) -> None:
    flags = [flag for flag in FLAGS if "gl" not in flag] + list(WITHOUT_WEBGL)
    with browser.browser_type.launch(executable_path=installed_browser(), args=flags) as without:
        page = without.new_page(locale="de-AT", viewport={"width": 1200, "height": 720})
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        session, run = enter(page, house(), "lang=en&lesson=1&step=1")
        assert page.evaluate("document.createElement('canvas').getContext('webgl')") is None
        note = page.get_by_role("note")
        assert "WebGL is switched off" in note.inner_text()
        walked = Walker(page, session, run, Keys(page)).step()
        assert len(walked.said) == 4 and walked.said[-1] == "You predicted it."
        see_plots(page, ("hand error |e| [mm]", "elbow angle"))
        page.keyboard.press("x")
        until(page, lambda: not run.open, "leaving")
        place = hand(session)
        page.keyboard.press("ArrowUp")
        until(page, lambda: hand(session)[2] > place[2] + 0.01, "a hand that goes up")
        assert float(page.locator(".duet-tiles b").first.inner_text()) >= 0.0
        ask(session, lambda s: s.change("lang", "auto"))
        note.get_by_text("WebGL ist in diesem Browser ausgeschaltet").wait_for()
        box = note.bounding_box()
        plots = page.locator("[data-floating-window]:has(.duet-plots)").bounding_box()
        assert box is not None and plots is not None and box["y"] + box["height"] <= plots["y"]
        assert errors == []
