"""The controls of the plots: which are shown beside the first two, which moment, and, for the microscope, signal and instant."""

import re
from typing import Final

from markupsafe import Markup

from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.shown_moment import Scrubber, Seek
from app.plots.plot_choice import possible_details
from app.session.actions import Action, SetSetting
from app.session.frame import Frame
from app.session.microscope import STRIDE, Signal
from app.settings import PageSettings
from app.text.templates import element
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of
from scenes.settings import specs


class DetailsChooser(PagePanel):
    """The row of buttons; not seen while a part of the session leads, which chooses the plots.

    Args:
        view: with the panel of plots.
    """

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        del handlers
        spec = specs(PageSettings)["plot"]
        self._session, self._choices = session, spec.choices
        with view.plots_tab:
            self._buttons = ChoiceButtons(
                client.gui,
                "more plots",
                {said: SetSetting("plot", choice) for choice, said in spec.options().items()},
                spec.help,
                session.post,
                order=0.5,
            )

    def show(self, frame: Frame) -> None:
        """Offer the choices of this experiment, and mark the present one."""
        possible, details = possible_details(frame.settings.run), frame.settings.page.details
        marked = self._choices.index(details if details in possible else "none")
        self._buttons.show(marked, tuple(map(self._choices.index, possible)), not self._session.parts.lead)


SIGNALS: Final[dict[str, Signal]] = {"d": "d", "λ": "lambda", "q̇": "dq", "e": "e"}
"""What a button says → the signal that is looked at."""

WRITE: Final = 0.5
"""Time between two writes of the slider while the run goes on [s]."""


class Magnify(Action, newest_by=None):
    """Look at a signal; without one at the largest jump, or so many steps on."""

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
                session.studies.microscope.go_to(time)

            self._scrubber = Scrubber(gui, session, handlers, SeekInstant, go_to, 0.005, WRITE, order=0.7)
        handlers.add(Magnify, self._magnify)

    def _magnify(self, action: Magnify) -> None:
        microscope = self._session.studies.microscope
        if action.quantity is not None:
            microscope.quantity = action.quantity
        elif action.steps:
            microscope.move(action.steps, self._session.settings.run.dt)
        else:
            microscope.go_to(None)

    def show(self, frame: Frame) -> None:
        """Mark the present signal, and put the slider where the instant is."""
        if frame.studies is None:
            return
        microscope = frame.studies.microscope
        shown = "microscope" in self._view.plots.shown and frame.of_live
        self._buttons.show(list(SIGNALS.values()).index(microscope.quantity), visible=shown)
        self._scrubber.show(frame.now, microscope.span if shown else None)


_GRIP: Final = Markup("<style>.u-over{cursor:ew-resize!important;touch-action:pan-y}</style>")


class ShowMoment(Action):
    """Show a moment of the run, if it stands or is replayed. `text`: time [s], as the page's script sends it."""

    text: str


class MomentChooser(PagePanel):
    """Takes the moment that `plot_moments.js` sends by a hidden box while the visitor drags over a plot.

    Args:
        view: with the panel of plots.
    """

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        self._session = session
        with view.plots_tab:
            box = client.gui.add_text("", "", visible=False, order=-1.0)
            on_entry(box, lambda text: session.post(ShowMoment(text)))
            self._mark = element("i", hidden="", data_duet_seek=uuid_of(box))
            self._html = client.gui.add_html("", order=-1.0)
        handlers.add(ShowMoment, self._show_moment)

    def _show_moment(self, action: ShowMoment) -> None:
        if re.fullmatch(r"\d{1,7}(\.\d{1,6})?", action.text):
            self._session.player.review(float(action.text))
            self._session.studies.microscope.go_to(float(action.text))

    def show(self, frame: Frame) -> None:
        """Offer the plots to be dragged over while the run stands or is replayed."""
        offered = (frame.pace.paused or frame.replayed) and frame.sample.time > 0.0
        self._html.content = self._mark + _GRIP if offered else ""
