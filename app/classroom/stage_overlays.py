"""What a lecture shows over the stage: the tally of the class's answers, and the address."""

import viser

from app.classroom.address import Address
from app.classroom.classroom import Poll
from app.classroom.classroom_html import overlay_html, poll_html
from app.page.lessons.lesson_panel import ORDER
from app.page.view import View


class StageOverlays:
    """The elements of one audience's page, or of one teacher's.

    Args:
        gui: of the audience or the teacher.
        view: the stage's.
    """

    def __init__(self, gui: viser.GuiApi, view: View) -> None:
        self._gui, self._view = gui, view
        self._addresses = [gui.add_html("")]
        self._poll: viser.GuiHtmlHandle | None = None
        with view.plots_tab:
            # A folded panel is not on the page; one of several is.
            self._addresses.append(gui.add_html(""))

    def show(self, poll: Poll | None, inviting: Address | None) -> None:
        """Update the elements.

        Args:
            poll: the question on the stage; its tally is shown after the reveal.
            inviting: the address, while it is on every screen.
        """
        tab = self._view.lesson_panel.tab
        if self._poll is None and tab is not None:
            with tab:
                self._poll = self._gui.add_html("", order=ORDER["verdict"] - 0.5)
                self._addresses.append(self._gui.add_html("", order=0.2))
        if self._poll is not None:
            self._poll.content = poll_html(poll) if poll is not None and poll.revealed else ""
        address = "" if inviting is None else overlay_html(inviting)
        for handle in self._addresses:
            handle.content = address
