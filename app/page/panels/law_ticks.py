"""Buttons of the laws that can be drawn beside the running one."""

from typing import Final

from app.i18n.speaking import N_
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.plots.ticked_laws import TickedLaws
from app.session.actions import Action
from app.session.frame import Frame
from scenes.law_answers import LawOfFile
from scenes.laws import LAWS

HINT: Final = N_("Draws up to three laws beside the running one; a fourth takes the place of the oldest.")


class TickLaw(Action, newest_by=None):
    law: str


class LawTicks(PagePanel):
    """Row below the plots. The running law is always drawn and marked, so that no button moves."""

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        self._view, self._laws = view, session.parts.of(TickedLaws)
        handlers.add(TickLaw, lambda action: self._laws.tick(action.law))
        with view.plots_tab:
            self._buttons = ChoiceButtons(
                client.gui,
                N_("also draw"),
                {law.short: TickLaw(name) for name, law in LAWS.items()},
                HINT,
                session.post,
                order=90.0,
                numbered=True,
            )
        self._buttons.tick((), visible=False)

    def show(self, frame: Frame) -> None:
        names, drawn = list(LAWS), set(self._laws.places)
        if not isinstance(frame.simulation.law, LawOfFile):
            drawn.add(frame.settings.run.law.law)
        self._buttons.tick(tuple(names.index(name) for name in drawn), "laws" in self._view.plots.shown)
