"""A new panel needs a file and one entry: then it is on the page, acts, and follows the frame."""

import pytest

from app.page import operation
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.session.actions import Action
from app.session.frame import Frame
from tests.app.conftest import Arrive, OpenHouse


class Halve(Action, newest_by=None):
    """Halve the critical distance."""


class MadeUp(PagePanel):
    """A button that halves d_m, and d_m as text."""

    def __init__(self, page: PanelContext) -> None:
        self._session = page.session
        page.client.gui.add_button("halve").on_click(lambda _: page.session.post(Halve()))
        self._text = page.client.gui.add_text("made up", "")
        page.handlers.add(Halve, self._halve)

    def _halve(self, action: Halve) -> None:
        del action
        self._session.change("dm", 0.5 * self._session.settings.run.law.critical_distance)

    def show(self, frame: Frame) -> None:
        self._text.value = f"{1000.0 * frame.settings.run.law.critical_distance:.0f} mm"


def test_a_new_panel_needs_one_entry(
    house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(operation, "PANELS", [*operation.PANELS, MadeUp])
    one = arrive(house(), "dm=0.2")
    one.visitor.wait_for(lambda v: v.mirror.labelled("made up")["value"] == "200 mm")
    one.visitor.click("halve")
    one.visitor.wait_for(lambda v: v.mirror.labelled("made up")["value"] == "100 mm")
    assert one.session.settings.run.law.critical_distance == 0.1
