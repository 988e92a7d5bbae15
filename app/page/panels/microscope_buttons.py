"""What stands under the microscope's chart: buttons for the signal and the largest jump, and a slider for any instant."""

from functools import partial
from typing import Final, get_args

import viser

from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.scrubber import Scrubber
from app.page.view import View
from app.session.frame import Frame
from app.session.microscope import STRIDE, Quantity
from app.session.session import Session

QUANTITIES: Final[tuple[Quantity, ...]] = get_args(Quantity)

WRITE: Final = 0.5
"""Time between two writes of the slider while the run goes on [s]."""


class MicroscopeButtons:
    """Buttons and slider; they are there while the microscope is.

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
            seek = session.microscope.go_to
            self._scrubber = Scrubber(gui, session, seek, "instant", 0.005, WRITE, order=0.7)

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
        """Mark the present signal, and put the slider where the instant is."""
        microscope = self._session.microscope
        shown = "microscope" in self._view.plots_shown and not frame.replayed
        self._buttons.show(QUANTITIES.index(microscope.quantity), visible=shown)
        self._scrubber.show(frame.now, microscope.span if shown else None)
