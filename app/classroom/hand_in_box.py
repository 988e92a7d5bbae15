"""A student hands in the lab report to the teacher, with a name or without, and can take it back."""

from collections import deque
from collections.abc import Callable
from contextlib import nullcontext
from typing import Final

import viser

from app.classroom.student_posts import StudentPosts
from app.classroom.student_work import LONGEST_NAME, clean_name
from app.export.class_summary import HandIn
from app.i18n.speaking import N_, tr
from app.lessons.session.lesson_session import LessonSession
from app.page.lessons.lesson_panel import ORDER
from app.text.html_element import element

WHAT: Final = N_(
    "The teacher gets what is in your lab report (answers, reasons, drawings, outcomes, challenges, own words) and the name that you "
    "type, if any. Until the class ends you can take it back."
)
"""What is handed in, in one line."""

_IN_PANEL: Final = -29.0
_IN_LESSON: Final = ORDER["hints"] + 7.5


class _Form:
    """The folder with name and buttons. The caller has opened its container.

    Args:
        hand_in: called with the name, on the network's thread.
        take_back: called on the network's thread.
    """

    def __init__(self, gui: viser.GuiApi, order: float, hand_in: Callable[[str], None], take_back: Callable[[], None]) -> None:
        self.folder = gui.add_folder(tr("Hand in my report"), order=order, expand_by_default=False)
        with self.folder:
            gui.add_html(element("div", "", element("p", tr(WHAT), class_="soft"), class_="duet-class"))
            self._name = gui.add_text(tr("Name"), "")
            self._state = gui.add_html("")
            self._send = gui.add_button(tr("Hand in"), icon=viser.Icon.SEND)
            self._back = gui.add_button(tr("Take it back"), icon=viser.Icon.ARROW_BACK_UP, color="gray", visible=False)

        @self._send.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            del event
            hand_in(clean_name(str(self._name.value)[: 4 * LONGEST_NAME]))

        @self._back.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            del event
            take_back()

    def show(self, visible: bool, report: HandIn | None) -> None:
        self.folder.visible = visible
        self.folder.label = tr("Hand in my report") if report is None else tr("My report is handed in")
        self._send.label = tr("Hand in") if report is None else tr("Hand in again")
        self._back.visible = report is not None
        if report is None:
            self._state.content = ""
            return
        said = tr("Handed in as {name}.", name=report.name) if report.name else tr("Handed in without a name.")
        self._state.content = element("div", "", element("p", said, class_="duet-say"), class_="duet-class")


class HandInBox:
    """The form on one student's page, and the student's progress for the class's counts.

    Args:
        control: takes both, as plain data.
        student: id of the tab.
    """

    def __init__(self, gui: viser.GuiApi, control: StudentPosts, student: str) -> None:
        self._gui, self._control, self._student = gui, control, student
        self._forms: dict[bool, _Form] = {}
        self._names: deque[str] = deque(maxlen=1)
        self._version = -1
        self._shown: tuple[bool, bool, HandIn | None] | None = None

    def _form(self, order: float) -> _Form:
        return _Form(self._gui, order, self._hand_in, lambda: self._control.post_take_back(self._student))

    def _hand_in(self, name: str) -> None:
        # The progress belongs to the thread that calls `post`.
        self._names.append(name)

    def post(self, own: LessonSession | None) -> None:
        """Post the report if the student has asked for it, and the progress in the student's own session whenever it has changed.

        Args:
            own: the lessons of that session; None on the stage.
        """
        name = self._names.pop() if self._names else None
        progress = "" if own is None or not own.begun or (name is None and own.version == self._version) else own.walk.to_json()
        if own is not None:
            self._version = own.version
        if name is not None:
            self._control.post_hand_in(self._student, name, progress)
        elif progress:
            self._control.post_progress(self._student, progress)

    def show(self, offered: bool, report: HandIn | None, tab: viser.GuiTabHandle | None) -> None:
        """Offer the form.

        Args:
            offered: whether there is anything to hand in.
            report: that is handed in; None for none.
            tab: of the lesson, in place of folded controls.
        """
        shown = offered, tab is not None, report
        if shown == self._shown:
            return
        self._shown = shown
        in_lesson = tab is not None
        if offered and in_lesson not in self._forms:
            with tab or nullcontext():
                self._forms[in_lesson] = self._form(_IN_LESSON if in_lesson else _IN_PANEL)
        for place, form in self._forms.items():
            form.show(offered and place == in_lesson, report)
