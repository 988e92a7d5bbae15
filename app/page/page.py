"""One session's page, put together from its parts and drawn frame by frame.

What is seen (stage, plots, numbers) and what is operated (controls, handles, keys) are built apart, so that a lecture can show
the first to everybody and hand the second to one.
"""

import re
from collections.abc import Callable
from time import perf_counter
from typing import Final

import numpy as np
import viser

from app.keep.past import Past
from app.languages.speaking import say, spoken
from app.languages.visitor import mark_html
from app.lessons.lesson import LessonBook
from app.page.camera import place_camera, view_of
from app.page.controls import Controls
from app.page.gizmos import NUDGE, SWING, Gizmos
from app.page.keep import ReplayBar, past_style
from app.page.keys import HOTKEYS
from app.page.lab import LabDesk
from app.page.lesson_camera import lesson_view
from app.page.lesson_desk import LessonDesk
from app.page.lesson_marks import Marks
from app.page.lesson_panel import NARROW_WIDTH, WIDTH, LessonPanel
from app.page.lesson_run import LessonRun
from app.page.link import LinkBox
from app.page.logo import titlebar
from app.page.plots import DetailsChooser, Plots
from app.page.readout import Readout
from app.page.stage import Stage
from app.page.theme import BRAND, DOCK_WIDTH, NARROW, PLOTS_FRAME, plots_height, scale, style_sheet
from app.server.request import request_query
from app.session import Session
from scenes.settings import RunSettings, specs
from scenes.targets import AnglesTarget

SETTLING: Final = 6.0
"""How long a newcomer's camera is corrected when its canvas changes its shape [s of wall time]."""

TITLEBAR: Final = 47.0
"""Height of the bar at the top [CSS px]."""

LOW_CANVAS: Final = 520.0
"""On a canvas lower than this [px] the plots wait folded up until they are asked for, …"""

PLOTS_BAR: Final = 60.0
"""… as a bar of this height [CSS px]."""

PHONE_ASPECT: Final = 0.62
"""A canvas narrower than this is a phone's, whose lower part is a sheet …"""

PHONE_SHEET: Final = 0.48
"""… of this share of its height."""


class View:
    """What is seen of a session, on the page of one visitor or of everybody.

    Args:
        host: the server or one client; viser gives both a `.scene` and a `.gui`.
        session: what is shown.
        clients: whose cameras follow when another experiment or another rig is chosen.
        lessons: of the session; None for a page without.

    Attributes:
        keep: in whose hands the past is; while they look at it, everybody who sees this does. None while nobody has it.
    """

    def __init__(
        self,
        host: viser.ViserServer | viser.ClientHandle,
        session: Session,
        clients: Callable[[], list[viser.ClientHandle]],
        lessons: LessonRun | None = None,
    ) -> None:
        self._host, self._session, self._clients = host, session, clients
        self.lessons = lessons or LessonRun(session, LessonBook((), ()))
        self.keep: ReplayBar | None = None
        self._past: Past | None = None
        self._before: float | None = None
        self._turn: tuple[object, ...] = ()
        page = session.settings.page
        gui = host.gui
        self._style = gui.add_html(style_sheet(page.profile))
        self._readout = Readout(gui)
        gui.set_panel_label(scene_label(session.settings.run))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        self._plots_panel = gui.add_panel()
        self.plots_tab = self._plots_panel.add_tab(say("Live plots"), viser.Icon.CHART_LINE)
        with self.plots_tab:
            # A folded panel takes its style sheet with it; either one keeps the other dressed.
            self._style_too = gui.add_html(style_sheet(page.profile), order=-1.0)
            gui.add_html(mark_html(spoken()), order=-1.0)
        self._plots = Plots(gui, self.plots_tab, page, self._plots_height())
        self._plots_panel.float(x=14, y=-14, width=760)
        if isinstance(host, viser.ClientHandle) and canvas_size(host)[1] < LOW_CANVAS:
            self._plots_panel.minimize()
        self._look = page.theme, page.profile
        self._experiment = self._present_experiment()
        self._settling: dict[int, tuple[float, viser.ClientHandle, float]] = {}
        self._configure_theme()
        self._stage = Stage(host.scene, session.simulation, page)
        private = isinstance(host, viser.ClientHandle)
        narrow = isinstance(host, viser.ClientHandle) and canvas_size(host)[0] < NARROW
        width = (NARROW_WIDTH if narrow else WIDTH) * scale(page.profile)
        self.lesson_panel = LessonPanel(
            gui, self.lessons, width, private, narrow, lambda: style_sheet(session.settings.page.profile)
        )
        self._marks = Marks(host.scene, session, self.lessons)
        self._lesson_step: tuple[object, ...] | None = None

    def _present_experiment(self) -> tuple[object, ...]:
        simulation = (self._past or self._session).simulation
        return simulation.settings.scene, simulation.room.rig, simulation.room.robots[0].name

    def _plots_height(self) -> int:
        # A lecture's plots are drawn for everybody: for the projector, whose window nobody knows here.
        height = canvas_size(self._host)[1] if isinstance(self._host, viser.ClientHandle) else 900.0
        return plots_height(height, self._session.settings.page.profile)

    def _configure_theme(self) -> None:
        self._host.gui.configure_theme(
            titlebar_content=titlebar(),
            dark_mode=self._session.settings.page.theme == "dark",
            show_logo=False,
            show_share_button=False,
            brand_color=BRAND,
        )

    def welcome(self, client: viser.ClientHandle) -> None:
        """Give a newcomer the view of the present scene, and keep it right while the page finds its layout."""
        self.look(client)
        self._settling[client.client_id] = perf_counter() + SETTLING, client, client.camera.aspect

    def look(self, client: viser.ClientHandle) -> None:
        """Point a client's camera at the present scene."""
        profile, (width, height) = self._session.settings.page.profile, canvas_size(client)
        panel = self._plots_height() + PLOTS_FRAME * scale(profile) if height >= LOW_CANVAS else PLOTS_BAR
        covered = PHONE_SHEET if width / height < PHONE_ASPECT else min(panel / height, 0.6)
        simulation, lessons = (self._past or self._session).simulation, self.lessons
        with_lesson = lessons.open and self._past is None
        view = lesson_view(simulation, lessons.walk.step.camera) if with_lesson else view_of(simulation)
        place_camera(client, view, covered)

    def _settle(self, now: float) -> None:
        # The docked panel narrows the canvas a moment after the page has opened, and only the browser knows by how much.
        for number, (deadline, client, aspect) in list(self._settling.items()):
            if now > deadline:
                del self._settling[number]
            elif client.camera.aspect != aspect:
                self.look(client)
                self._settling[number] = deadline, client, client.camera.aspect

    def show(self, now: float, moved: bool) -> None:
        """Draw a frame. `now`: wall time [s]; `moved`: whether the simulation made a step since the last one."""
        session, page = self._session, self._session.settings.page
        looked_back = self._past is not None
        moved = self._look_back(now) or (moved and self._past is None)
        if self._look != (page.theme, page.profile):
            self._change_look()
        elif looked_back != (self._past is not None):
            self._dress()
        shown = self._past or session
        experiment = self._present_experiment()
        if self._experiment != experiment:
            self._experiment = experiment
            self._host.gui.set_panel_label(scene_label(shown.settings.run))
            for client in self._clients():
                self.look(client)
        self._show_lesson(now)
        self._settle(now)
        sample = shown.simulation.sample()
        wish = shown.target() if shown.settings.run.scene == "imitation" else None
        angles = wish.angles if isinstance(wish, AnglesTarget) else None
        self._stage.show(shown.simulation, sample, page, shown.ghost, angles)
        self._readout.show(shown, sample, now, force=not moved)
        self._plots.choose(page.details)
        self._plots.show(shown, now)

    def _look_back(self, now: float) -> bool:
        """Let the replay play on, if there is one; return whether it stands at another moment than before."""
        elapsed = 0.0 if self._before is None else now - self._before
        self._before = now
        turn = (self.lessons.open, self.lessons.walk.turn) if self.lessons.open else (False,)
        if turn != self._turn:
            self._turn = turn
            if self.keep is not None and self.keep.watching:
                self.keep.leave()
        moved = self.keep is not None and self.keep.advance(elapsed)
        self._past = self.keep.past if self.keep is not None else None
        return moved

    def _show_lesson(self, now: float) -> None:
        lessons = self.lessons
        self._marks.show(now)
        step = (lessons.walk.lesson.id, lessons.walk.step.id) if lessons.open else None
        self._plots.only(lessons.walk.step.plots if lessons.open else ())
        if self.lesson_panel.show(now) or step != self._lesson_step:
            self._lesson_step = step
            for client in self._clients():
                # The panel takes its room from the canvas, so that the view has to find its place anew.
                self.welcome(client)

    def _change_look(self) -> None:
        page = self._session.settings.page
        self._look = page.theme, page.profile
        self._dress()
        self._host.gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        self._plots.dress(page)
        self._configure_theme()

    def _dress(self) -> None:
        past = past_style(self.keep.shelf.loaded if self.keep is not None else "") if self._past is not None else ""
        self._style.content = self._style_too.content = style_sheet(self._session.settings.page.profile) + past


def scene_label(run: RunSettings) -> str:
    """Return what a person calls the experiment."""
    spec = specs(RunSettings)["scene"]
    return say(spec.choice_labels[spec.choices.index(run.scene)])


def canvas_size(client: viser.ClientHandle) -> tuple[float, float]:
    """Return width and height of a client's window below the title bar, as they were when it came [CSS px].

    The camera's own size is in device pixels, and of a canvas that has not found its place yet.
    """
    given = re.fullmatch(r"(\d{2,5})x(\d{2,5})", request_query(client).get("window", ""))
    if given is None:
        return max(client.camera.image_width, 1.0), max(client.camera.image_height, 1.0)
    return float(given[1]), max(float(given[2]) - TITLEBAR, 1.0)


class Operation:
    """What a visitor operates: controls, handles, keys.

    Args:
        client: whose hands it is in.
        session: what is operated.
        view: what is seen of it.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, view: View) -> None:
        self._client, self._session, self._view = client, session, view
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
        with client.gui.add_folder(say("Keep and replay"), order=self._controls.below_clock, expand_by_default=False):
            if session.background is not None:
                self._keep = view.keep = ReplayBar(client.gui, session, session.background, self._send, self._notify)
            self._link = LinkBox(client, session, view.lessons)
            self._lab: LabDesk | None = None
            if self._keep is not None:
                self._lab = LabDesk(client.gui, session, view.lessons, view.lesson_panel, self._keep.shelf)
        self._chooser = DetailsChooser(client.gui, session, view.plots_tab)
        self._gizmos = Gizmos(client.scene, session)
        self._desk = LessonDesk(client, session, view.lessons, view.lesson_panel, self._notify)
        self._commands = [self._command(hotkey.action) for hotkey in HOTKEYS]

    def _command(self, action: str) -> viser.CommandHandle:
        hotkey = next(h for h in HOTKEYS if h.action == action)
        command = self._client.gui.add_command(
            hotkey.title,
            description=say("Key: {key}", key=hotkey.shown) if hotkey.relayed else None,
            hotkey=hotkey.key,
            modifier=hotkey.modifier,
            icon=hotkey.icon,
        )

        @command.on_trigger
        async def _(event: viser.CommandEvent) -> None:
            del event
            self._session.post(lambda: self.act(action))

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
        self._client.add_notification(say(title), say(text), color="orange", auto_close_seconds=8.0)

    def notify_problems(self, problems: tuple[str, ...]) -> None:
        """Name what was wrong with the link that the visitor came by."""
        for problem in problems[:5]:
            self._notify("A part of the link was left out", problem)

    def notify_lessons(self, book: LessonBook) -> None:
        """Name what was wrong with the files of lessons."""
        for problem in book.problems[:5]:
            self._notify("A lesson was left out", str(problem))

    def show(self) -> None:
        """Bring controls and handles up to date with the session."""
        past = self._keep.past if self._keep is not None else None
        self._controls.show((past or self._session).paused)
        self._chooser.show()
        if self._keep is not None:
            self._keep.show()
        self._link.show(perf_counter())
        self._desk.show()
        if self._lab is not None:
            self._lab.show()
        # Nobody can take hold of what is over.
        self._gizmos.offer(past is None and not self._view.lessons.hands_off)
        self._gizmos.show()

    def close(self) -> None:
        """Let go of the past, and of everything that is being made; for whoever leaves."""
        if self._keep is not None:
            self._view.keep = None
            self._keep.close()
