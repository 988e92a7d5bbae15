"""What is seen of one session: stage, plots, numbers, lesson; drawn frame by frame.

What is operated (`app.page.operation`) is built apart, so that a lecture can show this to everybody and hand that to one.
"""

from collections.abc import Callable
from time import perf_counter
from typing import Final

import viser

from app.i18n.reader_language import mark_html
from app.i18n.speaking import spoken, tr
from app.lessons.lesson import NO_LESSONS, LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.page.lessons.elbow_marks import Marks
from app.page.lessons.lesson_camera import lesson_view
from app.page.lessons.lesson_panel import NARROW_WIDTH, WIDTH, LessonPanel
from app.page.panels.plots_panel import Plots
from app.page.panels.readout import Readout
from app.page.panels.replay_bar import ReplayBar, past_style
from app.page.panels.title_bar import titlebar
from app.page.style_sheet import style_sheet
from app.page.window_size import canvas_size
from app.recording.past import Past
from app.session.session import Session
from app.settings import Look, PageSettings
from app.stage.stage import Stage
from app.stage.stage_camera import place_camera, view_of
from app.theme import BRAND, DOCK_WIDTH, NARROW, PLOTS_FRAME, plots_height, scale
from scenes.settings import RunSettings, specs
from scenes.targets import AnglesTarget

SETTLING: Final = 6.0
"""How long a newcomer's camera is corrected when its canvas changes its shape [s of wall time]."""

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
        look: of those who watch a lecture; None for what the session's settings say.
        book: the lessons in the language of those who see it; None for that of `lessons`.
        folds: whether the controls make room for a lesson on a narrow window.

    Attributes:
        keep: in whose hands the past is; while they look at it, everybody who sees this does. None while nobody has it.
    """

    def __init__(
        self,
        host: viser.ViserServer | viser.ClientHandle,
        session: Session,
        clients: Callable[[], list[viser.ClientHandle]],
        lessons: LessonSession | None = None,
        look: Look | None = None,
        book: LessonBook | None = None,
        folds: bool = True,
    ) -> None:
        self._host, self._session, self._clients = host, session, clients
        self.lessons = lessons or LessonSession(session, NO_LESSONS)
        self._own_look = look
        self.keep: ReplayBar | None = None
        self._past: Past | None = None
        self._moved_back = False
        self._before: float | None = None
        self._turn: tuple[object, ...] = ()
        page = self._page
        gui = host.gui
        self._style = gui.add_html(style_sheet(page.profile))
        self._readout = Readout(gui)
        gui.set_panel_label(scene_label(session.settings.run))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        self._plots_panel = gui.add_panel()
        self.plots_tab = self._plots_panel.add_tab(tr("Live plots"), viser.Icon.CHART_LINE)
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
        self._stage = Stage(host.scene)
        private = isinstance(host, viser.ClientHandle)
        narrow = isinstance(host, viser.ClientHandle) and canvas_size(host)[0] < NARROW
        width = (NARROW_WIDTH if narrow else WIDTH) * scale(page.profile)
        self.lesson_panel = LessonPanel(
            gui, self.lessons, width, private, narrow and folds, lambda: style_sheet(self._page.profile), book
        )
        self._marks = Marks(host.scene, session, self.lessons, lambda: self._page)
        self._lesson_step: tuple[object, ...] | None = None

    @property
    def _page(self) -> PageSettings:
        page = self._session.settings.page
        return page if self._own_look is None else self._own_look.of(page)

    def _present_experiment(self) -> tuple[object, ...]:
        simulation = (self._past or self._session).simulation
        return simulation.settings.scene, simulation.room.rig, simulation.room.robots[0].name

    def _plots_height(self) -> int:
        # A lecture's plots are drawn for everybody: for the projector, whose window nobody knows here.
        height = canvas_size(self._host)[1] if isinstance(self._host, viser.ClientHandle) else 900.0
        return plots_height(height, self._page.profile)

    def _configure_theme(self) -> None:
        self._host.gui.configure_theme(
            titlebar_content=titlebar(),
            dark_mode=self._page.theme == "dark",
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
        profile, (width, height) = self._page.profile, canvas_size(client)
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

    def show(self, now: float, moved: bool, lead: "View | None" = None) -> None:
        """Draw a frame.

        Args:
            now: wall time [s].
            moved: whether the simulation made a step since the last one.
            lead: of a lecture, the view of the one who has the controls: what is looked back at there is shown here too.
        """
        session, page = self._session, self._page
        looked_back = self._past is not None
        if self._own_look is None:
            self._moved_back = self._look_back(now)
        elif lead is None:
            self.keep, self._past, self._moved_back = None, None, False
        else:
            self.keep, self._past, self._moved_back = lead.keep, lead._past, lead._moved_back
        moved = self._moved_back or (moved and self._past is None)
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
        self._readout.show(shown, sample, now, page.theme, force=not moved)
        self._plots.choose(page.details)
        self._plots.show(shown, now)

    def _look_back(self, now: float) -> bool:
        """Let the replay play on, if there is one; return whether it stands at another moment than before."""
        elapsed = 0.0 if self._before is None else now - self._before
        self._before = now
        turn = (self.lessons.open, self.lessons.walk.run_id) if self.lessons.open else (False,)
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
        page = self._page
        self._look = page.theme, page.profile
        self._dress()
        self._host.gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        self._plots.dress(page)
        self._configure_theme()

    def _dress(self) -> None:
        past = past_style(self.keep.shelf.loaded if self.keep is not None else "") if self._past is not None else ""
        self._style.content = self._style_too.content = style_sheet(self._page.profile) + past


def scene_label(run: RunSettings) -> str:
    """Return what a person calls the experiment."""
    spec = specs(RunSettings)["scene"]
    return tr(spec.choice_labels[spec.choices.index(run.scene)])
