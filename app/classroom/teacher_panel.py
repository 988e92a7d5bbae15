"""What only a teacher has: the class, the notes, and the way in. Made for the teacher's browser alone; nobody else is sent any of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Literal

import viser

from app.classroom.address import Address
from app.classroom.classroom import Headcount, Poll
from app.classroom.classroom_html import heads_html, join_html, no_notes_html, notes_html, poll_html
from app.i18n.speaking import N_, tr
from app.lessons.lesson import Step
from app.lessons.notes import Notes, read_notes
from app.lessons.session.lesson_session import LessonSession
from app.page.panels.choice_buttons import ChoiceButtons
from app.web.viser_internals import HotkeyKey

Action = Literal["follow", "free", "pause", "reveal", "again", "invite"]
"""What a teacher decides: everybody to the stage, everybody to themselves, halt or go on, show the answers, ask anew, the address."""

ORDER: Final = -20.0
"""Above the controls."""


COMMANDS: Final[tuple[tuple[str, HotkeyKey, Action], ...]] = (
    (N_("Class: follow me, or explore freely"), "F", "free"),
    (N_("Class: pause everybody, or go on"), "P", "pause"),
    (N_("Class: reveal the answers to everybody"), "V", "reveal"),
    (N_("Class: ask again"), "Q", "again"),
    (N_("Class: show the address on every screen"), "J", "invite"),
)
"""Name, key with Alt and Shift, and what it does."""


@dataclass(frozen=True)
class ClassState:
    """What the teacher's panel shows of the class.

    Attributes:
        heads: how many there are.
        free, paused, inviting: what the teacher has decided.
        waiting: how many want to explore and have no place.
        poll: the question on the stage; None if there is none.
    """

    heads: Headcount
    free: bool
    paused: bool
    inviting: bool
    waiting: int
    poll: Poll | None


class NotesView:
    """The notes to the open lesson, those to the present step first.

    Args:
        gui: of a teacher; the caller has opened the container.
        notes: by the id of their lesson.
    """

    def __init__(self, gui: viser.GuiApi, notes: Mapping[str, str]) -> None:
        self._notes = {lesson: read_notes(text) for lesson, text in notes.items()}
        self._handle = gui.add_html("")
        self._shown: tuple[bool, Notes | None, Step | None] | None = None

    def show(self, run: LessonSession) -> None:
        """Bring them up to date. `run`: the lessons."""
        walk = run.walk if run.open else None
        notes = self._notes.get(walk.lesson.id) if walk is not None else None
        place = (run.open, notes, walk.step if walk is not None else None)
        if place == self._shown:
            return
        self._shown = place
        if walk is None or notes is None:
            self._handle.content = no_notes_html(run.open)
        else:
            self._handle.content = notes_html(notes, walk.lesson.steps.index(walk.step) + 1, walk.step.setup.folder)


class NotesPanel:
    """The notes of a teacher who is alone with the page.

    Args:
        gui: of a teacher.
        notes: by the id of their lesson.
    """

    def __init__(self, gui: viser.GuiApi, notes: Mapping[str, str]) -> None:
        with gui.add_tab_group(order=ORDER).add_tab(tr("Teacher's notes"), viser.Icon.NOTEBOOK):
            self._notes = NotesView(gui, notes)

    def show(self, run: LessonSession) -> None:
        """Bring them up to date. `run`: the lessons."""
        self._notes.show(run)


class TeacherPanel:
    """Everything of a teacher in front of a class.

    Args:
        client: the teacher's.
        act: does what the teacher decides; called on the network's thread.
        address: where the class meets.
        notes: by the id of their lesson; None for somebody who leads without a key.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        act: Callable[[Action], None],
        address: Address,
        notes: Mapping[str, str] | None,
    ) -> None:
        self._gui, self._act = client.gui, act
        gui = client.gui
        tabs = gui.add_tab_group(order=ORDER)
        with tabs.add_tab(tr("Class"), viser.Icon.USERS_GROUP):
            self._heads = gui.add_html("")
            self._mode = ChoiceButtons(
                gui,
                tr("class"),
                (tr("Follow me"), tr("Explore freely")),
                tr("Follow me: everybody sees this stage. Explore freely: everybody has a session of their own."),
                lambda i: act(("follow", "free")[i]),
            )
            self._poll = gui.add_html("")
            self._reveal = self._button(tr("Reveal to everybody"), "reveal", None, viser.Icon.EYE)
            self._again = self._button(tr("Ask again"), "again", "gray", viser.Icon.REFRESH)
            self._pause = self._button(tr("Pause everybody"), "pause", "gray", viser.Icon.HAND_STOP)
        self._notes: NotesView | None = None
        if notes is not None:
            with tabs.add_tab(tr("Notes"), viser.Icon.NOTEBOOK):
                self._notes = NotesView(gui, notes)
        with tabs.add_tab(tr("Join"), viser.Icon.QRCODE):
            gui.add_html(join_html(address))
            self._invite = self._button(tr("Show it on every screen"), "invite", None, viser.Icon.QRCODE)
        for name, key, action in COMMANDS:
            self._command(name, key, action)
        self._shown: ClassState | None = None

    def _button(
        self, label: str, action: Action, color: Literal["gray"] | None, icon: viser.IconName | None
    ) -> viser.GuiButtonHandle:
        button = self._gui.add_button(label, color=color, icon=icon)

        @button.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            del event
            self._act(action)

        return button

    def _command(self, name: str, key: HotkeyKey, action: Action) -> None:
        command = self._gui.add_command(
            tr(name),
            description=tr("Key: {key}", key=f"Alt Shift {key}"),
            hotkey=key,
            modifier="alt+shift",
            icon=viser.Icon.SCHOOL,
        )

        @command.on_trigger
        async def _(event: viser.CommandEvent) -> None:
            del event
            free = self._shown is not None and self._shown.free
            self._act("follow" if action == "free" and free else action)

    def show(self, state: ClassState, run: LessonSession) -> None:
        """Bring everything up to date. `run`: the stage's lessons."""
        if self._notes is not None:
            self._notes.show(run)
        before, self._shown = self._shown, state
        if state == before:
            return
        poll = state.poll
        self._heads.content = heads_html(state.heads, state.free, state.paused, state.waiting)
        self._mode.mark(1 if state.free else 0)
        # Before the reveal the teacher alone sees how the class answers; afterwards it is on the stage, and here too.
        self._poll.content = poll_html(poll, live=not poll.revealed) if poll is not None else ""
        self._reveal.visible = poll is not None and not poll.revealed
        self._reveal.disabled = poll is None or not poll.tally.answered
        self._again.visible = poll is not None and (poll.revealed or not poll.open)
        self._pause.label = tr("Let everybody go on") if state.paused else tr("Pause everybody")
        self._invite.label = tr("Hide it again") if state.inviting else tr("Show it on every screen")
