"""What a visitor takes away from the lessons: a report with the student's own words, and of a duel a link that replays the nearest push to
the last bit, and a film of five seconds around it."""

import viser

from app.export.export_queue import ExportQueue
from app.export.lab_report import done_in
from app.i18n.speaking import tr
from app.lessons.progress import MOST_WORDS
from app.lessons.session.lesson_actions import Write
from app.page.lessons.lesson_panel import ORDER
from app.page.panels import PagePanel
from app.page.panels.link_box import link_to
from app.page.view import View
from app.session.actions import Action
from app.session.frame import Frame
from app.session.session import Session
from app.settings import PUSH
from app.text.templates import element, macros
from app.web.control_events import on_entry, on_press
from app.web.request import request_address
from controllers.errors import BadSetting
from scenes.inputs import Recorded
from scenes.run_text import run_text


class AskReport(Action, newest_by=("one",)):
    """Make the lab report on all lessons, or on the present one alone."""

    one: bool


class LabReportBox:
    """What a student writes, and the buttons. The caller has opened the container of the button that is always there.

    Args:
        view: with the lessons, and their panel, where the box and the second button stand.
        exports: makes the report.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, view: View, exports: ExportQueue) -> None:
        self._gui, self._session, self._exports = gui, session, exports
        self._lessons, self._panel = view.lessons, view.lesson_panel
        self._boxes: dict[tuple[str, str], viser.GuiTextHandle] = {}
        self._of_lesson: viser.GuiButtonHandle | None = None
        self._of_all = self._button("Lab report on all lessons", False)

    def _button(self, label: str, one: bool, order: float | None = None) -> viser.GuiButtonHandle:
        hint = tr("One HTML page to print: predictions, outcomes, plots, settings and your own words.")
        button = self._gui.add_button(tr(label), icon=viser.Icon.REPORT, hint=hint, color="gray", visible=False, order=order)
        return on_press(button, lambda: self._session.post(AskReport(one)))

    def ask(self, one: bool) -> None:
        """Ask for the report. `one`: on the present lesson alone."""
        walk = self._lessons.walk
        self._exports.ask_report(
            done_in(self._lessons.book.lessons, walk.done_in, self._lessons.seen, walk.lesson.id if one else None)
        )

    def _box(self, lesson: str, step: str, tab: viser.GuiTabHandle) -> viser.GuiTextHandle:
        # A box of its own for every step: what is typed last may arrive when the student is already in the next one.
        with tab:
            box = self._gui.add_text(
                tr("in my own words"),
                self._lessons.walk.done_in(lesson, step).words,
                multiline=True,
                visible=False,
                hint=tr("What you saw, and why: it goes into your lab report."),
                order=ORDER["hints"] + 3.0,
            )
        return on_entry(box, lambda words: self._session.post(Write(lesson, step, words[:MOST_WORDS])))

    def show(self, frame: Frame) -> None:
        """Offer box and buttons where they belong."""
        del frame
        run, tab = self._lessons, self._panel.tab
        self._of_all.visible = run.begun
        if tab is None:
            return
        walk = run.walk
        last = run.open and not run.listing and walk.phase is walk.phases[-1]
        here = (walk.lesson.id, walk.step.id) if last else None
        if here is not None and here not in self._boxes:
            self._boxes[here] = self._box(*here, tab)
        if self._of_lesson is None:
            with tab:
                self._of_lesson = self._button("Lab report on this lesson", True, ORDER["hints"] + 4.0)
        for place, box in self._boxes.items():
            box.visible = place == here
        self._of_lesson.visible = here is not None and walk.step is walk.lesson.steps[-1]


class AskPushFilm(Action):
    """Make the film of the nearest push."""


class DuelBox(PagePanel):
    """The link and the button, below the score.

    Args:
        view: with the panel where they stand.
        exports: makes the film.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, view: View, exports: ExportQueue) -> None:
        self._gui, self._session, self._exports = client.gui, session, exports
        self._lessons, self._panel = view.lessons, view.lesson_panel
        self._address = request_address(client)
        self._shown: Recorded | None = None
        self._handles: tuple[viser.GuiHtmlHandle, viser.GuiButtonHandle] | None = None

    def take(self, action: Action) -> bool:
        """Have the film made; return whether this was asked for."""
        if not isinstance(action, AskPushFilm):
            return False
        if self._shown is not None:
            self._exports.ask_push_film(self._shown)
        return True

    def show(self, frame: Frame) -> None:
        """Offer them once a push counts."""
        del frame
        run, tab = self._lessons, self._panel.tab
        nearest = run.walk.nearest if run.open and not run.listing and tab is not None else None
        if self._handles is None and nearest is not None and tab is not None:
            hint = tr("An animated picture (WebP) of the nearest moment; it takes half a minute.")
            with tab:
                link = self._gui.add_html("", order=ORDER["attempt"] + 1.0)
                film = self._gui.add_button(tr("Film of five seconds"), hint=hint, color="gray", order=ORDER["attempt"] + 2.0)
            self._handles = link, on_press(film, lambda: self._session.post(AskPushFilm()))
        if self._handles is None:
            return
        link, film = self._handles
        if nearest is not self._shown:
            self._shown = nearest
            link.visible = film.visible = nearest is not None
            link.content = "" if nearest is None else self._link(nearest)
        film.disabled = bool(self._exports.busy)

    def _link(self, push: Recorded) -> str:
        walk = self._lessons.walk
        try:
            query = {"lesson": walk.lesson.id, "step": str(walk.step_index + 1), PUSH: run_text(push)}
        except BadSetting as error:
            return element("p", tr(str(error)), class_="duet")
        made = macros("page/panels/copy.html").link
        return made(link_to(self._address, query), False, tr("Link that replays your nearest push"))
