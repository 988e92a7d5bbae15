"""Plan, look and files of the figures. Each colour has its own dash, for black-and-white print."""

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TextIO, TypeVar

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from app.theme import PALETTES
from scenes.children import ComputeMany, computed
from scenes.files import written
from scenes.headless import Run, Summary, TargetSource, run
from scenes.settings import LawSettings, RunSettings, named_values

T = TypeVar("T")

COLOURS: Final = PALETTES["light"]
INK: Final = COLOURS.ink
FAINT: Final = COLOURS.line
PALE: Final = COLOURS.panel

WIDTH: Final = 5.2
"""[inch]; at half a page's width the type is as large as the paper's."""

DPI: Final = 200

DASHES: Final[tuple[Any, ...]] = (
    "solid",
    (0, (6, 2)),
    (0, (1.2, 1.4)),
    (0, (6, 1.6, 1.2, 1.6)),
    (0, (3, 1.2)),
    (0, (9, 2, 2.5, 2)),
    (0, (6, 1.5, 1.2, 1.5, 1.2, 1.5)),
    (0, (1.2, 3)),
    (0, (12, 2)),
    (0, (2.5, 2.5)),
    (0, (9, 1.5, 1.2, 1.5)),
    (0, (4, 1, 1, 1, 1, 1, 1, 1)),
)

MARKERS: Final = ("o", "s", "^", "D", "v", "P", "p", "X", "*", "h", "<", ">")

SERIES: Final = (*COLOURS.joints, COLOURS.resting, COLOURS.approach, "#5c7a00", INK, "#00879a")
"""Colours of things without a symbol."""

STYLE: Final[dict[Any, Any]] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "mathtext.fontset": "stix",
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 10.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": COLOURS.faint,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": COLOURS.hair,
    "grid.linewidth": 0.8,
    "xtick.color": COLOURS.soft,
    "ytick.color": COLOURS.soft,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 9.5,
    "ytick.labelsize": 9.5,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "legend.handlelength": 2.6,
    "legend.columnspacing": 1.4,
    "lines.linewidth": 1.7,
    "lines.solid_capstyle": "round",
    "text.color": INK,
    "figure.facecolor": "white",
    "figure.constrained_layout.use": True,
    # The same ids in every SVG of the same figure.
    "svg.hashsalt": "lwr-duet",
    "svg.fonttype": "path",
    "path.simplify": True,
    "axes.unicode_minus": True,
}


def sheet(height: float, width: float = WIDTH) -> Figure:
    """Sizes in inches; no window."""
    return Figure(figsize=(width, height))


def stack(height: float, rows: int, ratios: tuple[float, ...] | None = None) -> tuple[Figure, list[Axes]]:
    figure = sheet(height)
    grid = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=ratios)
    figure.align_ylabels()
    return figure, list(grid[:, 0])


def tag(axes: Axes, text: str, x: float, y: float, colour: str, size: float) -> None:
    axes.text(x, y, text, color=colour, ha="left", va="center", fontsize=size)


class Plan:
    """Common plan of one call's figures.

    Args:
        on_progress: called with the number of new steps.
    """

    def __init__(
        self,
        seed: int = 1,
        quick: bool = False,
        on_progress: Callable[[int], object] | None = None,
        compute: ComputeMany[Any] = computed,
    ) -> None:
        self.seed, self.quick = seed, quick
        self._on_progress, self._compute = on_progress, compute
        self._kept: dict[tuple[RunSettings, float], Run] = {}

    def either(self, full: T, quick: T) -> T:
        return quick if self.quick else full

    def settings(self, law: dict[str, Any] | None = None, **changes: Any) -> RunSettings:
        return RunSettings(seed=self.seed, law=LawSettings(**(law or {})), **changes)

    def run(self, settings: RunSettings, seconds: float, person: TargetSource | None = None) -> Run:
        return run(settings, seconds, person, on_progress=self._on_progress)

    def each(self, function: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> list[T]:
        """Results in the order of the calls.

        Args:
            function: at a module's top level.
            calls: arguments; the first two are the settings and the length of a run [s].
        """
        results: dict[int, T] = {}
        for index, result in self._compute(function, calls):
            results[index] = result
            settings, seconds, *_ = calls[index]
            if self._on_progress:
                self._on_progress(round(seconds / settings.dt))
        return [results[index] for index in range(len(calls))]

    def summaries(self, settings: Sequence[RunSettings], seconds: float) -> list[Summary]:
        return self.each(summary_of, [(each, seconds) for each in settings])

    def shared(self, settings: RunSettings, seconds: float) -> Run:
        """Cached run with the settings' own inputs; read-only."""
        key = replace(settings), seconds
        if key not in self._kept:
            self._kept[key] = self.run(settings, seconds)
        return self._kept[key]


def summary_of(settings: RunSettings, seconds: float) -> Summary:
    return run(settings, seconds).summary


@dataclass(frozen=True)
class Drawn:
    """A finished figure.

    Attributes:
        settings: key → value of all that the numbers depend on.
        found: findings, Markdown sentences.
    """

    figure: Figure
    columns: Sequence[str]
    rows: Iterable[Sequence[Any]]
    settings: Mapping[str, Any]
    found: Sequence[str]


def csv_head(settings: RunSettings, *varied: str, **more: Any) -> dict[str, Any]:
    """Head of a CSV file, without the varied settings."""
    return {key: value for key, value in named_values(settings).items() if key not in varied} | more


def write_csv(out: TextIO, drawn: Drawn) -> None:
    """Settings become # lines, nan an empty cell."""
    for key, value in drawn.settings.items():
        out.write(f"# {key} = {value}\n")
    table = csv.writer(out, lineterminator="\n")
    table.writerow(drawn.columns)
    table.writerows(["" if value != value else value for value in row] for row in drawn.rows)


def save_figure(drawn: Drawn, folder: Path, stem: str) -> None:
    """Write `stem`.png, .svg and .csv.

    Raises:
        BadSetting: the folder cannot be written to.
    """
    with written(folder / f"{stem}.png", "out") as new:
        drawn.figure.savefig(new, format="png", dpi=DPI, metadata={"Software": None})
    with written(folder / f"{stem}.svg", "out") as new:
        drawn.figure.savefig(new, format="svg", metadata={"Date": None, "Creator": "lwr-duet"})
    with written(folder / f"{stem}.csv", "out") as new, new.open("w", encoding="utf-8", newline="\n") as out:
        write_csv(out, drawn)
