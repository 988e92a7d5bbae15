"""`lwr-duet sweep`: what it writes, its maps, how it goes on after an interruption, and how it says no."""

import csv
import math
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.__main__ import run_command as main
from app.cli.options import RunOptions
from app.features.sweep import heatmaps
from app.features.sweep.command import INTERRUPTED, Sweep, sweep
from app.features.sweep.heatmaps import MOST_PANELS, HeatmapPlan, draw_maps, heatmap_figure
from app.features.sweep.sweep_files import SweepFiles
from controllers.errors import BadInputFile, BadSetting
from scenes import sweep as scene_sweep
from scenes.children import ComputeMany
from scenes.headless import run
from scenes.settings import LATER, RunSettings, changed, specs
from scenes.sweep import FIGURES, Grid, SweepFigures, read_grid

pytestmark = pytest.mark.slow

USUAL = RunSettings()
SMALL = Sweep(over=("n=2,8", "pairs=single,soft"), seconds=0.2, workers=1, maps=False)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The complete table of `SMALL`."""
    out = tmp_path_factory.mktemp("whole")
    assert sweep(replace(SMALL, out=out)) == 0
    return (out / "sweep.csv").read_bytes()


def read(path: Path) -> tuple[list[str], list[str], list[list[str]]]:
    """The # lines, the columns and the rows of a table."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = [line for line in lines if line.startswith("# ")]
    assert lines[: len(head)] == head
    return head, lines[len(head)].split(","), [line.split(",") for line in lines[len(head) + 1 :]]


def test_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "new" / "folder"
    options = [
        "--over",
        "n=2,8",
        "--over",
        "pairs=single,soft",
        "--no-maps",
        "--workers",
        "1",
        "--k",
        "3",
        "--one-sided",
    ]
    assert main(["sweep", *options, "--seconds", "8", "--out", str(folder)]) == 0
    assert capsys.readouterr().out.splitlines() == [str(folder / "sweep.csv")]
    assert [path.name for path in folder.iterdir()] == ["sweep.csv"]
    head, columns, rows = read(folder / "sweep.csv")
    assert columns == ["n", "pairs", *FIGURES]
    assert {
        "# k = 3.0",
        "# one_sided = True",
        "# scene = hold",
        "# seconds = 8.0",
        "# over n = 2.0, 8.0",
    } <= set(head)
    fixed = [line[2:].split(" = ")[0] for line in head if not line.startswith(("# over", "# seconds"))]
    assert fixed == [key for key in specs(RunSettings) if key not in ("n", "pairs", *LATER)]
    assert [row[:2] for row in rows] == [
        ["2.0", "single"],
        ["2.0", "soft"],
        ["8.0", "single"],
        ["8.0", "soft"],
    ]
    for n, pairs, *cells in rows:
        settings = changed(
            changed(changed(changed(USUAL, "k", 3.0), "one_sided", True), "n", n), "pairs", pairs
        )
        summary = run(settings, 8.0).summary
        assert [float(cell) for cell in cells] == [getattr(summary, name) for name in FIGURES]
    assert rows[0][2:] != rows[1][2:] != rows[2][2:]


def test_a_curve_is_one_cell_and_the_same_command_again_makes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    curves = ["0.15:1,0.4:0", "0.1:1,0.3:0"]
    options = [
        "--over",
        f"curve={';'.join(curves)}",
        "--law",
        "drawn_curve",
        "--seconds",
        "0.2",
        "--workers",
        "1",
        "--no-maps",
    ]
    for _ in range(2):
        assert main(["sweep", *options, "--out", str(tmp_path)]) == 0
        text = (tmp_path / "sweep.csv").read_text(encoding="utf-8")
        header, *rows = csv.reader(line for line in text.splitlines() if not line.startswith("# "))
        assert [row[0] for row in rows] == curves and {len(row) for row in rows} == {len(header)}
    assert capsys.readouterr().err == ""


def interrupted(monkeypatch: pytest.MonkeyPatch, after: int) -> list[int]:
    """Let Ctrl+C come after some rows; return the list of points that are run."""
    real, seen = scene_sweep.run_points, []

    def some(grid: Grid, todo: list[int], compute: ComputeMany[SweepFigures]):
        # From the end, to see that the table has an order of its own.
        for index, figures in real(grid, todo[::-1]):
            if len(seen) == after:
                raise KeyboardInterrupt
            seen.append(index)
            yield index, figures

    monkeypatch.setattr(scene_sweep, "run_points", some)
    return seen


@pytest.mark.parametrize("torn", ["", "8.0,single,0.1", "8.0,single,0.1,0.2,0.3,0.4,0.5,0.6,7,0"])
def test_it_goes_on_where_it_was_ended(
    whole: bytes,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    torn: str,
) -> None:
    folder = tmp_path / "parts"
    with monkeypatch.context() as patch:
        assert interrupted(patch, 2) == []
        assert sweep(replace(SMALL, out=folder)) == INTERRUPTED
    assert "2 of 4 runs" in capsys.readouterr().err
    part = folder / "sweep.part.csv"
    assert [path.name for path in folder.iterdir()] == [part.name] and len(read(part)[2]) == 2
    # A row that was being written when the power failed: no line break yet.
    with part.open("a", encoding="utf-8") as file:
        file.write(torn)
    with monkeypatch.context() as patch:
        seen = interrupted(patch, 99)
        assert sweep(replace(SMALL, out=folder)) == 0
    assert seen == [1, 0]
    assert [path.name for path in folder.iterdir()] == ["sweep.csv"]
    assert (folder / "sweep.csv").read_bytes() == whole
    # What is complete is not run again.
    seen = interrupted(monkeypatch, 0)
    assert sweep(replace(SMALL, out=folder)) == 0 and seen == []


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"settings": RunOptions(k="3")}, "k is 2.0 there, 3.0 here"),
        ({"seconds": 0.3}, "seconds is 0.2 there, 0.3 here"),
        ({"over": ("n=2,8,9", "pairs=single,soft")}, "over n is 2.0, 8.0 there"),
        ({"over": ("n=2,8",)}, "pairs is not given there, smooth here"),
        ({"over": ("pairs=single,soft", "n=2,8")}, "the order of the settings"),
    ],
)
def test_rows_of_another_sweep_are_not_mixed_in(
    whole: bytes, tmp_path: Path, other: dict[str, Any], named: str
) -> None:
    for name in ("sweep.csv", "sweep.part.csv"):
        path = tmp_path / name
        path.write_bytes(whole)
        with pytest.raises(BadSetting) as error:
            sweep(replace(SMALL, out=tmp_path, **other))
        assert all(text in str(error.value) for text in (name, "another --out", named)), error.value
        assert path.read_bytes() == whole
        path.unlink()


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (lambda text: re.sub("soft,(.*)$", r"soft,x\1", text), "soft,x"),
        (lambda text: text + ",1", "8.0,soft"),
        (lambda text: text + "\n9.0,soft" + text.rpartition("soft")[2], "9.0,soft"),
    ],
)
def test_a_spoilt_file_is_named(
    whole: bytes, tmp_path: Path, spoil: Callable[[str], str], named: str
) -> None:
    (tmp_path / "sweep.csv").write_text(spoil(whole.decode().rstrip()) + "\n", encoding="utf-8")
    with pytest.raises(BadInputFile) as error:
        sweep(replace(SMALL, out=tmp_path))
    assert all(text in str(error.value) for text in ("sweep.csv", named, "not of this sweep")), error.value


def test_foreign_files_and_places_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "sweep.csv").write_bytes(bytes(range(256)))
    (tmp_path / "file").write_text("")
    (tmp_path / "taken" / "sweep.part.csv").mkdir(parents=True)
    for out, error, named in (
        ("", BadInputFile, r"sweep\.csv"),
        ("file", BadSetting, "cannot be written"),
        ("taken", BadInputFile, "cannot be read"),
    ):
        with pytest.raises(error, match=named):
            sweep(replace(SMALL, out=tmp_path / out))


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"over": ()}, "--over"),
        ({"over": ("n=0:3",)}, "1 to 20"),
        ({"workers": -1}, "workers = -1"),
        ({"seconds": -1.0}, "seconds = -1"),
        ({"settings": RunOptions(dm="9")}, "dm = "),
    ],
)
def test_what_is_wrong_is_said_before_a_folder_is_made(
    tmp_path: Path, wrong: dict[str, Any], named: str
) -> None:
    with pytest.raises(BadSetting, match=named):
        sweep(replace(SMALL, out=tmp_path / "out", **wrong))
    assert not (tmp_path / "out").exists()


def test_a_missing_pyarrow_is_named_before_anything_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("pyarrow", "pyarrow.parquet"):
        monkeypatch.setitem(sys.modules, name, None)
    seen = interrupted(monkeypatch, 0)
    with pytest.raises(BadSetting, match="pip install pyarrow, or take --format csv"):
        sweep(replace(SMALL, out=tmp_path, format="parquet"))
    assert seen == []


def test_parquet_says_the_same_as_csv(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    base = replace(SMALL, over=("n=2,8", "pairs=single,soft", "ff=0,1"))
    assert sweep(replace(base, out=tmp_path / "csv")) == 0
    base = replace(base, format="parquet")
    with monkeypatch.context() as patch:
        interrupted(patch, 3)
        assert sweep(replace(base, out=tmp_path)) == INTERRUPTED
    assert sweep(replace(base, out=tmp_path)) == 0
    head, columns, rows = read(tmp_path / "csv" / "sweep.csv")
    table = parquet.read_table(tmp_path / "sweep.parquet")
    assert table.column_names == columns
    assert [f"# {line}" for line in table.schema.metadata[b"sweep"].decode().splitlines()] == head
    found = [
        [value if isinstance(value, str) else repr(value) for value in row.values()]
        for row in table.to_pylist()
    ]
    assert found == rows
    assert [str(kind) for kind in table.schema.types][:4] == ["double", "string", "bool", "double"]
    # Complete: nothing runs again.
    seen = interrupted(monkeypatch, 0)
    assert sweep(replace(base, out=tmp_path)) == 0 and seen == []


class InterruptedOnce(dict[int, SweepFigures]):
    def __setitem__(self, index: int, figures: SweepFigures) -> None:
        raise KeyboardInterrupt


def test_ctrl_c_between_a_line_and_its_count(tmp_path: Path) -> None:
    grid = read_grid(RunSettings(), SMALL.over, SMALL.seconds)
    files = SweepFiles(tmp_path, grid, "csv")
    figures = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 7, 0.8)
    with pytest.raises(KeyboardInterrupt), files.recording() as add:
        add(1, figures)
        files.rows = InterruptedOnce(files.rows)
        add(2, figures)
    assert files.rows == {1: figures, 2: figures} and files.missing() == [0, 3]


def made_up(over: list[str], d_min, settings: RunSettings = USUAL) -> tuple[Grid, dict[int, SweepFigures]]:
    """A grid and figures that were not run: d_min is a function of the point, all others are 1, 2, 3 …"""
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


def test_heat_map_says_what_it_shows_and_where_d_m_is() -> None:
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
    # Each cell lies about its values, n up the picture.
    mesh = heatmap_figure(plan, "d_min").axes[0].collections[0]
    field = np.asarray(mesh.get_array()).reshape(5, 5)
    assert np.allclose(
        field, [[1000 * (0.10 + 0.1 * v + 0.005 * n) for v in (0.1, 0.2, 0.3, 0.4, 0.5)] for n in range(2, 7)]
    )


@pytest.mark.parametrize(("level", "sign"), [(0.2, "≥"), (0.1, "<")])
def test_where_the_line_is_not_it_is_said(level: float, sign: str) -> None:
    grid, rows = made_up(["v=0.1:0.5:5", "n=2:6"], lambda point: level + 0.001 * point[1])
    figure = heatmap_figure(HeatmapPlan(grid, rows), "d_min")
    assert not contours(figure.axes[0]) and any(
        sign in text and "everywhere" in text for text in texts(figure)
    )


def test_the_line_follows_a_d_m_that_is_swept_and_skips_what_is_infinite() -> None:
    grid, rows = made_up(
        ["dm=0.05:0.15:5", "n=1:4"],
        lambda point: math.inf if point == (0.05, 1.0) else 0.1 + 0.001 * point[1],
    )
    ax, _ = heatmap_figure(HeatmapPlan(grid, rows), "d_min").axes
    assert ax.get_xlabel() == "$d_\\mathrm{m}$ [mm]"
    vertices = np.concatenate([path.vertices for path in contours(ax)[0].get_paths()])
    assert len(vertices) > 2 and np.allclose(vertices[:, 0], 100.0 + vertices[:, 1])


def test_choices_stand_side_by_side_or_are_lines() -> None:
    grid, rows = made_up(
        ["law=smooth_priority,unprotected", "v=0.1:0.5:5", "ff=0,1", "n=2:6"],
        lambda point: 0.1 + 0.01 * point[3],
    )
    figure = heatmap_figure(HeatmapPlan(grid, rows), "d_min")
    *panels, _ = [ax for ax in figure.axes if ax.get_visible()]
    titles = [ax.get_title() for ax in panels]
    assert len(titles) == 4 and titles[0] == "law = smooth priority, add w to v = off"
    assert titles[3] == "law = unprotected, add w to v = on"
    # One number only: a line for each choice, and d_m.
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
    # They differ by more than their colour.
    assert single.get_linestyle() != soft.get_linestyle() and single.get_marker() != soft.get_marker()
    assert {text.get_text() for text in legend.get_texts()} == {"single", "soft", "$d_m$"}
    # A choice alone has dots without a line.
    (ax,) = heatmap_figure(HeatmapPlan(*made_up(["rig=torso,table"], lambda point: 0.1)), "ddq_max").axes
    (dots,) = ax.get_lines()
    assert (
        dots.get_linestyle() == "None"
        and dots.get_marker() != "None"
        and list(dots.get_ydata()) == [1.0, 2.0]
    )
    assert [label.get_text() for label in ax.get_xticklabels()] == ["torso", "table"]


def test_where_nothing_can_be_met_there_is_no_distance_to_draw() -> None:
    """One arm alone: d = ∞; its error has a unit of its own in scenes that follow joints."""
    for over in (["k=1:3", "g=5:7"], ["k=1:3"]):
        grid, rows = made_up(over, lambda point: math.inf, changed(USUAL, "scene", "solo"))
        for name in ("d_min", "e2_max"):
            figure = heatmap_figure(HeatmapPlan(grid, rows), name)
            assert not any("everywhere" in text for text in texts(figure)) and contours(figure.axes[0]) == []
    grid, rows = made_up(["n=1:3", "scene=hold,master_slave"], lambda point: 0.1)
    assert heatmap_figure(HeatmapPlan(grid, rows), "e2_max").axes[0].get_ylabel().endswith("[m² or rad²]")


def test_too_many_panels_are_not_drawn_but_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    over = ("n=2,8", "v=0.1,0.2", f"seed=1:{MOST_PANELS + 1}")
    assert sweep(Sweep(over=over, seconds=0.005, workers=1, out=tmp_path)) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.csv"]
    assert "No maps" in capsys.readouterr().err
