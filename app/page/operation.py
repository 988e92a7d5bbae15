"""What is operated of one session: controls, handles, keys."""

from collections.abc import Callable

import numpy as np
import viser

from app.i18n.speaking import tr
from app.lessons.lesson import LessonBook
from app.page.handles.gizmos import NUDGE, SWING, Gizmos
from app.page.lessons.lab_report_box import LabReportBox
from app.page.lessons.lesson_controls import LessonControls
from app.page.panels.controls import Controls
from app.page.panels.hotkeys import HOTKEYS, control_of
from app.page.panels.link_box import LinkBox
from app.page.panels.plots_panel import DetailsChooser
from app.page.panels.replay_bar import ReplayBar
from app.page.view import View
from app.session.frame import Frame
from app.session.session import Session
from scenes.settings import RunSettings, specs


class Operation:
    """What a visitor operates: controls, handles, keys.

    Args:
        client: whose hands it is in.
        session: what is operated.
        view: what is seen of it.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, view: View) -> None:
        self._client, self._session, self._lessons = client, session, view.lessons
        self._actions: dict[str, Callable[[], None]] = {
            "pause": session.toggle_pause,
            "step": session.single_step,
            "slower": lambda: session.change_speed(-1),
            "faster": lambda: session.change_speed(1),
            "reset": self._reset,
            "autopilot": lambda: session.change("autopilot", not session.settings.page.autopilot),
            "view": lambda: view.look(client),
            "law": lambda: session.change(
                "law", "unprotected" if session.settings.run.law.law == "smooth_priority" else "smooth_priority"
            ),
            "ghost": lambda: session.change("ghost", "frozen" if session.settings.page.ghost == "off" else "off"),
        }
        for choice in specs(RunSettings)["scene"].choices:
            self._actions[choice] = lambda choice=choice: session.change("scene", choice)
        for name, right, up, away in (
            ("left", -1, 0, 0),
            ("right", 1, 0, 0),
            ("up", 0, 1, 0),
            ("down", 0, -1, 0),
            ("away", 0, 0, 1),
            ("near", 0, 0, -1),
        ):
            self._actions[name] = lambda way=(right, up, away): self._gizmos.nudge(self._in_view(*way))
        for name, sign in (("elbow_up", 1.0), ("elbow_down", -1.0)):
            self._actions[name] = lambda angle=sign * SWING: self._gizmos.swing(angle)
        self._controls = Controls(client.gui, session, self.act, self._notify)
        self._keep: ReplayBar | None = None
        with client.gui.add_folder(tr("Keep and replay"), order=self._controls.below_clock, expand_by_default=False):
            if session.background is not None:
                self._keep = ReplayBar(client.gui, session, session.background, self._send, self._notify)
            self._link = LinkBox(client, session, view.lessons)
            self._lab: LabReportBox | None = None
            if self._keep is not None:
                self._lab = LabReportBox(client.gui, session, view.lessons, view.lesson_panel, self._keep.shelf)
        self._chooser = DetailsChooser(client.gui, session, view.plots_tab)
        self._gizmos = Gizmos(client.scene, session)
        self._desk = LessonControls(client, session, view.lessons, view.lesson_panel, self._notify)
        self._commands = [self._command(hotkey.action) for hotkey in HOTKEYS]

    def _command(self, action: str) -> viser.CommandHandle:
        hotkey = next(h for h in HOTKEYS if h.action == action)
        command = self._client.gui.add_command(
            hotkey.title,
            description=tr("Key: {key}", key=hotkey.shown) if hotkey.relayed else None,
            hotkey=hotkey.key,
            modifier=hotkey.modifier,
            icon=hotkey.icon,
        )

        @command.on_trigger
        async def _(event: viser.CommandEvent) -> None:
            del event
            self._session.post(lambda: self.act(action), control_of(action))

        return command

    def act(self, action: str) -> None:
        """Do what a hotkey or a button stands for; on the session's thread."""
        if self._keep is not None and self._keep.take(action):
            return
        if self._desk.take(action):
            if action == "reset":
                self._gizmos.forget_drag()
            return
        self._actions[action]()

    def _reset(self) -> None:
        self._session.reset()
        self._gizmos.forget_drag()

    def _in_view(self, right: float, up: float, away: float) -> np.ndarray:
        """Return a step (3,) [m] as the visitor sees it: across the view, up, and away from them, along the floor."""
        camera = self._client.camera
        forward = np.asarray(camera.look_at, float) - np.asarray(camera.position, float)
        forward[2] = 0.0
        length = float(np.linalg.norm(forward))
        forward = forward / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        across = np.array([forward[1], -forward[0], 0.0])
        return NUDGE * (right * across + up * np.array([0.0, 0.0, 1.0]) + away * forward)

    def _send(self, name: str, content: bytes) -> None:
        self._client.send_file_download(name, content, save_immediately=True)

    def _notify(self, title: str, text: str) -> None:
        self._client.add_notification(tr(title), tr(text), color="orange", auto_close_seconds=8.0)

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
        self._controls.show(frame)
        self._chooser.show(self._lessons.open)
        if self._keep is not None:
            self._keep.show(frame)
        self._link.show(frame)
        self._desk.show(frame)
        if self._lab is not None:
            self._lab.show()
        # A replay cannot be taken hold of.
        self._gizmos.offer(not frame.replayed and not self._lessons.hands_off)
        self._gizmos.show()

    def close(self) -> None:
        """Go back to live, and drop every export that is being made."""
        if self._keep is not None:
            self._keep.close()
