"""The teacher's panel, which only teachers' browsers receive."""

from collections.abc import Callable, Mapping
from time import monotonic
from typing import Final, Literal

import viser

from app.features.classroom.ballots import VoterCount
from app.features.classroom.class_downloads import ClassDownloads
from app.features.classroom.classroom import Poll
from app.features.classroom.classroom_html import heads_html, poll_html, voters_html
from app.features.lecture.lecture_options import MOST_STUDENTS
from app.features.lecture.page_lines import TAKE_OVER, banner_html, join_html, joined_text
from app.features.lecture.presenter_keys import PRESENTER_KEYS
from app.features.lecture.screen_panel import ScreenPanel, covers_html
from app.features.lecture.teacher_control import Teach, TeacherAction, TeacherControl
from app.features.lessons.bookmark import LONGEST_PACE, Bookmark
from app.features.lessons.panel.teachers_tab import ORDER, NotesView, TeachersTab
from app.i18n.speaking import N_, tr
from app.page.panels.choice_buttons import ChoiceButtons
from app.text.templates import macros
from app.web.address import Address
from app.web.control_events import on_entry, on_press
from app.web.viser_internals import HotkeyKey

COMMANDS: Final[tuple[tuple[str, HotkeyKey, TeacherAction], ...]] = (
    (N_("Class: follow me, or explore freely"), "F", "free"),
    (N_("Class: pause everybody, or continue"), "P", "pause"),
    (N_("Class: reveal the answers to everybody"), "V", "reveal"),
    (N_("Class: ask again"), "Q", "again"),
    (N_("Class: the address on the screen, or away"), "J", "invite"),
)
"""Label, key with Alt and Shift, action."""

LONGEST_QUOTE: Final = 40
"""Longest typed list of reasons [characters]."""

PERIOD: Final = 1.0
"""Period of the board's update [s]."""

NO_ONE: Final[str] = "–"


class BoardPanel:
    """Folder with the board, in the caller's open tab."""

    def __init__(self, gui: viser.GuiApi, control: TeacherControl) -> None:
        self._control, self._classroom, self._lessons, act = (
            control,
            control.classroom,
            control.lessons,
            control.post,
        )
        self._next = 0.0
        self._folder = gui.add_folder(tr("Who is where"), visible=False)
        with self._folder:
            hint = tr("Open steps, for example 2 or 2-3. Leave empty to open all.")
            pace = gui.add_text(tr("only steps"), "", hint=hint)
            self._pace, self._table = gui.add_html(""), gui.add_html("")
            self._student = gui.add_dropdown(tr("student"), (NO_ONE,))
            answer = gui.add_button(tr("Show this one"), icon=viser.Icon.PRESENTATION)
            run = gui.add_button(tr("Show this run"), icon=viser.Icon.PLAYER_PLAY, color="gray")
        on_entry(pace, lambda text: act("pace", text[:LONGEST_PACE]))
        on_press(answer, lambda: act("show", self._student.value))
        on_press(run, lambda: act("show run", self._student.value))

    def show(self) -> None:
        classroom, lessons, now = self._classroom, self._lessons, monotonic()
        self._folder.visible = classroom.free
        if not classroom.free or now < self._next:
            return
        self._next = now + PERIOD
        walk, pace = lessons.walk, classroom.pace
        place = walk.lesson.id, walk.step_index
        at = Bookmark(walk.book).at(*(place if pace is None else (pace.lesson, pace.nearest(*place))))
        rows = classroom.board.rows(classroom.groups, at, now)
        said = tr("Every step is open.") if pace is None else tr(pace.words)
        self._pace.content = macros("page/panels/pills.html").note(
            " ".join(filter(None, (tr(self._control.refused), said)))
        )
        self._table.content = macros("features/lecture/board.html").board(rows, len(at.lesson.steps))
        names = NO_ONE, *(row.name for row in rows)
        if self._student.value not in names:
            # A student who is away for a moment stays selected.
            names += (self._student.value,)
        if names != tuple(self._student.options):
            self._student.options = names


class TeacherPanel:
    """A teacher's tabs. `notes`: Markdown by lesson id; None without a key."""

    def __init__(
        self,
        client: viser.ClientHandle,
        control: TeacherControl,
        address: Address,
        notes: Mapping[str, str] | None,
        downloads: ClassDownloads,
    ) -> None:
        self._gui, self._control, self._downloads = client.gui, control, downloads
        gui, act = client.gui, control.post
        # Above the tabs, so always visible.
        self._covers = gui.add_html("", order=ORDER - 0.5)
        tabs = gui.add_tab_group(order=ORDER)
        with tabs.add_tab(tr("Class"), viser.Icon.USERS_GROUP):
            self._heads = gui.add_html("")
            self._mode = ChoiceButtons(
                gui,
                "class",
                {"Follow me": Teach("follow"), "Explore freely": Teach("free")},
                "Follow me: everybody sees this shared session. Explore freely: everybody has a session of their own.",
                control.session.post,
            )
            self._board = BoardPanel(gui, control)
            self._poll, self._voters = gui.add_html(""), gui.add_html("")
            self._reasons = gui.add_html("")
            self._quoted = gui.add_text(
                tr("show reasons"),
                "",
                visible=False,
                hint=tr("Numbers of reasons for the screen: 1, 4. Empty: none."),
            )
            on_entry(self._quoted, lambda text: act("quote", text[:LONGEST_QUOTE]))
            self._pages = self._button(
                tr("Leave out votes without a page"), "pages", "gray", viser.Icon.FILTER
            )
            self._reveal = self._button(tr("Reveal to everybody"), "reveal", None, viser.Icon.EYE)
            self._again = self._button(tr("Ask again"), "again", "gray", viser.Icon.REFRESH)
            self._pause = self._button(tr("Pause everybody"), "pause", "gray", viser.Icon.HAND_STOP)
            downloads.build()
        with tabs.add_tab(tr("Screen"), viser.Icon.PRESENTATION):
            self._screen = ScreenPanel(gui, control, notes is not None)
        self._notes: NotesView | None = None
        if notes is not None:
            with tabs.add_tab(tr("Notes"), viser.Icon.NOTEBOOK):
                self._notes = NotesView(gui, notes)
        with tabs.add_tab(tr("Join"), viser.Icon.QRCODE):
            gui.add_html(join_html(address))
            self._joined = gui.add_html("")
            number = gui.add_number(
                tr("students expected"), control.presenter.expected, min=0, max=MOST_STUDENTS, step=1
            )
            on_entry(number, lambda count: act("expect", str(int(count))))
            self._invite = ChoiceButtons(
                gui,
                "shown",
                {
                    "Nowhere": Teach("hide"),
                    "On the screen": Teach("invite"),
                    "On every page": Teach("invite all"),
                },
                "On the screen: where there is no projector, this page shows it. × here or Page ↓ takes it away everywhere.",
                control.session.post,
            )
        for name, key, action in COMMANDS:
            self._command(name, key, action)
        for hotkey in PRESENTER_KEYS:
            hotkey.add_to(gui, act)
        self._free = self.inviting = False
        self._asked: tuple[str, str] | None = None
        self._shown: object = None

    def _button(
        self, label: str, action: TeacherAction, color: Literal["gray"] | None, icon: viser.IconName
    ) -> viser.GuiButtonHandle:
        return on_press(
            self._gui.add_button(label, color=color, icon=icon), lambda: self._control.post(action)
        )

    def _command(self, name: str, key: HotkeyKey, action: TeacherAction) -> None:
        command = self._gui.add_command(
            tr(name),
            description=tr("Key: {key}", key=f"Alt Shift {key}"),
            hotkey=key,
            modifier="alt+shift",
            icon=viser.Icon.SCHOOL,
        )

        def act() -> None:
            undo: TeacherAction = "follow" if action == "free" else "hide"
            undoes = (action == "free" and self._free) or (action == "invite" and self.inviting)
            self._control.post(undo if undoes else action)

        on_press(command, act)

    def show(self, poll: Poll | None) -> None:
        presenter, classroom = self._control.presenter, self._control.classroom
        self._screen.show()
        self._board.show()
        self.inviting = presenter.inviting != ""
        self._invite.show(2 if presenter.inviting == "all" else int(self.inviting))
        self._covers.content = covers_html(presenter)
        self._joined.content = macros("page/panels/pills.html").note(
            joined_text(classroom.heads[0], presenter.expected)
        )
        if self._notes is not None:
            self._notes.show(self._control.lessons)
        self._downloads.show()
        ballots = classroom.ballots
        reasons = {} if poll is None else ballots.reasons(poll.question)
        voters = VoterCount() if poll is None else ballots.voters_of(poll.question)
        heads = (
            classroom.heads,
            presenter.expected,
            classroom.places.most,
            classroom.waiting,
            len(classroom.work.hand_ins),
        )
        shown = (
            heads,
            classroom.load,
            classroom.free,
            classroom.paused,
            poll,
            voters,
            ballots.pages_only,
            reasons,
        )
        if shown == self._shown:
            return
        self._shown, self._free = shown, classroom.free
        self._heads.content = heads_html(classroom, presenter.expected)
        self._mode.show(1 if classroom.free else 0)
        # Before the reveal only the teacher sees the tally.
        self._poll.content = poll_html(poll, live=not poll.revealed) if poll is not None else ""
        self._voters.content = voters_html(voters)
        self._reasons.content = macros("features/classroom/poll.html").reasons(reasons) if reasons else ""
        self._quoted.visible = bool(reasons)
        if not presenter.quotes and poll is not None and poll.question != self._asked:
            self._asked, self._quoted.value = poll.question, ""
        self._pages.visible = voters.pageless > 0
        self._pages.label = (
            tr("Count votes without a page") if ballots.pages_only else tr("Leave out votes without a page")
        )
        self._reveal.visible = poll is not None and not poll.revealed
        self._reveal.disabled = poll is None or not poll.tally.handed_in
        # Two rounds with a talk between them: the first one need not be revealed.
        self._again.visible = poll is not None and (not poll.open or poll.tally.handed_in > 0)
        self._pause.label = tr("Continue for everybody") if classroom.paused else tr("Pause everybody")

    def close(self) -> None:
        self._downloads.close()


class AssistantPanel:
    """Tab of a teacher while another one leads. Calls `take_over` on the network's thread."""

    def __init__(
        self,
        gui: viser.GuiApi,
        control: TeacherControl,
        notes: Mapping[str, str] | None,
        take_over: Callable[[], None],
    ) -> None:
        self._control = control
        said = tr("You assist: another tab of the teacher leads. One tab leads at a time.")
        gui.add_html(banner_html("wait", said), order=ORDER - 0.5)
        on_press(gui.add_button(tr(TAKE_OVER), order=ORDER - 0.4, icon=viser.Icon.HAND_GRAB), take_over)
        self._notes = None if notes is None else TeachersTab(gui, notes)

    def show(self, poll: Poll | None) -> None:
        if self._notes is not None and self._control.classroom.load is not None:
            self._notes.show(self._control.lessons, self._control.classroom.load)
