"""Charts that features add to the plots; cheap to import."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final


@dataclass(frozen=True)
class FurtherChart:
    """A chart of a feature.

    Attributes:
        draw: (frame, height [CSS px]) → HTML.
        state: frame → state; the chart is redrawn if it changes.
    """

    title: str
    draw: Callable[[Any, int], str]
    state: Callable[[Any], object]


Charts = Mapping[str, FurtherChart]

_ADDED: Final[list[Callable[[], Charts]]] = []


def add_charts(made: Iterable[Callable[[], Charts]]) -> None:
    """Add functions that return charts, called when the first one is needed."""
    _ADDED.extend(make for make in made if make not in _ADDED)
    further_charts.cache_clear()


@cache
def further_charts() -> Charts:
    return {name: chart for make in _ADDED for name, chart in make().items()}
