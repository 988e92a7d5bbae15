"""Controls of the microscope."""

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
from app.text.first_task_texts import said_of
from scenes.quantities import DISTANCE

SIGNALS: Final[dict[str, Signal]] = {"d": "d", "λ": "lambda", "q̇": "dq", "e": "e"}

WRITE: Final = 0.5
"""Period of the slider's updates [s]."""


class Magnify(Action, newest_by=None):
    """Select a signal, an instant `steps` later, or the largest jump."""

    quantity: Signal | None = None
    steps: int = 0


class SeekInstant(Seek):
    """Show the steps around an instant."""


class MicroscopeButtons(PagePanel):
    """Buttons and slider of the microscope."""

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        gui = client.gui
        self._session, self._view = session, view
        self._quantity = DISTANCE
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
        if action.time is not None:
            self._session.parts.of(BackgroundStudies).microscope.go_to(action.time)
        return False

    def show(self, frame: Frame) -> None:
        microscope = self._session.parts.of(BackgroundStudies).microscope
        quantity = frame.settings.run.quantity
        if quantity is not self._quantity:
            self._quantity = quantity
            self._buttons.say(said_of(quantity))
        shown = "microscope" in self._view.plots.shown and frame.of_live
        self._buttons.show(list(SIGNALS.values()).index(microscope.quantity), visible=shown)
        self._scrubber.show(frame.now, microscope.span if shown else None)
