"""The page in the system's Firefox: it opens, an arm is pulled, a lesson runs, and the console stays silent."""

import pytest

from app.start import App
from tests.app.conftest import OpenHouse
from tests.browser import artefacts
from tests.firefox import firefox

NODE = "window.__viserMutable?.nodeRefFromName?."


def test_a_visit_in_firefox(house: OpenHouse, tmp_path_factory: pytest.TempPathFactory) -> None:
    opened: App = house()
    try:
        with firefox(tmp_path_factory.mktemp("firefox")) as tab:
            tab.open(f"{opened.url}/?autopilot=0&lang=en", 1024, 768)
            tab.until(f"{NODE}['/arms/right/base/j1/j2/j3/j4/j5/j6/j7'] && {NODE}['/arms/left/base']", "the arms")
            tab.until("__viserMutable.canvas.getContext('webgl2') instanceof WebGL2RenderingContext", "a picture of them")
            tab.picture(artefacts() / "firefox.png")
            tab.open(f"{opened.url}/?lesson=5&lang=de", 1024, 768)
            tab.until("document.querySelector('.duet-lesson')?.innerText.length > 80", "the lesson")
            tab.picture(artefacts() / "firefox-lesson.png")
            assert not tab.complaints
    except FileNotFoundError as error:
        pytest.skip(str(error))
