"""The lessons' panel as everyone sees it."""

from collections.abc import Callable
from typing import Final

import viser
from markupsafe import Markup

from app.features.custom_law.law_html import law_html
from app.features.lessons.bookmark import Phase
from app.features.lessons.labels import Contrast
from app.features.lessons.lesson import LessonBook
from app.features.lessons.panel.lesson_charts import tracks_html
from app.features.lessons.panel.lesson_html import BLOCKS, blocks_html, rules_html
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.step_view import StepView
from app.i18n.speaking import tr
from app.session.frame import Frame
from app.text.setting_values import page_value
from app.text.templates import element, macros
from scenes.laws import LAWS

PERIOD: Final = 0.2
"""Wall time between updates [s]."""

WIDTH: Final = 340

EDITOR_WIDTH: Final = 520
"""Width with an editor, in a wide window [CSS px]."""

NARROW_WIDTH: Final = 300
"""Width in a narrow window [CSS px]."""

ORDER: Final = {name: float(10 * place) for place, name in enumerate(BLOCKS, 1)}

VERDICT: Final = 0.5
"""First, so that a phone shows it."""

PLOTS: Final = "[data-duet-holds~=plots]"

IN_LESSONS: Final = (ORDER["drawing"] + 0.1, ORDER["drawing"] + 0.2)


class LessonPanel:
    """The panel at the left, made with the first opened lesson.

    Args:
        width: [CSS px].
        folds: true if the controls at the right fold until a step needs them.
        sheet: the page's own style sheet disappears when the controls fold.
        book: in the reader's language; None for the session's.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        run: LessonSession,
        width: float,
        operated: bool,
        folds: bool = False,
        narrow: bool = False,
        sheet: Callable[[], str] = lambda: "",
        book: LessonBook | None = None,
    ) -> None:
        self._gui, self._run, self._width, self._operated = gui, run, width, operated
        self._folds, self._narrow = folds, narrow
        self._sheet, self._book = sheet, book
        self._wide = width
        self._folded = False
        self.panel: viser.PanelHandle | None = None
        self.tab: viser.GuiTabHandle | None = None
        self.openers: dict[str, str] = {}
        self.guess_box = ""
        self.edits = False
        self.contrast: Contrast | None = None
        self.run_names: tuple[str, str] | None = None
        """Of the visitor's and the law's run, once both are shown."""
        self._tracks: tuple[object, Markup] = None, Markup()
        self._shown: tuple[object, ...] = ()
        self._next = 0.0

    def _make(self) -> viser.PanelHandle:
        panel = self.panel = self._gui.add_panel()
        tab = self.tab = panel.add_tab(tr("Lesson"), viser.Icon.SCHOOL)
        with tab:
            self._style = self._gui.add_html("", order=0.0)
            places = {**ORDER, "verdict": VERDICT}
            self._blocks = {name: self._gui.add_html("", order=places[name]) for name in BLOCKS}
        return panel

    def set_width(self, width: float) -> None:
        """Set the width of panel and editor [CSS px] from the next frame on."""
        self._width, self._shown = width, ()

    def show(self, frame: Frame) -> bool:
        """True if the panel opened or closed, so that cameras must follow."""
        run, panel = self._run, self.panel
        if not run.open or run.listing:
            self.contrast = self.run_names = None
        if not (run.open or run.listing):
            if panel is None or not panel.visible:
                return False
            panel.visible = False
            self._style.content = ""
            self._fold(False)
            return True
        opened = panel is None or not panel.visible
        if panel is None:
            panel = self._make()
        if opened:
            panel.visible = True
            panel.dock_left()
            panel.set_width(self._wide)
        law = frame.live.law_status
        state = run.version, run.computing, law.problem, law.away, len(self.openers)
        if opened or state != self._shown or (run.open and not run.listing and frame.now >= self._next):
            self._next = frame.after(PERIOD)
            self._shown = state
            blocks = self._list() if run.listing else self._step(frame)
            if opened and self._narrow:
                panel.expand()
            for name, block in self._blocks.items():
                block.content, block.visible = blocks.get(name, ""), bool(blocks.get(name))
        return opened

    def _list(self) -> dict[str, Markup]:
        self._style.content = self._sheet() + panel_style(self._widen(False))
        self._fold(True)
        made = macros("features/lessons/panel/lesson_list.html").lessons(
            self._run.walk.entries(self._book), self.openers
        )
        return {"list": element("div", "", made, class_="duet duet-lesson duet-l-list")}

    def _step(self, frame: Frame) -> dict[str, Markup]:
        run = self._run
        view = run.walk.view(self._book)
        self.contrast = view.contrast
        simulation = (frame if frame.of_live else frame.live).simulation
        numbers = run.live(simulation, self._book) if view.phase is not Phase.PREDICT else ()
        hidden = hidden_beside(view)
        self._style.content = self._sheet() + panel_style(
            self._widen(self.edits and run.own_tests is not None), hidden
        )
        flashes = view.contrast is not None and bool(view.contrast.keys) and not self._narrow
        self._fold(not (flashes or asks_for_settings(view)))
        blocks = blocks_html(view, numbers, run.computing, self._operated)
        if run.own_tests is not None:
            law = frame.live.law_status
            blocks["attempt"] = law_html(run.own_tests, law.problem, law.away, view.done.passed, self.edits)
        over = view.step.at_lever and view.phase is not Phase.DO
        ghost = frame.live.settings.page.ghost
        # The student may have chosen another ghost meanwhile, or none.
        self.run_names = (tr("you"), page_value("law", ghost)) if over and ghost in LAWS else None
        if over and view.phase is Phase.OBSERVE:
            blocks["verdict"] = self._both_tracks(frame) or blocks["verdict"]
        return blocks

    def _both_tracks(self, frame: Frame) -> Markup:
        """Empty if a reload lost the beginning of the runs."""
        (own, rival), names = frame.live.traced, self.run_names
        if rival is None or names is None or not 0 < own.history.count == rival.history.count == own.steps:
            return Markup()
        state = self._run.walk.run_id, own.steps
        if state != self._tracks[0]:
            self._tracks = state, tracks_html(own, rival, names)
        return self._tracks[1]

    def _widen(self, wide: bool) -> float:
        width = self._width * (EDITOR_WIDTH / WIDTH if wide and not self._narrow else 1.0)
        if width != self._wide and self.panel is not None:
            self._wide = width
            self.panel.set_width(width)
        return width

    def _fold(self, folded: bool) -> None:
        if self._folds and folded != self._folded:
            self._folded = folded
            if folded:
                self._gui.main_panel.minimize()
            else:
                self._gui.main_panel.expand()


def hidden_beside(view: StepView) -> str:
    early = view.phase in (Phase.PREDICT, Phase.DO, Phase.OBSERVE)
    rests = view.step.concept or view.phase is Phase.PREDICT
    return ".duet-tiles,.duet-tip" + (",.duet-eq" if early else "") + (f",{PLOTS}" if rests else "")


def asks_for_settings(view: StepView) -> bool:
    """True if the step needs a control at the right."""
    challenge = view.step.challenge if view.phase is Phase.CHALLENGE else None
    if challenge is None or view.step.controls:
        return False
    return not (challenge.forecasts or challenge.custom_law or challenge.null_motions or challenge.best_of)


def panel_style(width: float, hidden: str = "") -> str:
    return rules_html(
        f":root{{--duet-left:{width:g}px}}" + (f"{hidden}{{display:none!important}}" if hidden else "")
    )
