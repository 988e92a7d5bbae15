"""Overlays of a lecture's pages and projectors."""

import contextlib
from collections.abc import Collection
from typing import Final

import viser
from markupsafe import Markup

from app.features.classroom.classroom import Poll
from app.features.classroom.classroom_html import poll_html
from app.features.classroom.tally_html import drawn_too
from app.features.lecture.page_lines import overlay_html
from app.features.lecture.presenter import ShownWork, Station, clock_text
from app.features.lecture.teacher_control import TeacherControl
from app.features.lessons.bookmark import Bookmark
from app.features.lessons.curve_drawing import drawing_svg
from app.features.lessons.lesson import LessonBook
from app.features.lessons.panel.lesson_html import record_html
from app.features.lessons.panel.lesson_view import LessonView
from app.features.lessons.step_view import StepView
from app.features.lessons.tally import Tally
from app.features.lessons.texts import fill
from app.i18n.speaking import tr
from app.page.view import View
from app.text.lesson_text import lesson_html
from app.text.templates import element, macros
from app.web.address import Address


class Invitation:
    """The address over a page, not on pages that open later."""

    def __init__(self, gui: viser.GuiApi, view: View) -> None:
        self._gui, self._view = gui, view
        self._handles: dict[str, viser.GuiHtmlHandle] = {}
        self._late, self._shown = True, False

    def show(self, address: Address | None) -> None:
        self._late = self._late and address is not None
        if self._late or self._shown == (address is not None):
            return
        content = "" if address is None else overlay_html(address)
        # A folded panel is not on the page; one of several is.
        places = {
            "main": contextlib.nullcontext(),
            "plots": self._view.plots_tab,
            "lesson": self._view.part(LessonView).panel.tab,
        }
        for name, place in places.items():
            if place is not None and name not in self._handles:
                with place:
                    self._handles[name] = self._gui.add_html("")
        for handle in self._handles.values():
            handle.content = content
        # If it gets lost, the next frame shows it.
        self._shown = address is not None


class ScreenView:
    """Overlays on the projectors of one look. `book`: in their language."""

    def __init__(self, gui: viser.GuiApi, control: TeacherControl, book: LessonBook) -> None:
        self._control, self._book = control, book
        self._over, self._cover = gui.add_html(""), gui.add_html("")
        self._shown: object = None
        self._covered: tuple[bool, Address | None, tuple[int, int]] = False, None, (0, 0)

    def show(self, poll: Poll | None) -> None:
        presenter, lessons, record = self._control.presenter, self._control.lessons, self._control.record
        left = presenter.left
        # A class's curves are too slow to draw in every frame.
        class_says = poll, presenter.work, presenter.quotes, record
        shown = presenter.station, presenter.panels, lessons.open, lessons.version, left, class_says
        if shown == self._shown:
            return
        self._shown = shown
        view = lessons.walk.view(self._book) if lessons.open else None
        if presenter.work is not None:
            self._over.content = work_html(presenter.work, self._book)
        else:
            self._over.content = screen_html(
                presenter.station, view, poll, left, presenter.panels, presenter.quotes, record
            )

    def cover(self, address: Address | None) -> None:
        presenter = self._control.presenter
        joined = (0, 0) if address is None else (self._control.classroom.heads[0], presenter.expected)
        covered = presenter.blank, address, joined
        if covered != self._covered:
            self._covered = covered
            black = element("i", class_="duet-blank", hidden="") if presenter.blank else ""
            self._cover.content = black + ("" if address is None else overlay_html(address, joined))


CAPTIONS: Final = {Station.SCENE: "goal", Station.RUN: "do", Station.TRY: "challenge"}
"""Stations without an overlay → text below the scene."""


def screen_html(
    station: Station,
    view: StepView | None,
    poll: Poll | None,
    left: int | None,
    panels: bool,
    quotes: Collection[str] = (),
    record: float | None = None,
) -> Markup:
    """For `presenter.js`. `left`: remaining time [s]; `record`: smallest d − d_m of the class in the step's
    duel [m].
    """
    made, kinds = (
        macros("features/lecture/screen.html"),
        f"at-{station} panels" if panels else f"at-{station}",
    )
    if view is not None and station not in CAPTIONS:
        slide = (
            made.head(view) + _slide(station, view, poll, quotes) + record_html(record) + _meter(poll, left)
        )
        return made.screen(f"slide {kinds}", slide)
    if view is None or panels:
        return made.screen(f"scene {kinds}", "")
    texts = dict(view.texts)
    counts = poll is not None and poll.open and (poll.tally.handed_in > 0 or left is not None)
    caption = made.caption(view, texts.get(CAPTIONS[station]) or texts["goal"], record_html(record))
    return made.screen(f"scene {kinds}", caption + _meter(poll, left) if counts else caption)


def work_html(work: ShownWork, book: LessonBook) -> Markup:
    """A student's work, or the step of a run."""
    at = Bookmark(book).of(*work.step)
    lesson, step, known = at.lesson, at.step, (at.lesson.id, at.step.id) == work.step
    place, done = tr("Lesson {lesson} · step {step}", lesson=lesson.number, step=at.step_index + 1), work.done
    made, screen = macros("features/lecture/board.html"), macros("features/lecture/screen.html").screen
    if work.run or not known:
        return screen("scene at-run", made.run(place if known else "", step.title if known else ""))
    asked, language = step.question, lesson.language
    question = "" if asked is None else lesson_html(fill(step, asked.text, None, language), step.setup.folder)
    choices = (
        () if asked is None else tuple(fill(step, choice.text, None, language) for choice in asked.choices)
    )
    svg = drawing_svg(step.drawing, done.drawing, ()) if step.drawing is not None and done.drawing else ""
    outcome = () if done.outcome is None else done.outcome.lines(step, language)
    return screen("slide at-work", made.work(place, step.title, question, choices, done.choice, svg, outcome))


def _slide(station: Station, view: StepView, poll: Poll | None, quotes: Collection[str]) -> Markup:
    made, texts = macros("features/lecture/screen.html"), dict(view.texts)
    if station is Station.EXPLANATION:
        return made.slide(view, "", "", texts.get("explain", ""), "text")
    if station is Station.CHALLENGE:
        return made.slide(view, "", "", texts.get("challenge", ""), "text task")
    if poll is None:
        answers = made.outcome(view)
    else:
        if station is Station.QUESTION or not (poll.revealed or poll.outcome):
            # Rows with empty bars, which grow at the reveal, and empty axes.
            none = Tally((0,) * len(poll.choices), 0, 0)
            poll = Poll(
                question=poll.question,
                choices=poll.choices,
                tally=none,
                open=True,
                revealed=False,
                drawing=poll.drawing,
                unseen=True,
            )
        answers = poll_html(poll) + made.quotes(quotes)
    after = texts.get("observe", "") if station is Station.OUTCOME else ""
    return made.slide(view, texts.get("predict", ""), answers, after, "text")


def _meter(poll: Poll | None, left: int | None) -> Markup:
    if poll is None or not (poll.open or poll.revealed) or poll.outcome:
        return Markup()
    here = poll.tally.handed_in + poll.tally.waiting
    left = left if poll.open else None
    clock = None if left is None else clock_text(left)
    return macros("features/lecture/screen.html").meter(poll.tally, here, drawn_too(poll.tally), left, clock)
