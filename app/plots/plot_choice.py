"""Which plots are shown: what can be chosen beside the first two, their order, and the columns they stand in."""

from typing import Final

from app.session.relevant_settings import OBSTACLE
from app.settings import PageSettings
from scenes.settings import RunSettings, specs

CHARTS: Final[dict[str, str]] = {
    "curve": 'Fig. 2: <b class="lam">λ</b> over <b class="d">d</b> [m]',
    "laws": "what each law makes of it: J<sub>d</sub>q̇ [m/s] over d [m]",
    "map": "trade-off of n and v",
    "safety": "laws at equal safety",
    "pairs": "the closest pair",
    "stability": "section III: does the paper’s condition hold?",
    "microscope": "single steps at dt and dt/2",
}
"""Charts that are not over time → title."""

PLACES: Final = {"distance": 0, "hand": 0, "error": 1, "elbow": 1}
"""Columns of the first two plots."""

_TWO_OF_A_KIND: Final = frozenset({"master_slave", "imitation"})


def possible_details(run: RunSettings) -> tuple[str, ...]:
    """Return the plots that an experiment offers beside the first two."""
    details: tuple[str, ...] = ("none", "joints", "rates", "microscope")
    if run.scene in OBSTACLE:
        details = ("none", "lambda", "joints", "rates", "speeds", "curve", "laws", "safety", "pairs", "stability", "microscope")
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
    return "error" in shown and (len(shown) > 3 or any(name in CHARTS for name in shown))


def layout_html(shown: tuple[str, ...]) -> str:
    """Return the style that gives every plot a column; a chart with a legend of its own takes a wider one."""
    wide = {"laws": "1.45fr", "safety": "1.9fr", "stability": "1.2fr", "pairs": "1.2fr"}
    columns = [f"minmax(0,{wide.get(name, '1fr')})" for name in shown]
    narrow = columns[:1] + columns[2:] if makes_room(shown) else columns
    return (
        f'<div class="duet-plots"><style>:root{{--duet-columns:{" ".join(columns)};--duet-narrow:{" ".join(narrow)}}}'
        "</style></div>"
    )
