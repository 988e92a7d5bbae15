"""The lab report on the page."""

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import viser

from app.features.exports.export_queue import ExportQueue
from app.features.exports.exports_panel import ExportsPanel
from app.features.lab_report.lab_report import Done, done_in, lab_bytes
from app.features.lessons.panel.answer_boxes import add_readers, takes_reason
from app.features.lessons.panel.lesson_panel import ORDER
from app.features.lessons.panel.lesson_view import LessonView
from app.features.lessons.progress import MOST_WORDS
from app.features.lessons.session.lesson_actions import Write
from app.i18n.speaking import N_, spoken, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.session.actions import Action
from app.session.frame import Frame
from app.session.session import Session
from app.web.control_events import on_entry, on_press

_WORDS: Final = ORDER["hints"] + 3.0
_REPORT: Final = ORDER["hints"] + 4.0


class AskReport(Action, newest_by=("one",)):
    one: bool


def ask_report(exports: ExportQueue, session: Session, done: Sequence[Done]) -> None:
    """Submit a lab report, or notify that it is empty."""
    if not done:
        session.notify("There is nothing to report yet", "Answer a question of a lesson first.")
        return
    lessons = sorted({one.lesson.number for one in done})
    name = "duet-lab-report" + (f"-lesson-{lessons[0]}" if len(lessons) == 1 else "")
    # The job is pickled later, when the student may have moved on.
    given = [replace(one, progress=copy.deepcopy(one.progress)) for one in done]
    exports.make(N_("the lab report"), name + ".html", lab_bytes, given, spoken().language)


class LabReportBox(PagePanel):
    """In the folder “Keep and replay”, and in the lessons' panel."""

    def __init__(self, page: PanelContext) -> None:
        self._gui, self._session, self._exports = (
            page.client.gui,
            page.session,
            page.panel(ExportsPanel).exports,
        )
        view = page.view.part(LessonView)
        self._lessons, self._panel = view.lessons, view.panel
        self._boxes: dict[tuple[str, str], viser.GuiTextHandle] = {}
        self._of_lesson: viser.GuiButtonHandle | None = None
        self._readers: viser.GuiHtmlHandle | None = None
        with page.keep:
            self._of_all = self._button("Lab report on all lessons", False)
        page.handlers.add(AskReport, self._ask)

    def _button(self, label: str, one: bool, order: float | None = None) -> viser.GuiButtonHandle:
        hint = tr("One HTML page to print: predictions, outcomes, plots, settings and your own words.")
        button = self._gui.add_button(
            tr(label), icon=viser.Icon.REPORT, hint=hint, color="gray", visible=False, order=order
        )
        return on_press(button, lambda: self._session.post(AskReport(one)))

    def _ask(self, action: AskReport) -> None:
        walk = self._lessons.walk
        only = walk.lesson.id if action.one else None
        ask_report(
            self._exports,
            self._session,
            done_in(self._lessons.book.lessons, walk.done_in, self._lessons.seen, only),
        )

    def _box(self, lesson: str, step: str, tab: viser.GuiTabHandle) -> viser.GuiTextHandle:
        # One box per step: the last typing may arrive when the student is already in the next step.
        with tab:
            box = self._gui.add_text(
                tr("in my own words"),
                self._lessons.walk.done_in(lesson, step).words,
                multiline=True,
                visible=False,
                hint=tr("What you saw, and why."),
                order=_WORDS,
            )
        return on_entry(box, lambda words: self._session.post(Write(lesson, step, words[:MOST_WORDS])))

    def show(self, frame: Frame) -> None:
        del frame
        run, tab = self._lessons, self._panel.tab
        self._of_all.visible = run.begun
        if tab is None:
            return
        walk = run.walk
        last = run.open and not run.listing and walk.phase is walk.phases[-1]
        here = (walk.lesson.id, walk.step.id) if last and not takes_reason(walk.step, walk.phase) else None
        if here is not None and here not in self._boxes:
            self._boxes[here] = self._box(*here, tab)
        if self._of_lesson is None:
            self._readers = add_readers(self._gui, tab, _WORDS + 0.1)
            with tab:
                self._of_lesson = self._button("Lab report on this lesson", True, _REPORT)
        for place, box in self._boxes.items():
            box.visible = place == here
        if self._readers is not None:
            self._readers.visible = here is not None
        self._of_lesson.visible = last and walk.step is walk.lesson.steps[-1]
