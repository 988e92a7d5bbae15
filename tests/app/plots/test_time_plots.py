"""The time plots: every plot of every experiment has its columns and its colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest

from app.custom_law.custom_law import CustomLaw
from app.plots.plot_choice import CHARTS, cells, layout_html, possible_details
from app.plots.time_plots import colour_of, time_plot_of
from app.plots.time_series import COLUMNS
from app.session.frame import freeze
from app.theme import PALETTES
from scenes.settings import RobotName, RunSettings, SceneName
from scenes.simulation import Simulation
from tests.app.plots.helpers import DETAILS, SCENES, go_on, panel, played, session_of


@pytest.mark.parametrize("scene", SCENES)
def test_every_plot_of_every_experiment_has_columns_and_colours(scene: SceneName) -> None:
    simulation = played(scene)
    for details in DETAILS:
        shown = cells(simulation.settings, details)
        assert len(set(shown)) == len(shown) <= 4
        assert shown[:2] == (("hand", "elbow") if scene == "solo" else ("distance", "error"))
        assert details == "none" or (details in shown) == (details in possible_details(simulation.settings))
        for name in shown:
            if name in CHARTS:
                continue
            plot = time_plot_of(name, simulation)
            assert {line.run for line in plot.lines} <= {"own", "ghost", "what_if"}
            for line in plot.lines:
                assert line.column in COLUMNS
                for palette in PALETTES.values():
                    assert re.fullmatch(r"#[0-9a-f]{6}", colour_of(line, palette))
            # Not two lines of one colour without another cue.
            own = [(line.colour, line.dash) for line in plot.lines if line.run == "own"]
            assert len(set(own)) == len(own)
    unit = time_plot_of("error", simulation).unit
    assert unit == ("rad²" if scene in ("master_slave", "imitation") else "m²")


@pytest.mark.parametrize("name", ["distance", "error", "joints", "rates", "follow"])
def test_a_plot_has_the_same_lines_in_every_experiment(name: str) -> None:
    """The page would make one with other lines anew, in the moment in which its data change too."""
    settings = [RunSettings(scene=scene) for scene in ("hold", "master_slave", "imitation")]
    settings += [RunSettings(scene="imitation", avoid="both"), RunSettings(scene="master_slave", robot=get_args(RobotName)[-1])]
    lines = {tuple(line.column for line in time_plot_of(name, Simulation(s)).lines) for s in settings}
    assert len(lines) == 1


def test_a_law_of_ones_own_has_no_resting_distance(tmp_path: Path) -> None:
    """Neither its line nor its name, from the moment on in which it runs, whatever the settings' law is."""
    path = tmp_path / "my_law.py"
    path.write_text("def law(s):\n    return s.nominal", encoding="utf-8")
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 0.5)
    plots.show(freeze(session, 0.0))
    assert len(gui.plots[0].data[3]) and any("d*" in block.content for block in gui.blocks)
    with CustomLaw(path) as law:
        session.simulation.use(law)
        session.reset()
        go_on(session, 0.5)
        plots.show(freeze(session, 1.0))
    assert not len(gui.plots[0].data[3]) and not any("d*" in block.content for block in gui.blocks)


def test_a_column_for_every_plot() -> None:
    for shown in (("distance", "error"), ("distance", "error", "laws"), ("distance", "error", "follow", "follow_other")):
        wide, narrow = re.findall(r"--duet-\w+:([^;}]*)", layout_html(shown))
        assert wide.count("minmax") == len(shown)
        assert narrow.count("minmax") == (2 if shown[-1] == "laws" else min(len(shown), 3))
