"""View of one session, without controls: a shared session has many views and one operator."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import perf_counter
from typing import Protocol, TypeVar

import numpy as np
import viser

from app.i18n.reader_language import mark_html
from app.i18n.speaking import spoken, tr
from app.page.camera_follow import CameraFollow
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
from app.settings import Language, Look, PageSettings
from app.stage.camera_view import AHEAD, view_of
from app.stage.stage import Stage
from app.theme import DOCK_WIDTH, NARROW, plots_height, scale
from app.web.viser_internals import aim
from controllers.kinematics import Array
from scenes.rigs import Camera
from scenes.simulation import Simulation


class ViewPart(Protocol):
    """Part of a feature; it may set the view's attributes."""

    def show(self, frame: Frame) -> None:
        """Called before the view draws."""
        ...


P = TypeVar("P")


class View:
    """Draws a session for one visitor or an audience.

    Args:
        host: one client, or the server of an audience.
        look, language: None for the session's.
        folds: True if the controls make room for a left panel in a narrow window.
        tip: None for the usual text.

    Attributes:
        camera: set by a part: returns the view of the live run; None for the experiment's.
        keeps_back: set by a part: True hides the law's values while a question waits.
        card_attributes: set by parts, for scripts.
        bare: True for a scene without panels, as on a projector.
    """

    def __init__(
        self,
        host: viser.ViserServer | viser.ClientHandle,
        session: Session,
        clients: Callable[[], list[viser.ClientHandle]],
        look: Look | None = None,
        language: Language | None = None,
        folds: bool = True,
        tip: Callable[[Shown], str] | None = None,
        overlays: "Sequence[Callable[[View], ViewPart]]" = (),
    ) -> None:
        self.host, self.session, self.language, self.folds = host, session, language, folds
        self._clients, self._own_look = clients, look
        self.camera: Callable[[Simulation], Camera] | None = None
        self.keeps_back: Callable[[], bool] = lambda: False
        self.card_attributes: list[Callable[[], Mapping[str, object]]] = []
        self.equation_last = False
        self.bare = False
        self._simulation, self._of_live = session.simulation, True
        page = self.page
        gui = host.gui
        self.private = isinstance(host, viser.ClientHandle)
        self.narrow = isinstance(host, viser.ClientHandle) and canvas_size(host)[0] < NARROW
        self._style = gui.add_html(style_sheet(page.profile))
        self._moment = gui.add_html("")
        self._readout = Readout(gui, tip or partial(tip_text, operated=self.private))
        gui.set_panel_label(tr(session.settings.run.experiment.label))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        plots_panel = gui.add_panel()
        self.plots_tab = plots_panel.add_tab(tr("Live plots"), viser.Icon.CHART_LINE)
        with self.plots_tab:
            # A folded panel removes its style sheet; the other keeps the page styled.
            self._style_too = gui.add_html(style_sheet(page.profile), order=-1.0)
            self._moment_too = gui.add_html("", order=-1.0)
            gui.add_html(mark_html(spoken()), order=-1.0)
        self._contact = ContactCard(gui, self.plots_tab)
        self.plots = Plots(gui, self.plots_tab, page, self._plots_height())
        plots_panel.float(x=14, y=-14, width=760)
        if isinstance(host, viser.ClientHandle) and canvas_size(host)[1] < LOW_CANVAS:
            plots_panel.minimize()
        self._look = page.theme, page.profile
        self._experiment = experiment_of(session.simulation)
        self.cameras: dict[int, CameraFollow] = {}
        configure_theme(gui, page.theme)
        self.stage = Stage(host.scene)
        self._parts = [make(self) for make in overlays]

    def part(self, kind: type[P]) -> P:
        """Raises `LookupError` if the page has no such part."""
        for part in self._parts:
            if isinstance(part, kind):
                return part
        raise LookupError(f"this page has no {kind.__name__}")

    @property
    def page(self) -> PageSettings:
        page = self.session.settings.page
        return page if self._own_look is None else self._own_look.of(page)

    def _plots_height(self) -> int:
        # An audience's plots have one size: its windows' sizes are not known here.
        height = canvas_size(self.host)[1] if isinstance(self.host, viser.ClientHandle) else 900.0
        return plots_height(height, self.page.profile)

    def fit_again(self) -> None:
        for client in self._clients():
            self.welcome(client)

    def welcome(self, client: viser.ClientHandle) -> None:
        """`look`, repeated while the page's layout settles."""
        self._camera_of(client).welcome(self._simulation, perf_counter())

    def look(self, client: viser.ClientHandle) -> None:
        """Point a client's camera at the scene; it then follows."""
        self._camera_of(client).first_view(self._simulation, perf_counter())

    def _camera_of(self, client: viser.ClientHandle) -> CameraFollow:
        if client.client_id not in self.cameras:
            self.cameras[client.client_id] = CameraFollow(
                client.camera,
                lambda pose: aim(client.camera, pose.eye, pose.look_at, pose.fov),
                self._seen,
                self._way,
                PictureReport(client, self.plots_tab, lambda: (self.page.profile, self.bare)),
            )
        return self.cameras[client.client_id]

    def _seen(self) -> Camera:
        simulation = self._simulation
        return view_of(simulation) if self.camera is None or not self._of_live else self.camera(simulation)

    def _way(self) -> Array:
        return (
            self.session.hand.way(AHEAD) if self._simulation is self.session.simulation else np.zeros((0, 3))
        )

    def _follow(self, frame: Frame) -> None:
        present = {client.client_id for client in self._clients()}
        self.cameras = {number: follow for number, follow in self.cameras.items() if number in present}
        held = (frame.shown.held or self.session.hand.other) is not None
        for follow in self.cameras.values():
            # Those who only watch drag nothing.
            follow.follow(self._simulation, frame.now, held and isinstance(self.host, viser.ClientHandle))

    def show(self, frame: Frame) -> None:
        page = self.page
        self._simulation, self._of_live = frame.simulation, frame.of_live
        sheet = style_sheet(page.profile)
        self._style.content = self._style_too.content = (
            sheet + replay_style(frame.shown) if frame.replayed else sheet
        )
        if self._look != (page.theme, page.profile):
            self._change_look()
        experiment = experiment_of(frame.simulation)
        if self._experiment != experiment:
            self._experiment = experiment
            self.host.gui.set_panel_label(tr(frame.settings.run.experiment.label))
            for client in self._clients():
                self.look(client)
        for part in self._parts:
            part.show(frame)
        self._follow(frame)
        asking = self.keeps_back()
        if isinstance(self.host, viser.ClientHandle):
            # The windows of an audience differ: its labels stay where they are.
            self.stage.keep_free = self._camera_of(self.host).keep_free
        self.stage.show(frame, page, asking)
        self._readout.show(frame, asking, self.equation_last)
        self._contact.show(frame, self._card_words, asking)
        self.plots.show(frame)
        self._moment.content = self._moment_too.content = moment_html(frame, self.plots.span)

    def _card_words(self) -> dict[str, object]:
        return {name: word for attributes in self.card_attributes for name, word in attributes().items()}

    def _change_look(self) -> None:
        page = self.page
        self._look = page.theme, page.profile
        self.host.gui.main_panel.set_width(DOCK_WIDTH * scale(page.profile))
        self.plots.dress(page, self._plots_height())
        configure_theme(self.host.gui, page.theme)


def experiment_of(simulation: Simulation) -> tuple[object, ...]:
    return simulation.settings.scene, simulation.room.rig, tuple(made.key for made in simulation.room.robots)
