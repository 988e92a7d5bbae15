"""Choice of the plots, and of a moment."""

import re
from typing import Final

from markupsafe import Markup

from app.i18n.speaking import N_
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.plots.plot_choice import possible_details
from app.session.actions import Action, SetSetting
from app.session.frame import Frame
from app.settings import PageSettings
from app.text.first_task_texts import said_of
from app.text.templates import element
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of
from scenes.quantities import DISTANCE
from scenes.settings import RunSettings, specs


class MorePlots(Action): ...


class DetailsChooser(PagePanel):
    """Buttons that choose the plots; hidden while a part of the session leads. With few controls one
    button opens them."""

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        handlers.add(MorePlots, self._open)
        spec = specs(PageSettings)["plot"]
        self._session, self._choices, self._controls = session, spec.choices, page.controls
        self._opened = False
        self._run: RunSettings | None = None
        self._possible: tuple[str, ...] = ()
        with view.plots_tab:
            self._buttons = ChoiceButtons(
                client.gui,
                "more plots",
                {said: SetSetting("plot", choice) for choice, said in spec.options().items()},
                spec.help,
                session.post,
                order=0.5,
            )
            self._opener = ChoiceButtons(
                client.gui, "", {N_("More plots"): MorePlots()}, spec.help, session.post, order=0.5
            )

    def _open(self, action: MorePlots) -> None:
        del action
        self._opened = True

    def show(self, frame: Frame) -> None:
        run = frame.settings.run
        if run is not self._run:
            if run.quantity is not (DISTANCE if self._run is None else self._run.quantity):
                self._buttons.say(said_of(run.quantity))
            self._run, self._possible = run, possible_details(run)
        possible, details = self._possible, frame.settings.page.details
        marked = self._choices.index(details if details in possible else "none")
        # A chosen plot stays marked.
        self._opened = self._opened or marked != self._choices.index("none")
        folded = self._controls.small and not self._opened
        self._buttons.show(
            marked, tuple(map(self._choices.index, possible)), not (folded or self._session.parts.lead)
        )
        self._opener.show(visible=folded and not self._session.parts.lead)


_GRIP: Final = Markup("<style>.u-over{cursor:ew-resize!important;touch-action:pan-y}</style>")


class ShowMoment(Action):
    """Show a moment of a paused or replayed run. `text`: time [s]."""

    text: str

    @property
    def time(self) -> float | None:
        """Time [s]; None if the text is invalid."""
        return float(self.text) if re.fullmatch(r"\d{1,7}(\.\d{1,6})?", self.text) else None


class MomentChooser(PagePanel):
    """Receives the moment from `plot_moments.js`."""

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
        if action.time is not None:
            self._session.player.review(action.time)

    def show(self, frame: Frame) -> None:
        offered = (frame.pace.paused or frame.replayed) and frame.sample.time > 0.0
        self._html.content = self._mark + _GRIP if offered else ""
