"""The boxes in which a student forecasts numbers, where a challenge asks for any."""

from typing import Any, Final

import viser

from app.i18n.speaking import tr
from app.lessons.lesson import Challenge
from app.lessons.session.lesson_session import LessonSession
from app.lessons.step_view import StepView
from app.page.lessons.lesson_panel import ORDER
from app.session.session import Session

MOST_FORECASTS: Final = 4


class Forecasts:
    """The boxes. The caller has opened their container.

    Args:
        run: the lessons; what is typed goes to their `said`.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, run: LessonSession) -> None:
        self._session, self._run = session, run
        self._filled_for: tuple[str, str] | None = None
        self._boxes = [self._make(gui, i) for i in range(MOST_FORECASTS)]

    def _make(self, gui: viser.GuiApi, index: int) -> viser.GuiTextHandle:
        box = gui.add_text(f"forecast {index}", "", visible=False, order=ORDER["after"] + 1.0 + index)

        @box.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                number = read_number(event.target.value)
                self._session.post(lambda: self._say(index, number), ("forecast", index))

        return box

    def _say(self, index: int, number: float | None) -> None:
        said = self._run.said
        said.extend([None] * (index + 1 - len(said)))
        said[index] = number

    def show(self, view: StepView, challenge: Challenge | None) -> None:
        """Offer the boxes of a challenge, with what was typed there; none without one."""
        here = (view.lesson.id, view.step.id) if challenge is not None else None
        if self._filled_for != here:
            self._filled_for = here
            said = (*self._run.said, *(None,) * MOST_FORECASTS)
            for box, number in zip(self._boxes, said[:MOST_FORECASTS], strict=True):
                box.value = "" if number is None else f"{number:g}"
        for i, box in enumerate(self._boxes):
            box.visible = challenge is not None and i < len(view.forecasts)
            if challenge is not None and box.visible:
                unit = challenge.forecasts[i].measurement.unit
                box.label = view.forecasts[i]
                box.hint = tr("Your number, in {unit}.", unit=unit) if unit else tr("Your number.")


def read_number(text: object) -> float | None:
    """Return the number that a person typed, with a point or a comma and perhaps a unit behind it; None if there is none."""
    if not isinstance(text, str):
        return None
    try:
        number = float(text[:40].strip().split(" ")[0].replace(",", ".").replace("−", "-"))
    except (ValueError, IndexError):
        return None
    return number if abs(number) < 1e9 else None
