"""The teacher's tab: notes and load."""

from collections.abc import Mapping
from typing import Final

import viser

from app.features.lessons.lesson import Step
from app.features.lessons.loading import Notes, read_notes
from app.features.lessons.session.lesson_session import LessonSession
from app.i18n.speaking import tr
from app.page.panels.server_load import ServerLoad, load_pills
from app.text.templates import element, macros

ORDER: Final = -20.0


class NotesView:
    """Notes (Markdown by lesson id), the current step's first."""

    def __init__(self, gui: viser.GuiApi, notes: Mapping[str, str]) -> None:
        self._notes = {lesson: read_notes(text) for lesson, text in notes.items()}
        self._handle = gui.add_html("")
        self._shown: tuple[bool, Notes | None, Step | None] | None = None

    def show(self, lessons: LessonSession) -> None:
        walk = lessons.walk if lessons.open else None
        notes = self._notes.get(walk.lesson.id) if walk is not None else None
        place = lessons.open, notes, walk.step if walk is not None else None
        # Markdown with formulas is too slow for every frame.
        if place == self._shown:
            return
        self._shown = place
        if walk is None or notes is None:
            no_lesson = tr(
                "Open a lesson: its notes for the teacher are then here, and on no student's page."
            )
            said = tr("This lesson has no notes.") if lessons.open else no_lesson
            self._handle.content = macros("page/panels/pills.html").note(said)
        else:
            # The section of the current step comes first.
            self._handle.content = macros("features/lessons/panel/notes.html").notes(
                notes, walk.step.number, walk.step.setup.folder
            )


class TeachersTab:
    """For a teacher with a private session."""

    def __init__(self, gui: viser.GuiApi, notes: Mapping[str, str]) -> None:
        with gui.add_tab_group(order=ORDER).add_tab(tr("Teacher's notes"), viser.Icon.NOTEBOOK):
            self._load = gui.add_html("")
            self._shown: ServerLoad | None = None
            self._notes = NotesView(gui, notes)

    def show(self, lessons: LessonSession, load: ServerLoad) -> None:
        if load != self._shown:
            self._shown = load
            pills = macros("page/panels/pills.html").heads([load_pills(load)])
            self._load.content = element("div", "", pills, class_="duet-class")
        self._notes.show(lessons)
