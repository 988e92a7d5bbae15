"""The league as one page that opens from a file: tables, pictures, and what they depend on."""

import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from app.export.report_html import LOCKED
from app.figures.figure_style import COLOURS, MARKERS, SERIES, STYLE, sheet
from app.league.entrants import Entrant
from app.league.league_files import Played
from app.league.league_table import COLUMNS, LeagueRow
from app.text.templates import page_of_template
from app.theme import css_variables
from scenes.experiments import EXPERIMENTS
from scenes.laws import DEFAULT_LAW
from scenes.league_runs import CRITICAL_DISTANCE, EDITION, LEVELS, ROBOTS, SCENES, Event, Level, Schedule

CITE: Final = (
    "Duet {version}, league of laws, edition {edition}, `lwr-duet league`. Law: T. Petrič and L. Žlajpah, Smooth transition between tasks "
    "on a kinematic control level: Application to self collision avoidance for two Kuka LWR robots, Proc. IEEE Int. Conf. on Robotics and "
    "Biomimetics (ROBIO), 2011."
)
"""How to cite."""

_STYLE: Final = Path(__file__).with_name("league.css")


def league_page(
    entrants: Sequence[Entrant],
    outcomes: Sequence[Played],
    tables: Sequence[tuple[str, list[LeagueRow]]],
    schedule: Schedule,
    versions: Mapping[str, str],
) -> str:
    """Return the page."""
    pictures = [(title, Markup(_picture(entrants, outcomes, level))) for level, title in LEVELS.items()]
    return page_of_template(
        "league/league.html",
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
    """Return the class of an entrant's rows: on the projector, a class sees its own laws and the paper's."""
    return "own" if entrant.text is not None else "paper" if entrant.name == DEFAULT_LAW else "other"


def _picture(entrants: Sequence[Entrant], outcomes: Sequence[Played], level: Level) -> str:
    """Return error over smallest distance, or at equal safety over the largest step of q̇, means of the persons, as SVG: a column a scene,
    a row a kind of robots, a mark an entrant."""
    name, scale, label = (
        ("d_min", 1e3, "smallest $d$ [mm]") if level == "default" else ("dq_step", 1.0, r"step of $\dot q$ [rad/s]")
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
                        x, e2 = (float(np.mean([getattr(run, of) for run in runs])) for of in (name, "e2_max"))
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
    """Return colour and marker of an entrant; the first one is the paper's law, and larger."""
    colour, marker = SERIES[place % len(SERIES)], MARKERS[(place + place // len(SERIES)) % len(MARKERS)]
    return {"color": colour, "marker": marker, "markersize": 10.0 if place == 0 else 7.0, "markeredgecolor": "white"}


def _svg(figure: Figure) -> str:
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": "lwr-duet"})
    text = out.getvalue()
    # Names stand in them, as they are.
    return re.sub(r"<!--.*?-->\n?", "", text[text.index("<svg") :], flags=re.DOTALL)
