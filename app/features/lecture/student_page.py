"""A student's banner, answers, and hand-in."""

from collections import deque
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from typing import Any, Final

import viser

from app.features.classroom.class_summary import HandIn
from app.features.classroom.classroom import Poll
from app.features.classroom.classroom_html import mine_html
from app.features.classroom.student_work import LONGEST_NAME, clean_name
from app.features.lecture.class_messages import PostWork, Progressed, Reported
from app.features.lecture.page_lines import TAKE_OVER, banner_html
from app.features.lecture.teacher_control import Answer, Because, TeacherControl
from app.features.lessons.panel.lesson_html import choice_label
from app.features.lessons.panel.lesson_panel import IN_LESSONS, ORDER, LessonPanel
from app.features.lessons.progress import LONGEST_REASON
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.tally import Ballot, QuestionId
from app.i18n.speaking import tr
from app.page.panels.drawing_board import DrawingBoard
from app.page.picture_size import PHONE, canvas_size
from app.text.templates import macros
from app.web.control_events import on_entry, on_press
from app.web.viser_internals import HotkeyKey, expand_for

KEYS: Final[tuple[HotkeyKey, ...]] = ("1", "2", "3", "4", "5", "6")

_OWN: Final = (
    "<style>.duet-l-drawing:not(:has(.duet-draw)),.duet-l-choices,.duet-l-said,"
    ".duet-l-verdict,.duet-tied{display:none!important}</style>"
)
"""Hides the projector's axes, choices and verdict: a student has own ones."""


class Banner:
    """The teacher's decision at the top of a page, and a button to take control."""

    def __init__(self, gui: viser.GuiApi, take_over: Callable[[], None]) -> None:
        self._gui, self._take_over = gui, take_over
        self._lines = {False: gui.add_html("", order=-30.0)}
        self._buttons: dict[bool, viser.GuiButtonHandle] = {}

    def show(self, kind: str, text: str, tab: viser.GuiTabHandle | None, offers: bool) -> None:
        """Show a text; "" hides the banner. `tab`: the lesson's, if the controls are folded."""
        in_tab = tab is not None
        with tab or nullcontext():
            if in_tab not in self._lines:
                self._lines[in_tab] = self._gui.add_html("", order=0.5)
            if offers and in_tab not in self._buttons:
                button = self._gui.add_button(
                    tr(TAKE_OVER), order=0.6 if in_tab else -29.5, icon=viser.Icon.HAND_GRAB
                )
                self._buttons[in_tab] = on_press(button, self._take_over)
        for place, line in self._lines.items():
            line.content = banner_html(kind, text) if place == in_tab else ""
        for place, button in self._buttons.items():
            button.visible = offers and place == in_tab


class Answers:
    """Buttons, keys and texts for one student's answers."""

    def __init__(
        self, client: viser.ClientHandle, panel: LessonPanel, control: TeacherControl, student: str
    ) -> None:
        self._client, self._panel, self._control, self._student = client, panel, control, student
        self._buttons: list[viser.GuiButtonHandle] = []
        self._commands: list[viser.CommandHandle] = []
        self._texts: list[viser.GuiHtmlHandle] = []
        self._reasons: dict[tuple[QuestionId, int], viser.GuiTextHandle] = {}
        self._shown: tuple[Any, ...] = ()
        self._phone, self._folded = canvas_size(client)[0] <= PHONE, False

    def fold(self, folded: bool) -> None:
        """Fold the main panel; the student can unfold it."""
        if folded == self._folded or (folded and self._panel.panel is None):
            return
        self._folded = folded
        if not folded:
            self._client.gui.main_panel.expand()
            return
        self._client.gui.main_panel.minimize()
        if self._phone and self._panel.panel is not None:
            expand_for(self._client, self._panel.panel)

    def _make(self) -> None:
        gui = self._client.gui
        assert self._panel.tab is not None
        with self._panel.tab:
            self._texts = [
                gui.add_html(_OWN, order=ORDER["choices"] + 0.1),
                gui.add_html("", order=ORDER["choices"] + 8.5),
                gui.add_html("", order=ORDER["verdict"] + 0.5),
            ]
            for i in range(len(KEYS)):
                button = gui.add_button(
                    f"{i + 1}", visible=False, color="gray", order=ORDER["choices"] + 1.0 + i
                )
                self._buttons.append(
                    on_press(button, partial(self._control.answers.put, Answer(self._student, i)))
                )
            self._board = DrawingBoard(
                gui, self._control.answers.put, partial(self._control.draw, self._student), IN_LESSONS
            )

    def _offer_reason(self, poll: Poll | None, mine: Ballot) -> None:
        """One box for each question and round."""
        asked = (poll.question, poll.round) if poll is not None and poll.open and mine != Ballot() else None
        if asked is not None and asked not in self._reasons and self._panel.tab is not None:
            hint = tr(
                "Optional: one line of at most {count} characters. The teacher reads it, and may show it to all without your name.",
                count=LONGEST_REASON,
            )
            with self._panel.tab:
                box = self._client.gui.add_text(
                    tr("Because …"), mine.reason, hint=hint, order=ORDER["choices"] + 8.7
                )
            put, student, question = self._control.answers.put, self._student, asked[0]
            self._reasons[asked] = on_entry(
                box, lambda text: put(Because(student, question, text[:LONGEST_REASON]))
            )
        for place, box in self._reasons.items():
            box.visible = place == asked

    def show(self, poll: Poll | None, mine: Ballot, first: Ballot) -> None:
        asked = (
            None
            if poll is None
            else (poll.question, poll.choices, poll.open, poll.outcome, poll.verdicts, poll.round)
        )
        if self._panel.tab is None or (asked, mine, first) == self._shown:
            return
        self._shown = asked, mine, first
        if not self._buttons:
            self._make()
        count = min(len(poll.choices), len(KEYS)) if poll is not None and poll.open else 0
        for i, button in enumerate(self._buttons):
            if poll is not None and i < count:
                button.label = choice_label(i + 1, poll.choices[i], i == mine.choice)
                button.color = "blue" if i == mine.choice else "gray"
            button.visible = i < count
        while len(self._commands) > count:
            self._commands.pop().remove()
        for i in range(len(self._commands), count):
            name = tr("Answer {number}", number=i + 1)
            command = self._client.gui.add_command(name, hotkey=KEYS[i], icon=viser.Icon.HAND_CLICK)
            self._commands.append(
                on_press(command, partial(self._control.answers.put, Answer(self._student, i)))
            )
        drawing = poll.drawing if poll is not None and poll.open else None
        self._board.show(poll.question if poll is not None else ("", ""), drawing, mine.curve)
        self._offer_reason(poll, mine)
        line = "" if poll is None else mine_html(poll, mine, first, not self._phone)
        over = poll is not None and bool(poll.verdicts)
        self._texts[1].content, self._texts[2].content = ("", line) if over else (line, "")


class _Form:
    """Form in the caller's open container. Calls both functions on the network's thread."""

    def __init__(
        self, gui: viser.GuiApi, order: float, hand_in: Callable[[str], None], take_back: Callable[[], None]
    ) -> None:
        self.folder = gui.add_folder(tr("Hand in my report"), order=order, expand_by_default=False)
        with self.folder:
            what = tr(
                "The teacher gets what is in your lab report (answers, reasons, drawings, outcomes, challenges, own words) and the name "
                "that you type, if any. Until the class ends you can take it back."
            )
            gui.add_html(macros("page/panels/pills.html").note(what))
            self._name = gui.add_text(tr("Name"), "")
            self._state = gui.add_html("")
            self._send = gui.add_button(tr("Hand in"), icon=viser.Icon.SEND)
            self._back = gui.add_button(
                tr("Take it back"), icon=viser.Icon.ARROW_BACK_UP, color="gray", visible=False
            )
        on_press(self._send, lambda: hand_in(clean_name(str(self._name.value)[: 4 * LONGEST_NAME])))
        on_press(self._back, take_back)

    def show(self, visible: bool, report: HandIn | None) -> None:
        self.folder.visible = visible
        self.folder.label = tr("Hand in my report") if report is None else tr("My report is handed in")
        self._send.label = tr("Hand in") if report is None else tr("Hand in again")
        self._back.visible = report is not None
        if report is None:
            self._state.content = ""
            return
        said = (
            tr("Handed in as {name}.", name=report.name) if report.name else tr("Handed in without a name.")
        )
        self._state.content = macros("page/panels/pills.html").note(said, "duet-say")


class HandInBox:
    """A student's hand-in form, and progress for the class's counts. `group`: "" in the shared session."""

    def __init__(self, gui: viser.GuiApi, post_work: PostWork, student: str, group: str) -> None:
        self._gui, self._post_work, self._student, self._group = gui, post_work, student, group
        self._forms: dict[bool, _Form] = {}
        self._names: deque[str] = deque(maxlen=1)
        self._version = -1

    def post(self, own: LessonSession | None, operates: bool) -> None:
        """Post a requested report, and changed progress if this student `operates` the session.

        `own`: None in the shared session.
        """
        name = self._names.pop() if self._names else None
        progress = (
            ""
            if own is None or not own.begun or (name is None and own.version == self._version)
            else own.walk.to_json()
        )
        if own is not None:
            self._version = own.version
        if name is not None:
            self._post_work(Reported(self._student, name, progress))
        elif progress and operates:
            self._post_work(Progressed(self._group, progress))

    def post_again(self) -> None:
        """Post the progress again in the next frame."""
        self._version = -1

    def show(self, offered: bool, report: HandIn | None, tab: viser.GuiTabHandle | None) -> None:
        in_lesson = tab is not None
        if offered and in_lesson not in self._forms:
            order = ORDER["hints"] + 7.5 if in_lesson else -29.0
            take_back = partial(self._post_work, Reported(self._student, None))
            with tab or nullcontext():
                # The progress belongs to the thread that calls `post`.
                self._forms[in_lesson] = _Form(self._gui, order, self._names.append, take_back)
        for place, form in self._forms.items():
            form.show(offered and place == in_lesson, report)
