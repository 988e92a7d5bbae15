"""Pictures, tables and Python lines of another first task use its symbol and unit."""

from functools import cache

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from app.features.exports.csv_table import csv_bytes
from app.features.exports.plot_pictures import caption, picture_figure
from app.features.exports.python_snippet import run_plot
from app.session.replay import make_film
from app.session.replay_player import Replay
from app.settings import Details
from app.text.first_task_texts import least_name
from scenes.inputs import Recorded
from scenes.quantities import ALL, FIRST_TASKS, SINGULAR, STOPS, WALL
from tests.scenes.helpers import given_settings, recorded_run


@cache
def piece(first: str) -> Recorded:
    return recorded_run(given_settings(scene="first_task", first=first, law="strict_switched"), 1.0, 99.0)[1]


def words(figure: Figure) -> str:
    figure.canvas.draw()
    return "\n".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.parametrize(
    ("first", "over", "rate"),
    [
        (STOPS, "way to the joint stops h [rad]", "J$_a$q̇ [rad/s]"),
        (SINGULAR, "smallest singular value σ [m/rad]", "J$_a$q̇ [m/rad/s]"),
        (WALL, "distance from the wall d [m]", "J$_a$q̇ [m/s]"),
    ],
)
def test_charts_over_the_first_task(first: str, over: str, rate: str) -> None:
    charts: tuple[Details, ...] = ("curve", "laws")
    curve, laws = (words(picture_figure(piece(first), 1.0, chart, ())) for chart in charts)
    assert over in curve and over in laws and rate in laws
    assert ("over the value" in laws) == ("over the value the law" in curve) == (first != WALL)


def test_the_caption_has_threshold_and_speed_in_the_tasks_unit() -> None:
    settings = piece(SINGULAR).settings
    line = caption(settings)
    assert "switched at $σ_m$ · $σ_m$ = 150 mm/rad" in line and "v = 0.3 m/rad/s, K" in line
    assert "$h_m$ = 150 mm, mrad" in caption(piece(ALL).settings)


def test_the_table_names_the_unit() -> None:
    units = csv_bytes(piece(STOPS), 1.0).decode().split("# units = ")[1].splitlines()[0]
    assert "d [rad]" in units and "u [rad/s]" in units and "e2 [m²]" in units


def test_python_lines_label_the_axis() -> None:
    made = run_plot(piece(STOPS).settings, "run", "[0.1]")
    assert 'label="h"' in made and 'ylabel="way to the joint stops [mrad]"' in made


def test_the_nearest_moment_refers_to_a_distance_or_a_value() -> None:
    film = Replay(make_film(piece(STOPS)))
    assert least_name(film.simulation.settings.quantity) == "smallest value"
    assert least_name(FIRST_TASKS[WALL]) == "smallest distance"
