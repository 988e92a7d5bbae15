"""The row of buttons that chooses what is shown beside the first two plots."""

from collections.abc import Callable

import viser

from app.lessons.session.lesson_session import LessonSession
from app.page.panels.choice_buttons import ChoiceButtons
from app.plots.plot_choice import possible_details
from app.session.actions import Action, SetSetting
from app.session.frame import Frame
from app.settings import PageSettings
from scenes.settings import specs


class DetailsChooser:
    """The row of buttons.

    Args:
        lessons: an open one chooses its plots itself.
        tab: of the panel of plots.
        post: has an action done on the session's thread.
    """

    def __init__(
        self, gui: viser.GuiApi, lessons: LessonSession, tab: viser.GuiTabHandle, post: Callable[[Action], None]
    ) -> None:
        spec = specs(PageSettings)["plot"]
        self._lessons, self._choices = lessons, spec.choices
        self._shown: tuple[object, ...] = ()

        with tab:
            self._buttons = ChoiceButtons(
                gui, "more plots", spec.choice_labels, spec.help, lambda i: post(SetSetting("plot", spec.choices[i])), order=0.5
            )

    def show(self, frame: Frame) -> None:
        """Offer the choices of this experiment, and mark the present one."""
        state = frame.settings, self._lessons.open
        if state == self._shown:
            return
        self._shown = state
        possible, details = possible_details(frame.settings.run), frame.settings.page.details
        marked = self._choices.index(details if details in possible else "none")
        self._buttons.show(marked, tuple(map(self._choices.index, possible)), not self._lessons.open)
