"""Choice of plots, their order and columns."""

from typing import Final

from markupsafe import Markup

from app.i18n.speaking import N_
from app.plots.chart_list import further_charts
from app.settings import PageSettings
from app.text.first_task_texts import in_symbols, wording
from app.text.templates import element, lowered, tr_html
from scenes.settings import RunSettings, specs

CHARTS: Final[dict[str, str]] = {
    "curve": N_('Fig. 2: <b class="lam">λ</b> over <b class="d">d</b> [m]'),
    "laws": N_('each law: J<sub>d</sub>q̇ [m/s] over <b class="d">d</b> [m]'),
    "pairs": "the closest pair",
    "stability": "section III: does the paper’s condition hold?",
    "laps": "laps of the hand",
    "joint_laps": "laps of two joints",
}

_ADDED: Final = ("safety", "microscope", "map")
"""Choices offered only if a feature draws them."""


def is_chart(name: str) -> bool:
    return name in CHARTS or name in further_charts()


def chart_title(name: str, run: RunSettings) -> Markup:
    """Title as HTML, with the law's variable if that is not d."""
    written = CHARTS[name] if name in CHARTS else further_charts()[name].title
    title = in_symbols(tr_html(wording(written, run.quantity)), run.quantity)
    if not run.has_law_distance:
        return title
    symbol = run.quantity.symbol
    variable, of_law = element("b", symbol, class_="d"), element("b", lowered(f"{symbol}_law"), class_="d")
    return Markup(str(title).replace(variable, of_law))


PLACES: Final = {"distance": 0.0, "hand": 0.5, "error": 1.0, "elbow": 1.0}
"""Columns of the first two plots, and of the hand's error beside the distance."""


def possible_details(run: RunSettings) -> tuple[str, ...]:
    details: tuple[str, ...] = ("none", "joints", "rates", "microscope")
    if run.experiment.obstacle != "nothing":
        details = (
            "none",
            "lambda",
            "joints",
            "rates",
            "speeds",
            "curve",
            "laws",
            "safety",
            "pairs",
            "stability",
            "microscope",
        )
    if run.draws_circle:
        details += ("laps", "joint_laps")
    if run.experiment.follows != "nothing":
        details += ("follow",)
    if run.experiment.maps:
        details += ("map",)
    order = specs(PageSettings)["plot"].choices
    drawn = (name for name in details if name not in _ADDED or name in further_charts())
    return tuple(sorted(drawn, key=order.index))


def first_plots(run: RunSettings) -> tuple[str, str]:
    return ("hand", "elbow") if run.experiment.obstacle == "nothing" else ("distance", "error")


_COMPUTED: Final = ("none", "map", "safety")
"""Plots that no part of the page may choose."""


def possible_plots(run: RunSettings) -> tuple[str, ...]:
    """Plots that a part of the page may choose."""
    hand = ("hand",) if run.experiment.error_unit == "m²" else ()
    return tuple(
        dict.fromkeys(
            (*first_plots(run), *hand, *(name for name in possible_details(run) if name not in _COMPUTED))
        )
    )


_ALONE: Final = {"error": "hand", "distance": "elbow"}


def cells(run: RunSettings, details: str, only: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Names of shown plots, a projector's single plot first. `only`: replaces the first two, if possible."""
    first: tuple[str, ...] = first_plots(run)
    shown = first
    if only:
        shown = tuple(_ALONE.get(name, name) for name in only) if first[0] == "hand" else only
        possible = (*PLACES, *possible_details(run))
        shown = tuple(name for name in shown if name in possible) or first
        details = "none" if details in shown else details
    if details == "none" or details not in possible_details(run):
        return shown
    return (
        *shown,
        details,
        *(("follow_other",) if details == "follow" and run.experiment.follows == "person" else ()),
    )


def makes_room(shown: tuple[str, ...]) -> bool:
    return "error" in shown and (len(shown) > 3 or any(is_chart(name) for name in shown))


def place_of(name: str) -> float:
    if name in PLACES:
        return PLACES[name]
    order = specs(PageSettings)["plot"].choices
    return 2.0 + order.index(name.removesuffix("_other")) + (0.5 if name == "follow_other" else 0.0)


def layout_html(shown: tuple[str, ...]) -> str:
    wide = {"safety": "1.9fr", "stability": "1.2fr", "pairs": "1.2fr"}
    columns = [f"minmax(0,{wide.get(name, '1fr')})" for name in sorted(shown, key=place_of)]
    narrow = columns[:1] + columns[2:] if makes_room(shown) else columns
    style = f":root{{--duet-columns:{' '.join(columns)};--duet-narrow:{' '.join(narrow)}}}"
    return element("div", "", f"<style>{style}</style>", class_="duet-plots")
