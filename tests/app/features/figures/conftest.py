"""Numbers of the figures, computed once for all tests, and the files of all figures."""

import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from app.features.figures import equal_safety
from app.features.figures.command import Figures, draw_figures
from app.features.figures.drawn_figure import Plan, write_csv
from app.features.figures.figure_list import CATALOGUE, FigureEntry
from app.features.studies.law_knobs import knobs
from controllers.kinematics import Array

KNOBS = tuple(knob for knob in knobs() if knob.law in ("smooth_priority", "barrier_qp", "intermediate_value"))
"""Knobs of the figure at equal safety; the knobs of all laws would take half of the time for all figures."""


def entry(name: str) -> FigureEntry:
    return next(entry for entry in CATALOGUE if entry.name == name)


@dataclass(frozen=True)
class Table:
    settings: dict[str, str]
    columns: dict[str, list[str]]

    def __getitem__(self, name: str) -> Array:
        return np.array([float(cell) if cell else np.nan for cell in self.columns[name]])


Numbers = Callable[[str], Table]
"""Function from a figure's name to its numbers."""


def read(text: str) -> Table:
    """Content of a CSV file with no commas in its cells."""
    lines = text.splitlines()
    head = [line for line in lines if line.startswith("# ")]
    rows = [line.split(",") for line in lines[len(head) :]]
    assert all(len(row) == len(rows[0]) for row in rows)
    settings = {key: value for key, _, value in (line[2:].partition(" = ") for line in head)}
    return Table(settings, {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])})


@pytest.fixture(scope="session")
def csv_file() -> Callable[[str], str]:
    """Function from a figure's name to its CSV content, computed once with shared runs."""
    plan = Plan(quick=True)

    @cache
    def drawn(name: str) -> str:
        out = io.StringIO()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(equal_safety, "knobs", lambda: KNOBS)
            write_csv(out, entry(name).draw(plan))
        return out.getvalue()

    return drawn


@pytest.fixture(scope="session")
def table(csv_file: Callable[[str], str]) -> Numbers:
    return lambda name: read(csv_file(name))


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with all files of all figures, written as by the command."""
    out = tmp_path_factory.mktemp("figures")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(equal_safety, "knobs", lambda: KNOBS)
        assert draw_figures(Figures(out=out, quick=True, workers=1)) == 0
    return out
