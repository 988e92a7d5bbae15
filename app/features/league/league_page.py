"""The league as Markdown and as an offline page."""

import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from app.features.figures.drawn_figure import COLOURS, MARKERS, SERIES, STYLE, sheet
from app.features.lab_report.report_html import LOCKED
from app.features.league.entrants import Entrant
from app.features.league.league_files import Played
from app.features.league.league_runs import (
    CRITICAL_DISTANCE,
    EDITION,
    LEVELS,
    NATURAL_SPEED,
    ROBOTS,
    SCENES,
    Event,
    Level,
    RobotKind,
    Schedule,
)
from app.text.templates import page_of_template
from app.theme import css_variables
from scenes.experiments import EXPERIMENTS
from scenes.laws import DEFAULT_LAW
from scenes.settings import specs

COLUMNS: Final = (
    *(
        "Law",
        "Lost while w ≤ v [mm]",
        "Smallest d [mm]",
        "e², the paper's law = 1",
        "Step of q̇ [rad/s]",
        "At bounds [%]",
    ),
    *("Step [µs]", "Knob"),
)


class LeagueRow(NamedTuple):
    """An entrant at one level, on one kind of robots; worst of all runs unless stated. None or () without a
    run.

    Attributes:
        lost, d_min: [m].
        e2: mean e² over that of the paper's law, geometric mean of the scenes.
        dq_step: [rad/s].
        at_bounds: share of the time.
        step_us: median of the scenes [µs].
        values: of the knob, one per scene; SI.
    """

    entrant: Entrant
    lost: float | None
    d_min: float | None
    e2: float | None
    dq_step: float | None
    at_bounds: float | None
    step_us: float | None
    values: tuple[float, ...]
    notes: tuple[str, ...]

    def cells(self) -> tuple[str, ...]:
        """In the order of `COLUMNS`."""
        numbers = (
            (self.lost, 1e3, ".1f"), (self.d_min, 1e3, ".0f"), (self.e2, 1.0, ".2f"),
            (self.dq_step, 1.0, ".3g"), (self.at_bounds, 1e2, ".1f"), (self.step_us, 1.0, ".0f"),
        )  # fmt: skip
        said = (
            "–" if value is None else f"{value * scale:{form}}".replace("-", "−")
            for value, scale, form in numbers
        )
        return (self.entrant.label, *said, "; ".join(filter(None, (self._knob(), *self.notes))))

    def _knob(self) -> str:
        if not self.values:
            return ""
        key = self.entrant.knob
        label, unit, scale = "offset of d", "mm", 1e3
        if key != "offset":
            spec = specs()[key]
            label, unit, scale = spec.label, spec.page_unit or spec.unit, spec.page_scale
        low, high = (
            f"{value * scale:.3g}".replace("-", "−") for value in (min(self.values), max(self.values))
        )
        return f"{label} = {low if low == high else f'{low} to {high}'} {unit}".rstrip()


def league_rows(
    entrants: Sequence[Entrant],
    outcomes: Sequence[Played],
    schedule: Schedule,
    level: Level,
    robot: RobotKind,
    half: str = "public",
) -> list[LeagueRow]:
    """Best first: by loss with their own settings, by error at equal safety."""
    known = {
        (one.name, one.event.scene): one
        for one in outcomes
        if (one.event.level, one.event.robot) == (level, robot)
    }
    rows = [_row(entrant, known, schedule, half) for entrant in entrants]

    def place(row: LeagueRow) -> tuple[float, float]:
        e2 = math.inf if row.e2 is None else row.e2
        lost = math.inf if row.lost is None else round(row.lost, 4)
        return (lost, e2) if level == "default" else (e2, lost)

    return sorted(rows, key=place)


def _row(entrant: Entrant, known: dict[tuple[str, str], Played], schedule: Schedule, half: str) -> LeagueRow:
    mine = {scene: known[entrant.name, scene].outcome for scene in SCENES if (entrant.name, scene) in known}
    missing: dict[str, list[str]] = {}
    for scene, outcome in mine.items():
        if outcome.problem:
            missing.setdefault(outcome.problem, []).append(EXPERIMENTS[scene].short)
    notes = tuple(
        why if len(scenes) == len(SCENES) else f"{', '.join(scenes)}: {why}"
        for why, scenes in missing.items()
    )
    runs = [run for outcome in mine.values() for run in outcome.runs if run.half == half]
    if not runs:
        return LeagueRow(entrant, None, None, None, None, None, None, (), notes)
    ratios = [ratio for scene in mine if (ratio := _ratio(known, entrant.name, scene, half)) is not None]
    whole = len(ratios) == len(SCENES) and all(ratio > 0.0 for ratio in ratios)
    return LeagueRow(
        entrant,
        lost=max(run.lost for run in runs),
        d_min=min(run.d_min for run in runs),
        e2=float(np.exp(np.mean(np.log(ratios)))) if whole else None,
        dq_step=max(run.dq_step for run in runs),
        at_bounds=sum(run.at_bounds for run in runs)
        / sum(schedule.seconds * NATURAL_SPEED / run.speed for run in runs),
        step_us=float(
            np.median([outcome.step_us for outcome in mine.values() if outcome.step_us is not None])
        ),
        values=tuple(outcome.value for outcome in mine.values() if outcome.value is not None),
        notes=notes,
    )


def _ratio(known: dict[tuple[str, str], Played], name: str, scene: str, half: str) -> float | None:
    """Mean e² over the paper's law's; None if one has no run."""
    means: list[float] = []
    for one in (name, DEFAULT_LAW):
        played = known.get((one, scene))
        errors = [run.e2_max for run in played.outcome.runs if run.half == half] if played else []
        if not errors:
            return None
        means.append(float(np.mean(errors)))
    return means[0] / means[1]


def league_tables(
    entrants: Sequence[Entrant], outcomes: Sequence[Played], schedule: Schedule
) -> list[tuple[str, list[LeagueRow]]]:
    halves = {"public": "", "hidden": ", hidden half"} if schedule.word else {"public": ""}
    return [
        (f"{title}, {robot} robots{more}", league_rows(entrants, outcomes, schedule, level, robot, half))
        for half, more in halves.items()
        for level, title in LEVELS.items()
        for robot in ROBOTS
    ]


def markdown(tables: Sequence[tuple[str, list[LeagueRow]]]) -> str:
    lines: list[str] = []
    for title, rows in tables:
        lines += [f"### {title}", "", f"| {' | '.join(COLUMNS)} |", f"|{'---|' * len(COLUMNS)}"]
        lines += [f"| {' | '.join(cell.replace('|', '¦') for cell in row.cells())} |" for row in rows]
        lines.append("")
    return "\n".join(lines)


CITE: Final = (
    "Duet {version}, league of laws, edition {edition}, `lwr-duet league`. Law: T. Petrič and L. Žlajpah, Smooth transition between tasks "
    "on a kinematic control level: Application to self collision avoidance for two Kuka LWR robots, Proc. IEEE Int. Conf. on Robotics and "
    "Biomimetics (ROBIO), 2011."
)

_STYLE: Final = Path(__file__).with_name("league.css")


def league_page(
    entrants: Sequence[Entrant],
    outcomes: Sequence[Played],
    tables: Sequence[tuple[str, list[LeagueRow]]],
    schedule: Schedule,
    versions: Mapping[str, str],
) -> str:
    pictures = [(title, Markup(_picture(entrants, outcomes, level))) for level, title in LEVELS.items()]
    return page_of_template(
        "features/league/league.html",
        language="en",
        title=f"League of laws, edition {EDITION}",
        locked=LOCKED,
        sheet=Markup(css_variables() + _STYLE.read_text(encoding="utf-8")),
        schedule=schedule,
        persons=len(schedule.persons()),
        scenes=[EXPERIMENTS[scene].short for scene in SCENES],
        columns=COLUMNS,
        tables=[(title, [(row.cells(), _kind(row.entrant)) for row in rows]) for title, rows in tables],
        pictures=pictures,
        files=[entrant for entrant in entrants if entrant.text is not None],
        versions=versions,
        cite=CITE.format(version=versions["Duet"], edition=EDITION).replace("`", ""),
    )


def _kind(entrant: Entrant) -> str:
    """CSS class; the projector hides "other"."""
    return "own" if entrant.text is not None else "paper" if entrant.name == DEFAULT_LAW else "other"


def _picture(entrants: Sequence[Entrant], outcomes: Sequence[Played], level: Level) -> str:
    """SVG of error over smallest distance, or at equal safety over the largest step of q̇; means of the
    persons.
    """
    name, scale, label = (
        ("d_min", 1e3, "smallest $d$ [mm]")
        if level == "default"
        else ("dq_step", 1.0, r"step of $\dot q$ [rad/s]")
    )
    known = {(one.name, one.event): one.outcome.runs for one in outcomes}
    with matplotlib.rc_context(STYLE):
        figure = sheet(2.9 * len(ROBOTS) + 0.32 * (len(entrants) // 3 + 1), 3.1 * len(SCENES))
        panels = figure.subplots(len(ROBOTS), len(SCENES), squeeze=False, sharex="col", sharey="col")
        for row, robot in enumerate(ROBOTS):
            for column, scene in enumerate(SCENES):
                axes = panels[row, column]
                if level == "default":
                    axes.axvline(scale * CRITICAL_DISTANCE, color=COLOURS.critical, linewidth=1.2)
                else:
                    axes.set_xscale("log")
                for place, entrant in enumerate(entrants):
                    if runs := known.get((entrant.name, Event(scene, robot, level))):
                        x, e2 = (
                            float(np.mean([getattr(run, of) for run in runs])) for of in (name, "e2_max")
                        )
                        axes.plot([scale * x], [e2], linestyle="none", **_look(place))
                axes.set_title(f"{EXPERIMENTS[scene].short}, {robot}")
                if row == len(ROBOTS) - 1:
                    axes.set_xlabel(f"{label}, mean")
                axes.set_ylabel(f"largest $e^2$ [{EXPERIMENTS[scene].error_unit}], mean")
        labels = [
            Line2D([], [], linestyle="none", label=entrant.label.replace("$", r"\$"), **_look(place))
            for place, entrant in enumerate(entrants)
        ]
        figure.legend(handles=labels, loc="outside lower center", ncols=3, fontsize=8.5)
        return _svg(figure)


def _look(place: int) -> dict[str, Any]:
    colour, marker = SERIES[place % len(SERIES)], MARKERS[(place + place // len(SERIES)) % len(MARKERS)]
    return {
        "color": colour,
        "marker": marker,
        "markersize": 10.0 if place == 0 else 7.0,
        "markeredgecolor": "white",
    }


def _svg(figure: Figure) -> str:
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": "lwr-duet"})
    text = out.getvalue()
    # Comments contain unescaped names.
    return re.sub(r"<!--.*?-->\n?", "", text[text.index("<svg") :], flags=re.DOTALL)
