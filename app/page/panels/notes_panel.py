"""The teacher's notes on the page; only a teacher's browser is sent any of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import viser

from app.i18n.speaking import tr
from app.lessons.lesson import Step
from app.lessons.notes import Notes, StepNotes, read_notes
from app.lessons.session.lesson_session import LessonSession
from app.page.panels.server_load import ServerLoad, load_html
from app.text.html_element import element
from app.text.lesson_text import inline_html, lesson_html

ORDER: Final = -20.0
"""Order of a teacher's tabs: above the controls."""


class NotesView:
    """The notes to the open lesson, those to the present step first.

    Args:
        notes: Markdown by lesson id.
    """

    def __init__(self, gui: viser.GuiApi, notes: Mapping[str, str]) -> None:
        self._notes = {lesson: read_notes(text) for lesson, text in notes.items()}
        self._handle = gui.add_html("")
        self._shown: tuple[bool, Notes | None, Step | None] | None = None

    def show(self, lessons: LessonSession) -> None:
        """Update the notes to the open lesson and step."""
        walk = lessons.walk if lessons.open else None
        notes = self._notes.get(walk.lesson.id) if walk is not None else None
        place = lessons.open, notes, walk.step if walk is not None else None
        # Markdown with formulas is too slow to be read in every frame.
        if place == self._shown:
            return
        self._shown = place
        if walk is None or notes is None:
            self._handle.content = no_notes_html(lessons.open)
        else:
            self._handle.content = notes_html(notes, walk.lesson.steps.index(walk.step) + 1, walk.step.setup.folder)


class TeachersTab:
    """The server's numbers and the notes in a tab of their own, for a teacher with a private session.

    Args:
        notes: Markdown by lesson id.
    """

    def __init__(self, gui: viser.GuiApi, notes: Mapping[str, str]) -> None:
        with gui.add_tab_group(order=ORDER).add_tab(tr("Teacher's notes"), viser.Icon.NOTEBOOK):
            self._load = gui.add_html("")
            self._shown: ServerLoad | None = None
            self._notes = NotesView(gui, notes)

    def show(self, lessons: LessonSession, load: ServerLoad) -> None:
        """Update both."""
        if load != self._shown:
            self._shown = load
            self._load.content = element("div", "", element("div", "", load_html(load), class_="duet-heads"), class_="duet-class")
        self._notes.show(lessons)


def notes_html(notes: Notes, step: int, folder: Path | None = None) -> str:
    """Return the teacher's notes to a lesson, the section of the present step first.

    Args:
        notes: of the lesson.
        step: the present one, from 1.
        folder: of the lesson's pictures.
    """
    now = [_section_html(part, folder, class_="now") for part in notes.steps if part.number == step]
    others = [_section_html(part, folder) for part in notes.steps if part.number != step]
    head = [element("h3", "", inline_html(notes.title))] if notes.title else []
    return element("div", "", *now, *head, lesson_html(notes.text, folder), *others, class_="duet-class duet-notes")


def _section_html(part: StepNotes, folder: Path | None, **attributes: str) -> str:
    title = f"{part.number}. {part.title}" if part.title else f"{part.number}."
    return element("section", "", element("h4", "", inline_html(title)), lesson_html(part.text, folder), **attributes)


def no_notes_html(open: bool) -> str:
    """Return the line that stands in place of notes. `open`: whether a lesson is open."""
    line = (
        tr("This lesson has no notes.")
        if open
        else tr("Open a lesson: its notes for the teacher are then here, and on no student's page.")
    )
    return element("div", "", element("p", line, class_="soft"), class_="duet-class")
