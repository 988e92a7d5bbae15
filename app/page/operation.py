"""What is operated of one session: controls, handles, keys."""

from typing import Literal

import numpy as np
import viser

from app.i18n.speaking import tr
from app.lessons.lesson import LessonBook
from app.page.handles.gizmos import NUDGE, SWING, Gizmos
from app.page.handles.hand_hover import HandHover
from app.page.lessons.lab_report_box import LabReportBox
from app.page.lessons.lesson_controls import LessonControls
from app.page.panels.controls import Controls
from app.page.panels.hotkeys import HOTKEYS, keys_of
from app.page.panels.link_box import LinkBox
from app.page.panels.microscope_buttons import MicroscopeButtons
from app.page.panels.plot_chooser import DetailsChooser
from app.page.panels.replay_bar import ReplayBar
from app.page.view import View
from app.session import actions
from app.session.clock import next_speed
from app.session.frame import Frame
from app.session.input_source import with_joint
from app.session.session import Session
from controllers.errors import BadSetting


class Operation:
    """What a visitor operates: controls, handles, keys.

    Args:
        client: of the operator.
        session: what is operated.
        view: what is seen of it.
        presenting: whether a class watches: some keys are the presenter's, and leaving the lessons asks first.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, view: View, presenting: bool = False) -> None:
        self._client, self._session, self._view = client, session, view
        self._controls = Controls(client.gui, session, self.post, self._notify, presenting)
        self._keep: ReplayBar | None = None
        with client.gui.add_folder(tr("Keep and replay"), order=self._controls.below_clock, expand_by_default=False):
            if session.background is not None:
                self._keep = ReplayBar(client.gui, session, session.background, self._send, self._notify)
            self._link = LinkBox(client, session, view.lessons)
            self._lab: LabReportBox | None = None
            if self._keep is not None:
                self._lab = LabReportBox(client.gui, session, view.lessons, view.lesson_panel, self._keep.shelf)
        self._chooser = DetailsChooser(client.gui, view.lessons, view.plots_tab, self.post)
        self._microscope = MicroscopeButtons(client.gui, session, view)
        self._gizmos = Gizmos(client.scene, view.stage, session, view.lessons, self.post)
        self._hover = HandHover(client.gui, self.post)
        self._desk = LessonControls(client, session, view.lessons, view.lesson_panel, self._controls, self._notify, presenting)
        for hotkey in keys_of(HOTKEYS, presenting):
            hotkey.add_to(client.gui, self.post)

    def post(self, action: actions.Action) -> None:
        """Have an action done at the beginning of one of the next frames; may be called from any thread."""
        self._session.post(lambda: self.act(action), actions.control_of(action))

    def act(self, action: actions.Action) -> None:
        """Do what a hotkey or a button asks for: the replay's and the lesson's meaning of it go first; on the session's thread."""
        if self._keep is not None and self._keep.take(action):
            return
        if isinstance(action, actions.Reset):
            self._gizmos.forget_drag()
        if self._desk.take(action):
            return
        session = self._session
        match action:
            case actions.Pause():
                session.toggle_pause()
            case actions.SingleStep():
                session.single_step()
            case actions.Reset():
                session.reset()
            case actions.ChangeSpeed(by):
                session.change("speed", next_speed(session.settings.page.speed, by))
            case actions.SetSetting(key, value):
                self._set(key, value)
            case actions.ChooseScene(scene):
                self._set("scene", scene)
            case actions.MoveJoint(joint, angle):
                held = with_joint(session.simulation, session.held, joint, angle)
                if held is not None:
                    session.hold(held)
            case actions.Drag():
                self._gizmos.drag(action)
            case actions.Hover(on):
                self._gizmos.hovered = on
            case actions.Toggle(what):
                self._toggle(what)
            case actions.Nudge():
                self._gizmos.nudge(self._in_view(action))
            case actions.SwingElbow(sign):
                self._gizmos.swing(sign * SWING)
            case actions.FirstView():
                self._view.look(self._client)

    def _set(self, key: str, value: object) -> None:
        try:
            self._session.change(key, value)
        except BadSetting as error:
            self._notify("This value is not possible", str(error))
            self._controls.forget(key)

    def _toggle(self, what: Literal["autopilot", "avoidance", "ghost", "gizmo", "contact"]) -> None:
        session, run, page = self._session, self._session.settings.run, self._session.settings.page
        match what:
            case "autopilot":
                session.change("autopilot", not page.autopilot)
            case "avoidance":
                session.change("law", "unprotected" if run.law.law == "smooth_priority" else "smooth_priority")
            case "gizmo":
                session.change("gizmo", not page.gizmo)
            case "ghost":
                session.change("ghost", "frozen" if page.ghost == "off" else "off")
            case "contact":
                session.change("contact", not page.contact)

    def _in_view(self, nudge: actions.Nudge) -> np.ndarray:
        """Return a nudge (3,) in the world [m]: across the visitor's view, up, and away from them, along the floor."""
        camera = self._client.camera
        forward = np.asarray(camera.look_at, float) - np.asarray(camera.position, float)
        forward[2] = 0.0
        length = float(np.linalg.norm(forward))
        forward = forward / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        across = np.array([forward[1], -forward[0], 0.0])
        return NUDGE * (nudge.right * across + nudge.up * np.array([0.0, 0.0, 1.0]) + nudge.away * forward)

    def _send(self, name: str, content: bytes) -> None:
        self._client.send_file_download(name, content, save_immediately=True)

    def _notify(self, title: str, text: str) -> None:
        self._client.add_notification(tr(title), tr(text), color="orange", auto_close_seconds=8.0)

    def notify(self, title: str, text: str) -> None:
        """Tell the visitor something that no control shows. `title`, `text`: in English."""
        self._notify(title, text)

    def notify_problems(self, problems: tuple[str, ...]) -> None:
        """Name what was wrong with the link that the visitor came by."""
        for problem in problems[:5]:
            self._notify("A part of the link was left out", problem)

    def notify_lessons(self, book: LessonBook) -> None:
        """Name what was wrong with the files of lessons."""
        for problem in book.problems[:5]:
            self._notify("A lesson was left out", str(problem))

    def show(self, frame: Frame) -> None:
        """Bring controls and handles up to date."""
        for panel in (
            self._controls,
            self._chooser,
            self._microscope,
            self._keep,
            self._link,
            self._desk,
            self._lab,
            self._gizmos,
        ):
            if panel is not None:
                panel.show(frame)
        self._hover.show(self._gizmos.hand)

    def close(self) -> None:
        """Go back to live, and drop every export that is being made."""
        if self._keep is not None:
            self._keep.close()
