"""A student's own part of the stage's page: the banner, the answers as buttons and keys, and the verdict on the own answer."""

from typing import Any, Final

import viser

from app.classroom.classroom import Poll
from app.classroom.classroom_html import banner_html, mine_html
from app.classroom.teacher_control import TeacherControl
from app.i18n.speaking import tr
from app.lessons.tally import Ballot
from app.page.lessons.drawing_board import DrawingBoard
from app.page.lessons.lesson_html import choice_label
from app.page.lessons.lesson_panel import ORDER, LessonPanel
from app.page.window_size import canvas_size
from app.theme import NARROW
from app.web.viser_internals import HotkeyKey, expand_for

PHONE: Final = 576.0
"""On a window up to this width viser puts all panels into one sheet at the bottom [CSS px]."""

KEYS: Final[tuple[HotkeyKey, ...]] = ("1", "2", "3", "4", "5", "6")

_OWN: Final = "<style>.duet-l-drawing:not(:has(.duet-draw)),.duet-l-choices,.duet-l-verdict{display:none!important}</style>"
"""Hides the projector's axes and list of choices, and the class's verdict, as the student has a board, buttons and an own verdict."""


def is_narrow(client: viser.ClientHandle) -> bool:
    """Return whether a window has no room for lesson, stage and controls beside each other."""
    return canvas_size(client)[0] < NARROW


class Banner:
    """One line at the top of a page: what the teacher has decided."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._handle = gui.add_html("", order=-30.0)
        self._other: viser.GuiHtmlHandle | None = None

    def show(self, kind: str, text: str, tab: viser.GuiTabHandle | None = None) -> None:
        """Show a text; "" shows nothing. `tab`: of the lesson, in place of folded controls."""
        line = banner_html(kind, text)
        if tab is not None and self._other is None:
            with tab:
                self._other = self._gui.add_html("", order=0.5)
        self._handle.content = "" if tab is not None else line
        if self._other is not None:
            self._other.content = line if tab is not None else ""


class Answers:
    """The buttons, keys and texts for one student's answers.

    Args:
        panel: of the lessons, on the stage.
        control: takes what the student hands in.
        student: id of the tab.
    """

    def __init__(self, client: viser.ClientHandle, panel: LessonPanel, control: TeacherControl, student: str) -> None:
        self._client, self._panel, self._control, self._student = client, panel, control, student
        self._buttons: list[viser.GuiButtonHandle] = []
        self._commands: list[viser.CommandHandle] = []
        self._texts: list[viser.GuiHtmlHandle] = []
        self._shown: tuple[Any, ...] = ()
        self._narrow, self._phone, self._folded = is_narrow(client), canvas_size(client)[0] <= PHONE, False

    def fold(self, folded: bool) -> None:
        """On a narrow window fold the main panel while a lesson is open; the student can unfold it."""
        if not self._narrow or folded == self._folded or (folded and self._panel.panel is None):
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
                self._buttons.append(self._button(i))
            control, student = self._control, self._student
            self._board = DrawingBoard(
                gui,
                lambda action, kind: control.answers.put(action, (student, kind)),
                lambda question, curve: control.draw(student, question, curve),
            )

    def _button(self, index: int) -> viser.GuiButtonHandle:
        button = self._client.gui.add_button(f"{index + 1}", visible=False, color="gray", order=ORDER["choices"] + 1.0 + index)

        @button.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            del event
            self._answer(index)

        return button

    def _command(self, index: int) -> viser.CommandHandle:
        command = self._client.gui.add_command(
            tr("Answer {number}", number=index + 1), hotkey=KEYS[index], icon=viser.Icon.HAND_CLICK
        )

        @command.on_trigger
        async def _(event: viser.CommandEvent) -> None:
            del event
            self._answer(index)

        return command

    def _answer(self, choice: int) -> None:
        self._control.post_answer(self._student, choice)

    def show(self, poll: Poll | None, ballot: Ballot | None, first: Ballot) -> None:
        """Update everything. `ballot`: the student's newest one; `first`: see `mine_html`."""
        mine = Ballot() if ballot is None else ballot
        asked = None if poll is None else (poll.question, poll.choices, poll.open, poll.outcome, poll.verdicts, poll.round)
        if self._panel.tab is None or (asked, mine, first) == self._shown:
            return
        self._shown = asked, mine, first
        if not self._buttons:
            self._make()
        count = min(len(poll.choices), len(KEYS)) if poll is not None and poll.open else 0
        for i, button in enumerate(self._buttons):
            if poll is not None and i < count:
                button.label = choice_label(i + 1, poll.choices[i], i == mine.choice)
                button.color = "orange" if i == mine.choice else "gray"
            button.visible = i < count
        while len(self._commands) > count:
            self._commands.pop().remove()
        while len(self._commands) < count:
            self._commands.append(self._command(len(self._commands)))
        drawing = poll.drawing if poll is not None and poll.open else None
        self._board.show(poll.question if poll is not None else ("", ""), drawing, mine.curve)
        line = "" if poll is None else mine_html(poll, mine, first)
        over = poll is not None and bool(poll.verdicts)
        self._texts[1].content, self._texts[2].content = ("", line) if over else (line, "")
