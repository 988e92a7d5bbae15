"""Two buttons: first view, and link to the page."""

from app.i18n.speaking import tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.link_box import PageLink
from app.session.actions import FirstView
from app.session.frame import Frame
from app.text.templates import macros
from app.web.control_events import on_press
from app.web.viser_internals import uuid_of


class ViewRow(PagePanel):
    """Hidden while all controls are shown."""

    def __init__(self, page: PanelContext) -> None:
        gui, order = page.client.gui, page.controls.below_transport
        self._controls, self._link = page.controls, PageLink(page.client, page.session, page.links)
        self._row = gui.add_html("", order=order, visible=False)
        # Hidden: a button of the row presses it.
        self._first = gui.add_button(tr("First view"), order=order + 0.1, visible=False)
        on_press(self._first, lambda: page.session.post(FirstView()))

    def show(self, frame: Frame) -> None:
        self._row.visible = self._first.visible = self._controls.small
        if not self._controls.small:
            return
        link = self._link.due(frame)
        if link is not None:
            self._row.content = macros("page/panels/copy.html").view_row(link, uuid_of(self._first))
