"""Heat maps of a sweep: axes, units, the line of d_m, and a note where the line is missing."""

import math
from pathlib import Path

import numpy as np
import pytest

from app.features.sweep import heatmaps
from app.features.sweep.heatmaps import HeatmapPlan, draw_maps, heatmap_figure
from scenes.settings import RunSettings, changed
from scenes.sweep import FIGURES, Grid, SweepFigures, read_grid
from tests.approved import Approve

pytestmark = pytest.mark.slow

USUAL = RunSettings()


def made_up(over: list[str], d_min, settings: RunSettings = USUAL) -> tuple[Grid, dict[int, SweepFigures]]:
    """A grid with invented figures: d_min is a function of the point, all others are 1, 2, 3 …"""
    grid = read_grid(settings, over, 1.0)
    rows = {}
    for index, point in enumerate(grid.points()):
        others = dict.fromkeys(FIGURES, float(index + 1)) | {"d_min": d_min(point), "pair_switches": index}
        rows[index] = tuple(others.values())
    return grid, rows


def texts(figure) -> set[str]:
    from matplotlib.text import Text

    return {text.get_text() for text in figure.findobj(Text) if text.get_text()}


def contours(ax) -> list:
    from matplotlib.contour import ContourSet

    return [child for child in ax.get_children() if isinstance(child, ContourSet)]


def test_maps_are_pictures_and_the_same_each_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from PIL import Image

    over = ["n=1:3", "law=smooth_priority,unprotected", "v=0.1:0.3:2"]
    grid, rows = made_up(over, lambda point: 0.1 + 0.02 * point[0])
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    second.mkdir()
    drawn = draw_maps(grid, rows, first)
    assert [path.name for path in drawn] == [
        f"{n}.{form}" for n in ("d_min", "e2_max", "ddq_max") for form in ("png", "svg")
    ]
    with monkeypatch.context() as patch:
        # One of the three is enough for the second time.
        patch.setattr(heatmaps, "SHOWN", {"d_min": heatmaps.SHOWN["d_min"]})
        for again in draw_maps(grid, rows, second):
            assert again.read_bytes() == (first / again.name).read_bytes()
    assert len(list(second.iterdir())) == 2
    for png, svg in zip(drawn[::2], drawn[1::2], strict=True):
        with Image.open(png) as image:
            assert (
                image.width > 600
                and image.height > 400
                and len(np.unique(np.asarray(image.convert("L")))) > 20
            )
        assert svg.read_text(encoding="utf-8").count("<svg") == 1


def test_a_heat_map_describes_its_content_and_the_place_of_d_m() -> None:
    over = ["v=0.1:0.5:5", "n=2:6"]
    grid, rows = made_up(
        over, lambda point: 0.10 + 0.1 * point[0] + 0.005 * point[1], changed(USUAL, "k", 3.0)
    )
    plan = HeatmapPlan(grid, rows)
    for name, unit in (("d_min", "[mm]"), ("e2_max", "[m²]"), ("ddq_max", "[rad/s²]")):
        figure = heatmap_figure(plan, name)
        ax, bar = figure.axes
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("$v$ [m/s]", "$n$") and unit in bar.get_ylabel()
        assert any("k = 3.0" in text and "1 s" in text and "scene = hold" in text for text in texts(figure))
        (line,) = contours(ax)
        # On the line, 0.10 + 0.1 v + 0.005 n = d_m.
        vertices = np.concatenate([path.vertices for path in line.get_paths()])
        assert len(vertices) > 3 and np.allclose(0.10 + 0.1 * vertices[:, 0] + 0.005 * vertices[:, 1], 0.15)
    # Each cell is centred at its values; n increases upwards.
    mesh = heatmap_figure(plan, "d_min").axes[0].collections[0]
    field = np.asarray(mesh.get_array()).reshape(5, 5)
    assert np.allclose(
        field, [[1000 * (0.10 + 0.1 * v + 0.005 * n) for v in (0.1, 0.2, 0.3, 0.4, 0.5)] for n in range(2, 7)]
    )


@pytest.mark.parametrize(("level", "sign"), [(0.2, "≥"), (0.1, "<")])
def test_a_missing_line_of_d_m_is_explained(level: float, sign: str) -> None:
    grid, rows = made_up(["v=0.1:0.5:5", "n=2:6"], lambda point: level + 0.001 * point[1])
    figure = heatmap_figure(HeatmapPlan(grid, rows), "d_min")
    assert not contours(figure.axes[0]) and any(
        sign in text and "everywhere" in text for text in texts(figure)
    )


def test_the_line_follows_a_swept_d_m_and_skips_infinite_values() -> None:
    grid, rows = made_up(
        ["dm=0.05:0.15:5", "n=1:4"],
        lambda point: math.inf if point == (0.05, 1.0) else 0.1 + 0.001 * point[1],
    )
    ax, _ = heatmap_figure(HeatmapPlan(grid, rows), "d_min").axes
    assert ax.get_xlabel() == "$d_\\mathrm{m}$ [mm]"
    vertices = np.concatenate([path.vertices for path in contours(ax)[0].get_paths()])
    assert len(vertices) > 2 and np.allclose(vertices[:, 0], 100.0 + vertices[:, 1])


def test_choices_are_columns_or_lines(approve: Approve) -> None:
    grid, rows = made_up(
        ["law=smooth_priority,unprotected", "v=0.1:0.5:5", "ff=0,1", "n=2:6"],
        lambda point: 0.1 + 0.01 * point[3],
    )
    figure = heatmap_figure(HeatmapPlan(grid, rows), "d_min")
    *panels, _ = [ax for ax in figure.axes if ax.get_visible()]
    titles = [ax.get_title() for ax in panels]
    approve("titles of panels.txt", "\n".join(titles) + "\n")
    # Only one swept number: a line for each choice, and d_m.
    grid, rows = made_up(
        ["pairs=single,soft", "n=2:6"], lambda point: 0.1 + 0.01 * point[1] + 0.001 * (point[0] == "soft")
    )
    figure = heatmap_figure(HeatmapPlan(grid, rows), "d_min")
    (ax,), (legend,) = figure.axes, figure.legends
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$n$", "$d_\\mathrm{min}$ [mm]")
    single, soft, critical = ax.get_lines()
    assert np.allclose(single.get_ydata(), [120, 130, 140, 150, 160]) and np.allclose(
        soft.get_ydata(), [121, 131, 141, 151, 161]
    )
    assert np.allclose(critical.get_ydata(), 150.0)
    # The lines also differ in more than colour.
    assert single.get_linestyle() != soft.get_linestyle() and single.get_marker() != soft.get_marker()
    assert {text.get_text() for text in legend.get_texts()} == {"single", "soft", "$d_m$"}
    # Without a swept number a choice has dots without a line.
    (ax,) = heatmap_figure(HeatmapPlan(*made_up(["rig=torso,table"], lambda point: 0.1)), "ddq_max").axes
    (dots,) = ax.get_lines()
    assert (
        dots.get_linestyle() == "None"
        and dots.get_marker() != "None"
        and list(dots.get_ydata()) == [1.0, 2.0]
    )
    assert [label.get_text() for label in ax.get_xticklabels()] == ["torso", "table"]


def test_without_obstacles_no_distance_is_drawn() -> None:
    """One arm alone: d = ∞. In scenes that follow joints the error has another unit."""
    for over in (["k=1:3", "g=5:7"], ["k=1:3"]):
        grid, rows = made_up(over, lambda point: math.inf, changed(USUAL, "scene", "solo"))
        for name in ("d_min", "e2_max"):
            figure = heatmap_figure(HeatmapPlan(grid, rows), name)
            assert not any("everywhere" in text for text in texts(figure)) and contours(figure.axes[0]) == []
    grid, rows = made_up(["n=1:3", "scene=hold,master_slave"], lambda point: 0.1)
    assert heatmap_figure(HeatmapPlan(grid, rows), "e2_max").axes[0].get_ylabel().endswith("[m² or rad²]")
