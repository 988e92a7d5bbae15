"""The row of buttons that chooses what is shown beside the first two plots."""

from collections.abc import Callable

import viser

from app.page.panels.choice_buttons import ChoiceButtons
from app.plots.plot_choice import possible_details
from app.session.actions import Action, SetSetting
from app.session.session import Session
from app.settings import PageSettings
from scenes.settings import specs


class DetailsChooser:
    """The row of buttons that chooses what is shown beside the first two plots.

    Args:
        gui: of the operator's page.
        session: the visitor's.
        tab: of the panel of plots.
        post: has an action done on the session's thread.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, tab: viser.GuiTabHandle, post: Callable[[Action], None]) -> None:
        spec = specs(PageSettings)["plot"]
        self._session, self._post = session, post
        self._labels: dict[str, str] = dict(zip(spec.choices, spec.choice_labels, strict=True))
        with tab:
            self._buttons = ChoiceButtons(gui, "more plots", spec.choice_labels, spec.help, self._chosen, order=0.5)

    def _chosen(self, index: int) -> None:
        choice = list(self._labels)[index]
        self._post(SetSetting("plot", choice))

    def show(self, in_lesson: bool) -> None:
        """Offer the choices of this experiment, and mark the present one; a lesson has the plots that it needs."""
        self._buttons.show(not in_lesson)
        settings = self._session.settings
        possible = possible_details(settings.run)
        present = settings.page.details if settings.page.details in possible else "none"
        choices = list(self._labels)
        self._buttons.offer(tuple(choices.index(choice) for choice in possible))
        self._buttons.mark(choices.index(present))
