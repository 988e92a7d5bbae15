"""The buttons and the slider of the microscope: which signal, and which instant."""

from typing import Final

from app.features.studies.background_studies import BackgroundStudies
from app.features.studies.microscope import STRIDE, Signal
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.plot_controls import ShowMoment
from app.page.panels.shown_moment import Scrubber, Seek
from app.session.actions import Action
from app.session.frame import Frame

SIGNALS: Final[dict[str, Signal]] = {"d": "d", "λ": "lambda", "q̇": "dq", "e": "e"}
"""What a button says → the signal that is looked at."""

WRITE: Final = 0.5
"""Time between two writes of the slider while the run goes on [s]."""


class Magnify(Action, newest_by=None):
    """Look at a signal; without one at the largest jump, or at a later or earlier instant. `steps`: by which the instant moves."""

    quantity: Signal | None = None
    steps: int = 0


class SeekInstant(Seek):
    """Look at the steps about an instant."""


class MicroscopeButtons(PagePanel):
    """Buttons and slider; they are there while the microscope is.

    Args:
        view: with the panel of plots.
    """

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        gui = client.gui
        self._session, self._view = session, view
        with view.plots_tab:
            self._buttons = ChoiceButtons(
                gui,
                "single steps",
                {
                    **{said: Magnify(quantity) for said, quantity in SIGNALS.items()},
                    "Largest jump": Magnify(),
                    "◀": Magnify(steps=-STRIDE),
                    "▶": Magnify(steps=STRIDE),
                },
                "Which steps are shown: about the largest step of q̇ in the last 20 s, or ten steps earlier or later.",
                session.post,
                order=0.6,
            )

            def go_to(time: float) -> None:
                # The session makes new studies when its law's file changes.
                session.parts.of(BackgroundStudies).microscope.go_to(time)

            self._scrubber = Scrubber(gui, session, handlers, SeekInstant, go_to, 0.005, WRITE, order=0.7)
        handlers.add(Magnify, self._magnify)
        handlers.add_first(ShowMoment, self._follow)

    def _magnify(self, action: Magnify) -> None:
        microscope = self._session.parts.of(BackgroundStudies).microscope
        if action.quantity is not None:
            microscope.quantity = action.quantity
        elif action.steps:
            microscope.move(action.steps, self._session.settings.run.dt)
        else:
            microscope.go_to(None)

    def _follow(self, action: ShowMoment) -> bool:
        """Look at the steps about the moment that is shown, too."""
        if action.time is not None:
            self._session.parts.of(BackgroundStudies).microscope.go_to(action.time)
        return False

    def show(self, frame: Frame) -> None:
        """Mark the present signal, and put the slider where the instant is."""
        microscope = self._session.parts.of(BackgroundStudies).microscope
        shown = "microscope" in self._view.plots.shown and frame.of_live
        self._buttons.show(list(SIGNALS.values()).index(microscope.quantity), visible=shown)
        self._scrubber.show(frame.now, microscope.span if shown else None)
