"""`lwr-duet sweep`: its output, its continuation after an interruption, and its refusals."""

import csv
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.__main__ import run_command as main
from app.cli.options import RunOptions
from app.features.sweep.command import INTERRUPTED, Sweep, sweep
from app.features.sweep.heatmaps import MOST_PANELS
from app.features.sweep.sweep_files import SweepFiles
from controllers.errors import BadInputFile, BadSetting
from scenes import sweep as scene_sweep
from scenes.children import ComputeMany
from scenes.headless import run
from scenes.settings import LATER, RunSettings, changed, specs
from scenes.sweep import FIGURES, Grid, SweepFigures, read_grid
from tests.app.features.said import lines_of
from tests.approved import Approve

pytestmark = pytest.mark.slow

USUAL = RunSettings()
SMALL = Sweep(over=("n=2,8", "pairs=single,soft"), seconds=0.2, workers=1, maps=False)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Complete table of `SMALL`."""
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


def test_a_curve_is_one_cell_and_repeating_the_command_runs_nothing(
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
    """Raise Ctrl+C after some rows. Returns the list of computed points."""
    real, seen = scene_sweep.run_points, []

    def some(grid: Grid, todo: list[int], compute: ComputeMany[SweepFigures]):
        # In reverse order, to check that the table has its own order.
        for index, figures in real(grid, todo[::-1]):
            if len(seen) == after:
                raise KeyboardInterrupt
            seen.append(index)
            yield index, figures

    monkeypatch.setattr(scene_sweep, "run_points", some)
    return seen


@pytest.mark.parametrize("torn", ["", "8.0,single,0.1", "8.0,single,0.1,0.2,0.3,0.4,0.5,0.6,7,0"])
def test_a_restarted_sweep_continues_and_writes_the_same_file(
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
    # A row that was being written during a power failure: no line break yet.
    with part.open("a", encoding="utf-8") as file:
        file.write(torn)
    with monkeypatch.context() as patch:
        seen = interrupted(patch, 99)
        assert sweep(replace(SMALL, out=folder)) == 0
    assert seen == [1, 0]
    assert [path.name for path in folder.iterdir()] == ["sweep.csv"]
    assert (folder / "sweep.csv").read_bytes() == whole
    # Complete points are not run again.
    seen = interrupted(monkeypatch, 0)
    assert sweep(replace(SMALL, out=folder)) == 0 and seen == []


OTHERS: dict[str, dict[str, Any]] = {
    "another gain": {"settings": RunOptions(k="3")},
    "another length": {"seconds": 0.3},
    "another value": {"over": ("n=2,8,9", "pairs=single,soft")},
    "a setting less": {"over": ("n=2,8",)},
    "another order": {"over": ("pairs=single,soft", "n=2,8")},
}


def test_rows_of_another_sweep_are_not_mixed_in(whole: bytes, tmp_path: Path, approve: Approve) -> None:
    said = dict[str, str]()
    for name in ("sweep.csv", "sweep.part.csv"):
        path = tmp_path / name
        path.write_bytes(whole)
        for case, other in OTHERS.items():
            with pytest.raises(BadSetting) as error:
                sweep(replace(SMALL, out=tmp_path, **other))
            said[f"{case}, {name}"] = str(error.value).replace(str(tmp_path), "FOLDER")
            assert path.read_bytes() == whole
        path.unlink()
    approve("refusals beside another sweep.txt", lines_of(said))


SPOILT: dict[str, Callable[[str], str]] = {
    "a letter": lambda text: re.sub("soft,(.*)$", r"soft,x\1", text),
    "a cell more": lambda text: text + ",1",
    "a row more": lambda text: text + "\n9.0,soft" + text.rpartition("soft")[2],
}


def test_a_damaged_file_is_named(whole: bytes, tmp_path: Path, approve: Approve) -> None:
    said = dict[str, str]()
    for case, spoil in SPOILT.items():
        (tmp_path / "sweep.csv").write_text(spoil(whole.decode().rstrip()) + "\n", encoding="utf-8")
        with pytest.raises(BadInputFile) as error:
            sweep(replace(SMALL, out=tmp_path))
        said[case] = str(error.value).replace(str(tmp_path), "FOLDER")
    # The last digits of a row's figures may differ by machine.
    approve("refusals of a spoilt table.txt", re.sub(r"(soft,x?).*?'", r"\1…'", lines_of(said)))


def test_foreign_files_and_unwritable_places_are_refused(tmp_path: Path) -> None:
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


WRONG: dict[str, dict[str, Any]] = {
    "nothing to sweep": {"over": ()},
    "n = 0": {"over": ("n=0:3",)},
    "workers": {"workers": -1},
    "seconds": {"seconds": -1.0},
    "d_m": {"settings": RunOptions(dm="9")},
}


def test_invalid_options_are_refused_before_a_folder_is_made(tmp_path: Path, approve: Approve) -> None:
    said = dict[str, str]()
    for case, wrong in WRONG.items():
        with pytest.raises(BadSetting) as error:
            sweep(replace(SMALL, out=tmp_path / "out", **wrong))
        said[case] = str(error.value)
    assert not (tmp_path / "out").exists()
    approve("refusals.txt", lines_of(said))


def test_a_missing_pyarrow_is_named_before_anything_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, approve: Approve
) -> None:
    for name in ("pyarrow", "pyarrow.parquet"):
        monkeypatch.setitem(sys.modules, name, None)
    seen = interrupted(monkeypatch, 0)
    with pytest.raises(BadSetting) as refusal:
        sweep(replace(SMALL, out=tmp_path, format="parquet"))
    assert seen == []
    approve("refusal without pyarrow.txt", f"{refusal.value}\n")


def test_parquet_has_the_same_content_as_csv(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
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


def test_too_many_panels_are_not_drawn_but_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    over = ("n=2,8", "v=0.1,0.2", f"seed=1:{MOST_PANELS + 1}")
    assert sweep(Sweep(over=over, seconds=0.005, workers=1, out=tmp_path)) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.csv"]
    assert "No maps" in capsys.readouterr().err
