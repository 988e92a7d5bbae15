"""Drop-down of further laws in the plot of laws."""

from typing import Final

from app.i18n.speaking import N_, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import MARK
from app.plots.ticked_laws import TickedLaws
from app.session.actions import Action
from app.session.frame import Frame
from app.web.control_events import on_entry
from scenes.law_answers import LawOfFile
from scenes.laws import LAWS

HINT: Final = N_("Draws up to three laws in addition to the running one; a fourth replaces the oldest.")

NOT_DRAWN: Final = "○ "

NO_LAW: Final = N_("up to three laws")


class TickLaw(Action, newest_by=None):
    """Tick or untick a law."""

    law: str


class LawTicks(PagePanel):
    """Row below the plot of laws; each entry ticks or unticks a law."""

    def __init__(self, page: PanelContext) -> None:
        session, self._view, self._laws = page.session, page.view, page.session.parts.of(TickedLaws)
        page.handlers.add(TickLaw, lambda action: self._laws.tick(action.law))
        self._said = {name: f"{number} {tr(law.short)}" for number, (name, law) in enumerate(LAWS.items(), 1)}
        said, self._no_law = self._said, tr(NO_LAW)

        def take(entered: str) -> None:
            # The mark may have changed while the entry was on its way.
            plain = entered.removeprefix(MARK).removeprefix(NOT_DRAWN)
            for law in (name for name, text in said.items() if text == plain and entered != plain):
                session.post(TickLaw(law))

        with self._view.plots_tab:
            self._list = on_entry(
                page.client.gui.add_dropdown(
                    tr("also draw"), self._entries((), ()), hint=tr(HINT), order=90.0, visible=False
                ),
                take,
            )

    def show(self, frame: Frame) -> None:
        ticked = tuple(self._laws.places)
        running = () if isinstance(frame.simulation.law, LawOfFile) else (frame.settings.run.law.law,)
        self._list.visible = "laws" in self._view.plots.shown
        entries = self._entries(ticked, (*running, *ticked))
        if entries != self._list.options:
            self._list.options = entries
        if self._list.value != entries[0]:
            self._list.value = entries[0]

    def _entries(self, ticked: tuple[str, ...], drawn: tuple[str, ...]) -> tuple[str, ...]:
        """Text of the row, then one entry per law."""
        row = ", ".join(self._said[name] for name in ticked) or self._no_law
        return (row, *((MARK if name in drawn else NOT_DRAWN) + text for name, text in self._said.items()))
