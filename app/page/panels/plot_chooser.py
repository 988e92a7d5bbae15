"""What is shown beside the first two plots: what there is to choose, where it stands, and the buttons that choose it."""

from typing import Final

import viser

from app.page.panels.choice_buttons import ChoiceButtons
from app.session.relevant_settings import OBSTACLE
from app.session.session import Session
from app.settings import PageSettings
from scenes.settings import RunSettings, specs

CHARTS: Final[dict[str, str]] = {
    "curve": 'Fig. 2: <b class="lam">λ</b> over <b class="d">d</b> [m]',
    "laws": "what each law makes of it: J<sub>d</sub>q̇ [m/s] over d [m]",
    "map": "trade-off of n and v",
    "pairs": "the closest pair",
    "stability": "section III: does the paper’s condition hold?",
}
"""What is not over time → its title."""

PLACES: Final = {"distance": 0, "hand": 0, "error": 1, "elbow": 1}
"""Where the first two plots stand."""

_TWO_OF_A_KIND: Final = frozenset({"master_slave", "imitation"})


def possible_details(run: RunSettings) -> tuple[str, ...]:
    """Return what can be shown beside the first two plots in an experiment."""
    details: tuple[str, ...] = ("none", "joints", "rates")
    if run.scene in OBSTACLE:
        details = ("none", "lambda", "joints", "rates", "speeds", "curve", "laws", "pairs", "stability")
    if run.scene in _TWO_OF_A_KIND:
        details += ("follow",)
    if run.scene == "hold":
        details += ("map",)
    order = specs(PageSettings)["plot"].choices
    return tuple(sorted(details, key=order.index))


_ALONE: Final = {"error": "hand", "distance": "elbow"}
"""What stands for the first two plots where there is nothing to keep clear of."""


def cells(run: RunSettings, details: str, only: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return the names of what is shown, in order; `only`: instead of the first two."""
    shown = ("distance", "error") if run.scene in OBSTACLE else ("hand", "elbow")
    if only:
        shown = only if run.scene in OBSTACLE else tuple(_ALONE.get(name, name) for name in only)
        possible = (*("distance", "error", "hand", "elbow"), *possible_details(run))
        shown = tuple(name for name in shown if name in possible)
        details = "none" if details in shown else details
    if details == "none" or details not in possible_details(run):
        return shown
    return (*shown, details, *(("follow_other",) if details == "follow" and run.scene == "imitation" else ()))


def makes_room(shown: tuple[str, ...]) -> bool:
    """Return whether the squared error is left out on a narrow screen."""
    return len(shown) > 3 or any(name in CHARTS for name in shown)


def layout_html(shown: tuple[str, ...]) -> str:
    """Return the style that gives every plot a column; a chart with a legend of its own takes a wider one."""
    wide = {"laws": "1.45fr", "stability": "1.2fr", "pairs": "1.2fr"}
    columns = [f"minmax(0,{wide.get(name, '1fr')})" for name in shown]
    narrow = columns[:1] + columns[2:] if makes_room(shown) else columns
    return (
        f'<div class="duet-plots"><style>:root{{--duet-columns:{" ".join(columns)};--duet-narrow:{" ".join(narrow)}}}'
        "</style></div>"
    )


class DetailsChooser:
    """The row of buttons that chooses what is shown beside the first two plots.

    Args:
        gui: of the visitor who operates it.
        session: whose plots.
        tab: of the panel of plots.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, tab: viser.GuiTabHandle) -> None:
        spec = specs(PageSettings)["plot"]
        self._session = session
        self._labels: dict[str, str] = dict(zip(spec.choices, spec.choice_labels, strict=True))
        with tab:
            self._buttons = ChoiceButtons(gui, "more plots", spec.choice_labels, spec.help, self._chosen, order=0.5)

    def _chosen(self, index: int) -> None:
        choice = list(self._labels)[index]
        self._session.post(lambda: self._session.change("plot", choice), "plot")

    def show(self, in_lesson: bool) -> None:
        """Offer the choices of this experiment, and mark the present one; a lesson has the plots that it needs."""
        self._buttons.show(not in_lesson)
        settings = self._session.settings
        possible = possible_details(settings.run)
        present = settings.page.details if settings.page.details in possible else "none"
        choices = list(self._labels)
        self._buttons.offer(tuple(choices.index(choice) for choice in possible))
        self._buttons.mark(choices.index(present))
