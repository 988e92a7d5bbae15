"""What is shown over the stage: how the class has answered, and the address."""

import viser

from app.classroom.address import Address
from app.classroom.classroom import Poll
from app.classroom.classroom_html import overlay_html, poll_html
from app.page.lessons.lesson_panel import ORDER
from app.page.view import View


class Overlays:
    """Written anew where something changes, and only then.

    Args:
        gui: of those who see it.
        view: the stage's.
    """

    def __init__(self, gui: viser.GuiApi, view: View) -> None:
        self._gui, self._view = gui, view
        self._addresses = [gui.add_html("")]
        self._poll: viser.GuiHtmlHandle | None = None
        with view.plots_tab:
            # A folded panel is not on the page; one of several is.
            self._addresses.append(gui.add_html(""))
        self._texts: dict[str, str] = {}

    def show(self, poll: Poll | None, inviting: Address | None) -> None:
        """Bring everything up to date.

        Args:
            poll: the question on the stage; its answers are shown once they are revealed.
            inviting: the address, while it is to be on every screen.
        """
        tab = self._view.lesson_panel.tab
        if self._poll is None and tab is not None:
            with tab:
                self._poll = self._gui.add_html("", order=ORDER["verdict"] - 0.5)
                self._addresses.append(self._gui.add_html(self._texts.get("address 0", ""), order=0.2))
        if self._poll is not None:
            self._write("poll", self._poll, poll_html(poll) if poll is not None and poll.revealed else "")
        shown = "" if inviting is None else overlay_html(inviting)
        for i, handle in enumerate(self._addresses):
            self._write(f"address {i}", handle, shown)

    def _write(self, name: str, handle: viser.GuiHtmlHandle, text: str) -> None:
        if self._texts.get(name, "") != text:
            self._texts[name] = handle.content = text
