"""The box in which a student gives a reason for a prediction, before the run."""

from typing import Any, Final

import viser

from app.i18n.speaking import tr
from app.lessons.phases import Phase
from app.lessons.progress import LONGEST_REASON
from app.lessons.session.lesson_session import LessonSession
from app.lessons.step_view import StepView
from app.page.lessons.lesson_panel import ORDER
from app.session.session import Session

_PLACE: Final = ORDER["choices"] + 7.5
"""Between the answers and Run."""


class ReasonBox:
    """One box for every step that asks something, made when it is first seen. The caller opens its container.

    What is typed last may arrive when the student is already in another step, so that no two steps share a box.

    Args:
        run: the lessons; what is typed goes to their progress.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, run: LessonSession, tab: viser.GuiTabHandle) -> None:
        self._gui, self._session, self._run, self._tab = gui, session, run, tab
        self._boxes: dict[tuple[str, str], viser.GuiTextHandle] = {}
        self._written: dict[tuple[str, str], str] = {}

    def _make(self, lesson: str, step: str) -> viser.GuiTextHandle:
        hint = tr(
            "Optional: one line of at most {count} characters. Your lab report shows it beside the outcome.", count=LONGEST_REASON
        )
        with self._tab:
            box = self._gui.add_text(tr("Because …"), "", visible=False, hint=hint, order=_PLACE)

        @box.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                text = str(event.target.value)[:LONGEST_REASON]
                self._session.post(lambda: self._take(text, lesson, step), ("reason", lesson, step))

        return box

    def _take(self, text: str, lesson: str, step: str) -> None:
        self._run.walk.give_reason(text, lesson, step)
        self._written[lesson, step] = self._run.walk.done_in(lesson, step).because

    def show(self, view: StepView | None) -> None:
        """Offer the box of the present step as long as its answer can be changed; without a step none."""
        if view is None:
            for box in self._boxes.values():
                box.visible = False
            return
        place = view.lesson.id, view.step.id
        asking = (bool(view.choices) or view.drawing is not None) and view.phase in (Phase.PREDICT, Phase.DO)
        if asking and place not in self._boxes:
            self._boxes[place] = self._make(*place)
        for other, box in self._boxes.items():
            box.visible = asking and other == place
        if asking and self._written.get(place, "") != view.because:
            # A reload or a reset has changed it, not the student's typing.
            self._written[place] = self._boxes[place].value = view.because
