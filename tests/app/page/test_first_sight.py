"""The first sight of every scene and rig, in windows of several sizes: nothing is cut off and nothing covers the arms."""

import pytest

from scenes.room import PATH
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import CUT, FREE, LATE_UPDATE, run_on, see_free, see_plots, visit
from tests.browser import PageAt, close_software_note, screenshot, until, wait_frames, world_to_px

FOREARM = "/person/body/left_upper_arm/left_forearm"
SIGHTS = ("hold", "torso"), ("hold", "table"), *((scene, "torso") for scene in ("solo", "ball", "master_slave", "imitation"))


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 768), (390, 844)])
def test_first_sight_of_every_scene_and_rig(house: OpenHouse, page_at: PageAt, width: int, height: int) -> None:
    page = page_at(width, height, expect=(LATE_UPDATE,))
    session = visit(page, house(), f"rig={'table' if width == 1024 else 'torso'}&speed=2")
    if width > 576:
        see_plots(page, ("distance", "error"))
    close_software_note(page)
    for scene, rig in SIGHTS:
        ask(session, lambda s, scene=scene, rig=rig: [s.change("scene", scene), s.change("rig", rig)])
        joints = ask(session, lambda s: [(arm.name, arm.joints.stop - arm.joints.start) for arm in s.simulation.room.arms])
        chains = [[f"/arms/{name}/base", *(f"j{i}" for i in range(1, count + 1))] for name, count in joints]
        nodes = ["/".join(chain[: n + 1]) for chain in chains for n in range(len(chain))]
        nodes += {"ball": ["/ball"], "imitation": [FOREARM]}.get(scene, [])
        see_free(page, nodes, f"{scene}, {rig}")
        if scene == "ball":
            start = ask(session, lambda s: s.simulation.home)
            assert start is not None
            for end in (start, start + PATH):
                assert page.evaluate("p => document.elementFromPoint(...p) === __viserMutable.canvas", world_to_px(page, end))
        # Somewhere on the way, so that the picture shows what happens.
        run_on(page, session, 2.5 if scene == "ball" else 1.5)
        if scene == "hold":
            # On its way back the hand moves away from the other arm: the numbers are longest then.
            until(page, lambda: session.simulation.time > 3.0 and session.simulation.sample().law_approach < -0.02, "a retreat")
        ask(session, lambda s: s.toggle_pause())
        page.get_by_text("paused", exact=True).wait_for()
        for theme in ("light", "dark") if scene == "hold" else ("light",):
            ask(session, lambda s, theme=theme: s.change("theme", theme))
            page.wait_for_function("theme => document.documentElement.dataset.mantineColorScheme === theme", arg=theme)
            wait_frames(page, 6)
            screenshot(page, f"page-{width}-{scene}-{rig}-{theme}")
            assert page.evaluate(CUT) == [], (scene, rig, theme)
        assert page.evaluate(FREE, nodes) == [], (scene, rig)
        ask(session, lambda s: s.toggle_pause())
