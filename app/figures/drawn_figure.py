"""What a figure is made of: the plan with its shared runs, and how it becomes files: PNG, SVG and CSV."""

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TextIO, TypeVar

from matplotlib.figure import Figure

from app.figures.figure_style import DPI
from scenes.children import ComputeMany, computed
from scenes.files import written
from scenes.headless import Run, Summary, TargetSource, run
from scenes.settings import LawSettings, RunSettings, values

T = TypeVar("T")


class Plan:
    """What all figures of one call have in common.

    Args:
        seed: of every person who plays a part.
        quick: shorter runs and fewer points, for a first look and for tests.
        on_progress: called with the number of steps made since the last call.
        compute: makes the runs of which there are many; in this process, if nothing else is given.
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
        """Return the first, or the second of a quick plan."""
        return quick if self.quick else full

    def settings(self, law: dict[str, Any] | None = None, **changes: Any) -> RunSettings:
        """Return the defaults with the plan's seed, and with changes to fields of the law and of the rest."""
        return RunSettings(seed=self.seed, law=LawSettings(**(law or {})), **changes)

    def run(self, settings: RunSettings, seconds: float, person: TargetSource | None = None) -> Run:
        """Simulate, and let go of it afterwards."""
        return run(settings, seconds, person, on_progress=self._on_progress)

    def each(self, function: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> list[T]:
        """Return the results of many calls, in their order.

        Args:
            function: at a module's top level.
            calls: the arguments of each; the first two are the settings and the length of a run [s].
        """
        results: dict[int, T] = {}
        for index, result in self._compute(function, calls):
            results[index] = result
            settings, seconds, *_ = calls[index]
            if self._on_progress:
                self._on_progress(round(seconds / settings.dt))
        return [results[index] for index in range(len(calls))]

    def summaries(self, settings: Sequence[RunSettings], seconds: float) -> list[Summary]:
        """Simulate many times with the settings' own person, and return what the runs came to."""
        return self.each(summary_of, [(each, seconds) for each in settings])

    def shared(self, settings: RunSettings, seconds: float) -> Run:
        """Simulate with the settings' own person, or return the run of an earlier figure; only to be read."""
        key = replace(settings), seconds
        if key not in self._kept:
            self._kept[key] = self.run(settings, seconds)
        return self._kept[key]


def summary_of(settings: RunSettings, seconds: float) -> Summary:
    """Return what a run with the settings' own person comes to."""
    return run(settings, seconds).summary


@dataclass(frozen=True)
class Drawn:
    """A finished figure.

    Attributes:
        figure: ready to be saved.
        columns: names of the columns of its numbers.
        rows: of numbers and words.
        settings: key → value, whatever the numbers depend on.
        found: what we found, sentences in Markdown, with numbers of these very runs.
    """

    figure: Figure
    columns: Sequence[str]
    rows: Iterable[Sequence[Any]]
    settings: Mapping[str, Any]
    found: Sequence[str]


def csv_head(settings: RunSettings, *varied: str, **more: Any) -> dict[str, Any]:
    """Return the settings of a run without those that vary, by key, and more, for the head of a CSV file."""
    return {key: value for key, value in values(settings).items() if key not in varied} | more


def write_csv(out: TextIO, drawn: Drawn) -> None:
    """Write the numbers, the settings as # lines on top. A number that is not known is an empty cell."""
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
