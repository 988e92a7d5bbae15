"""Charts that features add to the plots; importing this costs nothing."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final


@dataclass(frozen=True)
class FurtherChart:
    """A chart that is drawn from what a feature has computed.

    Attributes:
        title: in English, as HTML.
        draw: (frame, height [CSS px]) → HTML.
        state: frame → what the chart depends on beside the run, to compare: a chart of the same state is not drawn again.
    """

    title: str
    draw: Callable[[Any, int], str]
    state: Callable[[Any], object]


Charts = Mapping[str, FurtherChart]
"""Choice of the setting `plot` → chart."""

_ADDED: Final[list[Callable[[], Charts]]] = []


def add_charts(made: Iterable[Callable[[], Charts]]) -> None:
    """Add functions that return charts; each is called when the first chart is looked for."""
    _ADDED.extend(make for make in made if make not in _ADDED)
    further_charts.cache_clear()


@cache
def further_charts() -> Charts:
    """All charts that were added."""
    return {name: chart for make in _ADDED for name, chart in make().items()}
