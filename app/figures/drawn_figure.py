"""What a figure is made of, and how it becomes files: PNG, SVG and CSV. The same run gives the same bytes of CSV."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from matplotlib.figure import Figure

from app.figures.figure_style import DPI
from app.runtime.output_file import written
from scenes.settings import RunSettings, values


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


def shown(settings: RunSettings, **more: Any) -> dict[str, Any]:
    """Return the settings of a run and more, for the head of a CSV file."""
    return {**values(settings), **more}


def write_csv(out: TextIO, drawn: Drawn) -> None:
    """Write the numbers, the settings as # lines on top. A number that is not known is an empty cell."""
    for key, value in drawn.settings.items():
        out.write(f"# {key} = {value}\n")
    out.write(",".join(drawn.columns) + "\n")
    for row in drawn.rows:
        out.write(",".join(map(_cell, row)) + "\n")


def _cell(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else repr(float(value))
    text = str(value)
    return f'"{text}"' if "," in text else text


def save(drawn: Drawn, folder: Path, stem: str) -> None:
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
