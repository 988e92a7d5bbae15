"""What is operated of one session: controls, handles, keys."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final, Literal

import viser

from app.i18n.speaking import tr
from app.lessons.lesson import LessonBook
from app.page.handles.gizmos import Gizmos
from app.page.lessons.duel_box import DuelBox
from app.page.lessons.lab_report_box import AskReport, LabReportBox
from app.page.lessons.lesson_controls import LessonControls
from app.page.panels import PagePanel
from app.page.panels.controls import Controls
from app.page.panels.hotkeys import hotkeys, keys_of
from app.page.panels.law_editor import LawEditor
from app.page.panels.lever import Lever
from app.page.panels.link_box import InviteBox, LinkBox
from app.page.panels.plot_controls import DetailsChooser, MicroscopeButtons, MomentChooser
from app.page.panels.replay_bar import ReplayBar
from app.page.panels.scene_words import SceneWords
from app.page.panels.source_chooser import TakePerson
from app.page.picture_size import PHONE, canvas_size
from app.page.view import View
from app.session import actions
from app.session.frame import Frame
from app.session.session import Session
from controllers.errors import BadSetting
from scenes.laws import DEFAULT_LAW, NO_AVOIDANCE
from scenes.settings import values

CALM: Final = 0.1
"""Wall time between two looks at the controls while nothing is done with them [s]."""

PANELS: Final[list[Callable[[viser.ClientHandle, Session, View], PagePanel]]] = [
    Lever,
    DetailsChooser,
    MicroscopeButtons,
    MomentChooser,
    SceneWords,
]
"""The panels that need nothing but the session and the view; a further one is one more entry."""


class Operation:
    """What a visitor operates: controls, handles, keys.

    Args:
        client: of the operator.
        session: what is operated.
        view: what is seen of it.
        presenting: whether a class watches: some keys are the presenter's, and leaving the lessons asks first.
        whole: whether all settings are shown, also while no lesson is open.
        invites: whether a second person can be invited.
        edited: file of a law that the operator may edit; None for none.

    Attributes:
        whole: the same, as the visitor has asked for since.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        view: View,
        presenting: bool = False,
        whole: bool = True,
        invites: bool = False,
        edited: Path | None = None,
    ) -> None:
        self.whole, self._presenting = whole, presenting
        self._client, self._session, self._view = client, session, view
        self._controls = Controls(client.gui, session, presenting, canvas_size(client)[0] <= PHONE)
        self._keep = client.gui.add_folder(tr("Keep and replay"), order=self._controls.below_clock, expand_by_default=False)
        with self._keep:
            send = partial(client.send_file_download, save_immediately=True)
            self._replay_bar = ReplayBar(client.gui, session, send)
            self._link = LinkBox(client, session, view.lessons)
            self._lab = LabReportBox(client.gui, session, view, self._replay_bar.exports)
        self._panels = [make(client, session, view) for make in PANELS]
        self._panels.append(DuelBox(client, session, view, self._replay_bar.exports))
        self._invite = InviteBox(client, session, self._controls.below_clock) if invites else None
        if self._invite is not None:
            self._panels.append(self._invite)
        if edited is not None:
            self._panels.append(LawEditor(client.gui, session, view, self._controls, edited))
        self._gizmos = Gizmos(client, session, lambda: view.stage.yours, lambda: view.lessons.hands_off)
        self._lesson_controls = LessonControls(client, session, view, self._controls, presenting)
        for hotkey in keys_of(hotkeys(), presenting):
            hotkey.add_to(client.gui, session.post)
        session.takers["page"] = self.take
        self._next = 0.0

    def take(self, action: actions.Action) -> bool:
        """Do what a hotkey, a button or a handle asks for: the replay's and the lesson's meaning of it go first, on the session's thread.

        Returns:
            Whether it was done; otherwise it is the session's own.
        """
        if self._replay_bar.take(action):
            return True
        if isinstance(action, actions.Reset):
            self._gizmos.forget_drag()
        if any(panel.take(action) for panel in self._panels) or self._lesson_controls.take(action):
            return True
        match action:
            case actions.SetSetting(key, value):
                self._set(key, value)
            case actions.Digit():
                self._set("scene", action.scene)
            case TakePerson():
                self._controls.sources.take_person(action)
            case AskReport(one):
                self._lab.ask(one)
            case actions.Toggle(what):
                self._toggle(what)
            case actions.ShowAll(whole):
                self.whole = whole
            case actions.FirstView():
                self._view.look(self._client)
            case _:
                return self._gizmos.take(action)
        return True

    def _set(self, key: str, value: object) -> None:
        try:
            self._session.change(key, value)
        except BadSetting as error:
            self._session.notify("This value is not possible", str(error))
            self._controls.write_again()

    def _toggle(self, what: Literal["autopilot", "avoidance", "ghost", "gizmo", "contact"]) -> None:
        session = self._session
        present = values(session.settings)
        match what:
            case "avoidance":
                session.change("law", NO_AVOIDANCE if present["law"] == DEFAULT_LAW else DEFAULT_LAW)
            case "ghost":
                session.change("ghost", "frozen" if present["ghost"] == "off" else "off")
            case _:
                session.change(what, not present[what])

    def notify_problems(self, problems: tuple[str, ...]) -> None:
        """Name what was wrong with the link that the visitor came by."""
        for problem in problems[:5]:
            self._session.notify("A part of the link was left out", problem)

    def notify_lessons(self, book: LessonBook) -> None:
        """Name what was wrong with the files of lessons."""
        for problem in book.problems[:5]:
            self._session.notify("A lesson file has a fault", str(problem))

    def show(self, frame: Frame, stirred: bool = True) -> None:
        """Bring handles and controls up to date, and show the session's notices.

        Args:
            stirred: whether anything was done, or has come, since the last frame.
        """
        self._gizmos.show(frame)
        notices = self._session.notices
        while notices:
            title, text = notices.popleft()
            self._client.add_notification(tr(title), tr(text), color="orange", auto_close_seconds=8.0)
        if frame.now < self._next and not (stirred or frame.pace.paused or frame.replayed):
            return
        self._next = frame.after(CALM)
        lessons = self._view.lessons
        plays = not (self._presenting or lessons.open or lessons.listing or frame.replayed)
        self._controls.fold(self.whole, plays)
        self._keep.visible = self.whole or not plays
        if self._invite is not None:
            self._invite.offered = self._keep.visible
        for panel in (self._controls, *self._panels, self._replay_bar, self._link, self._lesson_controls, self._lab):
            panel.show(frame)

    def close(self) -> None:
        """Operate the session no more: go back to live, and drop every export that is being made."""
        self._session.takers.pop("page", None)
        self._replay_bar.close()
