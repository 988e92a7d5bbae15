"""A page on which nothing happens: a frame sends nothing to the browser."""

import pytest

from app.page.panels import readout
from tests.app.conftest import Arrive, OpenHouse


def test_an_idle_frame_sends_nothing(house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch) -> None:
    built, tiles_html = list[str](), readout.tiles_html
    monkeypatch.setattr(readout, "tiles_html", lambda *given: built.append("tiles") or tiles_html(*given))
    one = arrive(house(), "plot=laws")
    one.ask(lambda s: s.halt.set("visitor"))
    for scene, ghost in (("hold", "frozen"), ("ball", "off"), ("imitation", "off")):
        one.ask(lambda s, scene=scene, ghost=ghost: [s.change("scene", scene), s.change("ghost", ghost)])
        # Plots, link and numbers have periods of their own, so that the last of them comes a little later.
        quiet, frames, numbers = 0, -1, 0
        for _ in range(400):
            one.ask(lambda s: s.simulation.steps)
            quiet = quiet + 1 if (one.visitor.received.frames, len(built)) == (frames, numbers) else 0
            frames, numbers = one.visitor.received.frames, len(built)
            if quiet == 40:
                break
        assert quiet == 40 and numbers > 0, scene
        # A change is sent: the silence is not that of a broken page.
        one.ask(lambda s: s.change("n", s.settings.run.law.order + 1.0))
        one.visitor.wait_for(lambda v, frames=frames: v.received.frames > frames)
