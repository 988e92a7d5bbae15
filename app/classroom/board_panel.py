"""The teacher's view of those who work alone: the board, who of them is shown on the projector, and which steps are open."""

from time import monotonic
from typing import Final

import viser

from app.classroom.teacher_control import TeacherControl
from app.i18n.speaking import tr
from app.lessons.bookmark import Bookmark
from app.lessons.open_steps import LONGEST
from app.text.templates import macros
from app.web.control_events import on_entry, on_press

PERIOD: Final = 1.0
"""Time between two looks at the board [s]."""

NO_ONE: Final[str] = "–"


class BoardPanel:
    """The folder in the teacher's tab; the caller has opened that. `control`: carries out what the teacher asks for."""

    def __init__(self, gui: viser.GuiApi, control: TeacherControl) -> None:
        self._control, self._classroom, self._lessons, act = control, control.classroom, control.lessons, control.post
        self._next = 0.0
        self._folder = gui.add_folder(tr("Who is where"), visible=False)
        with self._folder:
            hint = tr("2 or 2-3: no other step opens for those who work alone. Empty: all steps.")
            pace = gui.add_text(tr("only steps"), "", hint=hint)
            self._pace, self._table = gui.add_html(""), gui.add_html("")
            self._student = gui.add_dropdown(tr("student"), (NO_ONE,))
            answer = gui.add_button(tr("Show this one"), icon=viser.Icon.PRESENTATION)
            run = gui.add_button(tr("Show this run"), icon=viser.Icon.PLAYER_PLAY, color="gray")
        on_entry(pace, lambda text: act("pace", text[:LONGEST]))
        on_press(answer, lambda: act("show", self._student.value))
        on_press(run, lambda: act("show run", self._student.value))

    def show(self) -> None:
        """Update it; it is there while the class explores."""
        classroom, lessons, now = self._classroom, self._lessons, monotonic()
        self._folder.visible = classroom.free
        if not classroom.free or now < self._next:
            return
        self._next = now + PERIOD
        walk, pace = lessons.walk, classroom.pace
        place = walk.lesson.id, walk.step_index
        at = Bookmark(walk.book).at(*(place if pace is None else (pace.lesson, pace.nearest(*place))))
        rows = classroom.board.rows(classroom.groups, at, now)
        said = tr("Every step is open.") if pace is None else tr(pace.words)
        self._pace.content = macros("page/panels/pills.html").note(" ".join(filter(None, (tr(self._control.refused), said))))
        self._table.content = macros("classroom/board.html").board(rows, len(at.lesson.steps))
        names = NO_ONE, *(row.name for row in rows)
        if self._student.value not in names:
            # A student who is away for a moment stays chosen.
            names += (self._student.value,)
        if names != tuple(self._student.options):
            self._student.options = names
