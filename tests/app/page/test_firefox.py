"""The page in the system's Firefox: it opens, the orange arm is pulled with the mouse, a lesson runs, and the console stays silent."""

import json

import numpy as np
import pytest

from app.session.session import Session
from app.start import App
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.targets import LinkTarget
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.browser import CAMERA, artefacts
from tests.firefox import Firefox, firefox

NODE = "window.__viserMutable?.nodeRefFromName?."
LINK = "/arms/right/base/j1/j2/j3/j4/j5/j6"
PULL = 150.0
"""Way of the mouse to the right, towards the silver arm [CSS px]."""

STILL_VIEW = f"""new Promise((done) => {{
  let last = "", frames = 0;
  const look = () => {{
    const now = JSON.stringify({CAMERA});
    frames = now === last ? frames + 1 : 0;
    last = now;
    if (frames < 20) requestAnimationFrame(look);
    else done(true);
  }};
  look();
}})"""
NEXT_FRAME = "new Promise((done) => requestAnimationFrame(() => done(true)))"
LINK_PX = f"""(() => {{
  const {{ camera, nodeRefFromName, canvas }} = __viserMutable, box = canvas.getBoundingClientRect();
  const node = nodeRefFromName["{LINK}"], at = node.position.clone();
  node.updateWorldMatrix(true, false);
  node.getWorldPosition(at).project(camera);
  return JSON.stringify([box.left + (1 + at.x) / 2 * box.width, box.top + (1 - at.y) / 2 * box.height]);
}})()"""


def test_a_visit_in_firefox(house: OpenHouse, tmp_path_factory: pytest.TempPathFactory) -> None:
    opened: App = house()
    try:
        with firefox(tmp_path_factory.mktemp("firefox")) as tab:
            tab.open(f"{opened.url}/?autopilot=0&lang=en&speed=2&wmax=0.5&dm=0.3", 1024, 768)
            tab.until(f"{NODE}['{LINK}/j7'] && {NODE}['/arms/left/base']", "the arms")
            tab.until("__viserMutable.canvas.getContext('webgl2') instanceof WebGL2RenderingContext", "a picture of them")
            tab.until("document.documentElement.matches('.duet-built')", "the whole page")
            pull_the_arm(tab, live_sessions(opened)[max(live_sessions(opened))])
            tab.open(f"{opened.url}/?lesson=5&lang=de", 1024, 768)
            tab.until("document.querySelector('.duet-lesson')?.innerText.length > 80", "the lesson")
            tab.picture(artefacts() / "firefox-lesson.png")
            assert not tab.complaints
    except FileNotFoundError as error:
        pytest.skip(str(error))


def pull_the_arm(tab: Firefox, session: Session) -> None:
    """Pull a link of the orange arm towards the silver one: it comes along, d shrinks, and the silver one gives way."""

    def state(s: Session) -> tuple[float, Array]:
        simulation = s.simulation
        return simulation.history.table()[-1, COLUMN["d"]], simulation.positions[simulation.avoiding.joints].copy()

    def missing(s: Session) -> float:
        assert isinstance(s.held, LinkTarget)
        placement = s.simulation.kinematics.data.oMi[s.simulation.guided.joint(s.held.joint)]
        return float(np.linalg.norm(placement.act(s.held.offset) - s.held.position))

    def at_the_mouse() -> None:
        tab.until("__viserMutable.nodeRefFromName['/grip/point']?.visible", "the mark where it is held")
        while ask(session, missing) > 0.02:
            assert tab.value(NEXT_FRAME)
        tab.picture(artefacts() / "firefox.png")

    tab.value(STILL_VIEW)
    view, (x, y) = tab.value(f"JSON.stringify({CAMERA})"), json.loads(tab.value(LINK_PX))
    before, still = ask(session, state)
    tab.drag((x, y), (PULL, 0.0), at_the_mouse)
    while session.held is not None:
        assert tab.value(NEXT_FRAME)
    after, moved = ask(session, state)
    assert np.abs(np.array(json.loads(tab.value(LINK_PX))) - (x + PULL, y)).max() < 25.0
    assert after < before - 0.05 and np.abs(moved - still).max() > 0.02
    # The view does not turn with what is pulled.
    assert tab.value(f"JSON.stringify({CAMERA})") == view
