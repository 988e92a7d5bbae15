"""What a page shows of one session: stage, plots, numbers, lesson.

The controls (`app.page.operation`) are built separately: where all share a session this is shown to all, and one has the controls.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape
from time import perf_counter
from typing import Protocol, TypeVar

import numpy as np
import viser

from app.i18n.reader_language import mark_html
from app.i18n.speaking import spoken, tr
from app.lessons.lesson import NO_LESSONS, LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.page.camera_follow import CameraFollow, lesson_view
from app.page.lessons.answer_boxes import guess_words
from app.page.lessons.elbow_marks import Marks
from app.page.lessons.lesson_panel import NARROW_WIDTH, WIDTH, LessonPanel
from app.page.page_assets import configure_theme, style_sheet
from app.page.panels.contact_card import ContactCard
from app.page.panels.plots_panel import Plots
from app.page.panels.readout import Readout, tip_text
from app.page.panels.replay_bar import replay_style
from app.page.panels.shown_moment import moment_html
from app.page.picture_size import LOW_CANVAS, PictureReport, canvas_size
from app.session.frame import Frame
from app.session.session import Session
from app.session.shown import Shown
from app.settings import Look, PageSettings
from app.stage.camera_view import AHEAD, view_of
from app.stage.stage import Stage
from app.theme import DOCK_WIDTH, NARROW, plots_height, scale
from app.web.viser_internals import aim
from controllers.kinematics import Array
from scenes.rigs import Camera
from scenes.simulation import Simulation


class ViewPart(Protocol):
    """What a feature draws on a page that shows a session; it may fill the view's places."""

    def show(self, frame: Frame) -> None:
        """Draw a frame, before the view does."""
        ...


P = TypeVar("P")


class View:
    """Draws a session on the page of one visitor, or of an audience.

    Args:
        host: the server or one client; viser gives both a `.scene` and a `.gui`.
        session: what is shown.
        clients: the cameras of these clients follow when another experiment or another rig is chosen.
        lessons: of the session; None for a page without.
        look: of an audience, which shares the view; None for the look that the session's settings ask for.
        book: the lessons in the reader's language; None for that of `lessons`.
        folds: whether the controls make room for a lesson on a narrow window.
        tip: returns what the reader can do and watch; None for the visitor's, or the class's.
        overlays: makes the parts that features add.

    Attributes:
        bare: whether the page shows the scene without panels, as a projector does.
        card_attributes: place of parts: return further attributes of the contact card, for scripts.
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
        tip: Callable[[Shown], str] | None = None,
        overlays: "Sequence[Callable[[View], ViewPart]]" = (),
    ) -> None:
        self._host, self._session, self._clients = host, session, clients
        self.lessons = lessons or LessonSession(session, NO_LESSONS)
        self._own_look = look
        self.bare = False
        self.card_attributes: list[Callable[[], Mapping[str, object]]] = []
        self._simulation, self._of_live = session.simulation, True
        page = self._page
        gui = host.gui
        private = isinstance(host, viser.ClientHandle)
        self._style = gui.add_html(style_sheet(page.profile))
        self._moment = gui.add_html("")
        self._readout = Readout(gui, tip or partial(tip_text, operated=private))
        gui.set_panel_label(tr(session.settings.run.experiment.label))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        plots_panel = gui.add_panel()
        self.plots_tab = plots_panel.add_tab(tr("Live plots"), viser.Icon.CHART_LINE)
        with self.plots_tab:
            # A folded panel takes its style sheet with it; either one keeps the other dressed.
            self._style_too = gui.add_html(style_sheet(page.profile), order=-1.0)
            self._moment_too = gui.add_html("", order=-1.0)
            gui.add_html(mark_html(spoken()), order=-1.0)
        self._contact = ContactCard(gui, self.plots_tab)
        self.plots = Plots(gui, self.plots_tab, page, self._plots_height())
        plots_panel.float(x=14, y=-14, width=760)
        if private and canvas_size(host)[1] < LOW_CANVAS:
            plots_panel.minimize()
        self._look = page.theme, page.profile
        self._experiment = experiment_of(session.simulation)
        self._cameras: dict[int, CameraFollow] = {}
        configure_theme(gui, page.theme)
        self.stage = Stage(host.scene)
        narrow = private and canvas_size(host)[0] < NARROW
        self._lesson_width = NARROW_WIDTH if narrow else WIDTH
        width = self._lesson_width * scale(page.profile)
        self.lesson_panel = LessonPanel(
            gui, self.lessons, width, private, narrow and folds, lambda: style_sheet(self._page.profile), book
        )
        self._marks = Marks(host.scene, self.lessons, lambda: self._page)
        self._lesson_step: tuple[object, ...] | None = None
        self._parts = [make(self) for make in overlays]

    def part(self, kind: type[P]) -> P:
        """The part of a class.

        Raises:
            LookupError: this page has none.
        """
        for part in self._parts:
            if isinstance(part, kind):
                return part
        raise LookupError(f"this page has no {kind.__name__}")

    @property
    def _page(self) -> PageSettings:
        page = self._session.settings.page
        return page if self._own_look is None else self._own_look.of(page)

    def _plots_height(self) -> int:
        # An audience's plots are drawn for all of it: the sizes of its windows are not known here.
        height = canvas_size(self._host)[1] if isinstance(self._host, viser.ClientHandle) else 900.0
        return plots_height(height, self._page.profile)

    def welcome(self, client: viser.ClientHandle) -> None:
        """Give a newcomer the view of the present scene, and keep it right while the page finds its layout."""
        self._camera_of(client).welcome(self._simulation, perf_counter())

    def look(self, client: viser.ClientHandle) -> None:
        """Point a client's camera at the present scene, and have it follow what happens there."""
        self._camera_of(client).first_view(self._simulation, perf_counter())

    def _camera_of(self, client: viser.ClientHandle) -> CameraFollow:
        if client.client_id not in self._cameras:
            self._cameras[client.client_id] = CameraFollow(
                client.camera,
                lambda pose: aim(client.camera, pose.eye, pose.look_at, pose.fov),
                self._seen,
                self._way,
                PictureReport(client, self.plots_tab, lambda: (self._page.profile, self.bare)),
            )
        return self._cameras[client.client_id]

    def _seen(self) -> Camera:
        simulation, lessons = self._simulation, self.lessons
        with_lesson = lessons.open and self._of_live
        return lesson_view(simulation, lessons.walk.step.camera) if with_lesson else view_of(simulation)

    def _way(self) -> Array:
        return self._session.way(AHEAD) if self._simulation is self._session.simulation else np.zeros((0, 3))

    def _follow(self, frame: Frame) -> None:
        present = {client.client_id for client in self._clients()}
        self._cameras = {number: follow for number, follow in self._cameras.items() if number in present}
        held = (frame.shown.held or self._session.other_held) is not None
        for follow in self._cameras.values():
            # Those who only watch drag nothing.
            follow.follow(self._simulation, frame.now, held and isinstance(self._host, viser.ClientHandle))

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        page = self._page
        self._simulation, self._of_live = frame.simulation, frame.of_live
        sheet = style_sheet(page.profile)
        self._style.content = self._style_too.content = sheet + replay_style(frame.shown) if frame.replayed else sheet
        if self._look != (page.theme, page.profile):
            self._change_look()
        experiment = experiment_of(frame.simulation)
        if self._experiment != experiment:
            self._experiment = experiment
            self._host.gui.set_panel_label(tr(frame.settings.run.experiment.label))
            for client in self._clients():
                self.look(client)
        self._show_lesson(frame)
        for part in self._parts:
            part.show(frame)
        self._follow(frame)
        self.stage.show(frame, page)
        asking = self.lessons.locked
        self._readout.show(frame, asking)
        self._contact.show(frame, self._card_words, asking)
        self.plots.show(frame)
        self._moment.content = self._moment_too.content = moment_html(frame, self.plots.span)

    def _card_words(self) -> dict[str, object]:
        words = guess_words(self.lessons, self.lesson_panel.guess_box)
        return words | {name: word for attributes in self.card_attributes for name, word in attributes().items()}

    def _show_lesson(self, frame: Frame) -> None:
        lessons = self.lessons
        self._marks.show(frame)
        step = (lessons.walk.lesson.id, lessons.walk.step.id) if lessons.open else None
        self.plots.only = lessons.walk.plots if lessons.open else ()
        if self.lesson_panel.show(frame) or step != self._lesson_step:
            self._lesson_step = step
            for client in self._clients():
                # The panel takes its room from the canvas, so that the view has to be fitted again.
                self.welcome(client)
        contrast = self.lesson_panel.contrast
        names = self.lesson_panel.run_names if contrast is None else contrast.names
        self.plots.run_names = None if names is None else (escape(names[0]), escape(names[1]))

    def _change_look(self) -> None:
        page = self._page
        self._look = page.theme, page.profile
        self._host.gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        self.lesson_panel.set_width(self._lesson_width * scale(page.profile))
        self.plots.dress(page, self._plots_height())
        configure_theme(self._host.gui, page.theme)


def experiment_of(simulation: Simulation) -> tuple[object, ...]:
    """Return what a view of the stage depends on."""
    return simulation.settings.scene, simulation.room.rig, tuple(made.key for made in simulation.room.robots)
