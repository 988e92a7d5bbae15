"""The row of buttons under the microscope's chart: which signal, and which instant."""

from functools import partial
from typing import Final, get_args

import viser

from app.page.panels.choice_buttons import ChoiceButtons
from app.page.view import View
from app.session.frame import Frame
from app.session.microscope import STRIDE, Quantity
from app.session.session import Session

QUANTITIES: Final[tuple[Quantity, ...]] = get_args(Quantity)


class MicroscopeButtons:
    """The row of buttons; it is there while the microscope is.

    Args:
        view: with the panel of plots.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, view: View) -> None:
        self._session, self._view = session, view
        with view.plots_tab:
            self._buttons = ChoiceButtons(
                gui,
                "single steps",
                ("d", "λ", "q̇", "e", "Largest jump", "◀", "▶"),
                "Which steps are shown: about the largest step of q̇ in the last 20 s, or ten steps earlier or later.",
                self._press,
                order=0.6,
            )

    def _press(self, place: int) -> None:
        microscope = self._session.microscope
        if place < len(QUANTITIES):
            self._session.post(partial(microscope.look_at, QUANTITIES[place]))
        elif place == len(QUANTITIES):
            self._session.post(microscope.find_jump)
        else:
            steps = STRIDE if place == len(QUANTITIES) + 2 else -STRIDE
            self._session.post(lambda: microscope.move(steps, self._session.settings.run.dt))

    def show(self, frame: Frame) -> None:
        """Mark the present signal."""
        shown = "microscope" in self._view.plots_shown
        self._buttons.show(QUANTITIES.index(self._session.microscope.quantity), visible=shown and not frame.replayed)
