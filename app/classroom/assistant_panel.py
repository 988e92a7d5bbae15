"""What a teacher's tab has while another one leads: a line that says so, a button, and the notes."""

from collections.abc import Callable, Mapping
from typing import Final

import viser

from app.classroom.classroom import Poll
from app.classroom.classroom_html import TAKE_OVER, banner_html
from app.classroom.teacher_control import TeacherControl
from app.i18n.speaking import N_, tr
from app.page.panels.teachers_tab import ORDER, TeachersTab
from app.web.control_events import on_press

ASSISTING: Final = N_("You assist: another tab of the teacher leads. One tab leads at a time.")


class AssistantPanel:
    """Shown in place of a `TeacherPanel`.

    Args:
        notes: Markdown by lesson id; None for a teacher without a key.
        take_over: called on the network's thread.
    """

    def __init__(
        self, gui: viser.GuiApi, control: TeacherControl, notes: Mapping[str, str] | None, take_over: Callable[[], None]
    ) -> None:
        self._control = control
        gui.add_html(banner_html("wait", tr(ASSISTING)), order=ORDER - 0.5)
        on_press(gui.add_button(tr(TAKE_OVER), order=ORDER - 0.4, icon=viser.Icon.HAND_GRAB), take_over)
        self._notes = None if notes is None else TeachersTab(gui, notes)

    def show(self, poll: Poll | None) -> None:
        """Update the notes; see `TeacherPanel.show`."""
        if self._notes is not None and self._control.classroom.load is not None:
            self._notes.show(self._control.lessons, self._control.classroom.load)

    def close(self) -> None:
        """Do nothing: nothing is being made."""
