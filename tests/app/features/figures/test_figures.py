"""`lwr-duet figures`: its numbers repeat the paper's claims and our closed forms, the same each time."""

import io
import pickle
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import matplotlib
import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from app.features.figures import laws_compared as laws
from app.features.figures.command import Figures, draw_figures
from app.features.figures.drawn_figure import Plan, write_csv
from app.features.figures.fig2_fig4_law import BLOCKS
from app.features.figures.figure_list import CATALOGUE, FigureEntry, chosen_figures
from controllers import budget
from controllers.activation import activation
from controllers.errors import BadSetting
from scenes.children import computed
from scenes.settings import LawSettings, RunSettings, specs
from tests.app.features.figures.conftest import Numbers, entry, read
from tests.app.features.said import without_numbers
from tests.approved import Approve

pytestmark = pytest.mark.slow

T = TypeVar("T")
CRITICAL = LawSettings().critical_distance
SLACK = 1e-4


def csv_text(figure: FigureEntry, plan: Plan) -> str:
    out = io.StringIO()
    write_csv(out, figure.draw(plan))
    return out.getvalue()


def check_files(figure: FigureEntry, folder: Path) -> None:
    with Image.open(folder / f"{figure.stem}.png") as picture:
        assert picture.width >= 1000 and picture.height >= 500
        assert np.asarray(picture.convert("L")).std() > 10.0
    drawing = (folder / f"{figure.stem}.svg").read_text(encoding="utf-8")
    assert "<svg" in drawing and "<path" in drawing and "dc:date" not in drawing
    if figure.name != "scheme":
        table = read((folder / f"{figure.stem}.csv").read_text(encoding="utf-8"))
        assert table.settings and next(iter(table.columns.values()))


def test_the_files_of_two_figures(tmp_path: Path) -> None:
    assert draw_figures(Figures(only="activation,hold", out=tmp_path, quick=True, workers=1)) == 0
    for name in ("activation", "hold"):
        check_files(entry(name), tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("figure", CATALOGUE, ids=lambda e: e.name)
def test_files(figure: FigureEntry, folder: Path) -> None:
    check_files(figure, folder)


OF_OTHER_TESTS = ("equal_safety", "setup", "film")
"""Figures checked by other tests: one of the many runs, and moments of the runs of two other figures."""


def elsewhere(function: Callable[..., T], calls: Iterable[tuple[Any, ...]]) -> Iterator[tuple[int, T]]:
    """Results as through the processes of `--workers`: pickled both ways, without processes."""
    for found in computed(*pickle.loads(pickle.dumps((function, list(calls))))):
        yield pickle.loads(pickle.dumps(found))


@pytest.mark.thorough
def test_every_csv_is_reproducible_and_another_seed_is_another_person(
    folder: Path,
) -> None:
    plan = Plan(quick=True, compute=elsewhere)
    for figure in (figure for figure in CATALOGUE if figure.name not in OF_OTHER_TESTS):
        assert csv_text(figure, plan) == (folder / f"{figure.stem}.csv").read_text(encoding="utf-8"), (
            figure.name
        )
    hold = entry("hold")
    assert csv_text(hold, Plan(2, quick=True)) != csv_text(hold, plan)


def test_runs_are_shared_and_progress_counts_every_step() -> None:
    made: list[int] = []
    plan = Plan(quick=True, on_progress=made.append)
    settings = plan.settings()
    first = plan.shared(settings, 1.0)
    assert plan.shared(plan.settings(), 1.0) is first
    assert plan.shared(plan.settings(rig="table"), 1.0) is not first
    assert sum(made) == 2 * 200


def test_path(table: Numbers) -> None:
    rows = table("path")
    s = {
        key: float(rows.settings[key])
        for key in ("ball_x", "ball_y", "ball_z", "ball_radius", "point_radius")
    }
    centre, radii = np.array([s["ball_x"], s["ball_y"], s["ball_z"]]), s["ball_radius"] + s["point_radius"]
    actual, desired = (
        np.column_stack([rows[f"{name}_{axis}"] for axis in "xyz"]) for name in ("actual", "desired")
    )
    assert_allclose(np.linalg.norm(actual - centre, axis=1) - radii, rows["d"], atol=1e-9)
    assert rows["d"].min() >= CRITICAL - SLACK
    assert (np.linalg.norm(desired - centre, axis=1) - radii).min() < 0.05
    assert_allclose(np.ptp(desired, axis=0)[[0, 2]], 0.0, atol=1e-12)
    assert np.ptp(actual, axis=0)[2] > 0.05


def test_activation(table: Numbers) -> None:
    rows = table("activation")
    for n in (1, 2, 10):
        assert rows[f"lambda_n{n}"].tolist() == [activation(d, 0.1, n) for d in rows["d"]]
    at = int(np.flatnonzero(rows["d"] == 0.2)[0])
    assert [rows[f"lambda_n{n}"][at] for n in (1, 2, 10)] == pytest.approx([0.5, 0.25, 2.0**-10])


def test_scheme(csv_file: Callable[[str], str]) -> None:
    lines = csv_file("scheme").splitlines()
    assert lines[0] == "from,to,signal,meaning"
    ends = [line.split(",")[:2] for line in lines[1:]]
    for column in (0, 1):
        assert {end[column] for end in ends} >= set(BLOCKS)


def test_hold_and_the_setup_at_the_moment_of_the_smallest_distance(table: Numbers) -> None:
    rows = table("hold")
    assert table("setup")["d"].tolist() == [rows["d"].min()]
    assert rows["d"].min() >= CRITICAL - SLACK and rows["d_soft"].min() >= CRITICAL - SLACK
    assert rows["d"].min() < CRITICAL + 0.05, "the arms never come close"
    assert rows["e2"].max() > 0.01 and rows["e2"][0] == 0.0
    at_rest = np.flatnonzero(~np.isnan(rows["d_rest"]))
    assert len(at_rest) > 100
    law = LawSettings()
    for i in at_rest[:: len(at_rest) // 20].tolist():
        rest = budget.resting_distance(
            CRITICAL, law.order, law.nominal_velocity, float(rows["u"][i]), float(rows["w"][i])
        )
        assert rows["d_rest"][i] == pytest.approx(rest, abs=1e-12)
    assert rows["lambda"].tolist() == [activation(d, CRITICAL, law.order) for d in rows["d"]]


def test_master_slave(table: Numbers) -> None:
    rows = table("master_slave")
    gap = np.max([np.abs(rows[f"slave_q{i}"] - rows[f"master_q{i}"]) for i in range(1, 8)], axis=0)
    assert CRITICAL - SLACK <= rows["d"].min() < CRITICAL + 0.05
    assert gap[rows["lambda"] < 0.02].max() < 0.03 and gap.max() > 0.05
    assert np.ptp(rows["master_q1"]) > 0.2


def test_imitation_and_film(table: Numbers) -> None:
    rows, frames = table("imitation"), table("film")
    assert rows["d"].min() >= CRITICAL - SLACK
    assert rows["d"].min() < CRITICAL + 0.05, "the arms never come close"
    for side in ("left", "right"):
        for i in range(1, 5):
            assert np.abs(rows[f"{side}_qd{i}"] - rows[f"{side}_q{i}"]).max() < 0.5
        assert max(np.ptp(rows[f"{side}_qd{i}"]) for i in range(1, 5)) > 0.5
    # The frames are moments of that run, in order.
    assert len(frames["t"]) == 8 and (np.diff(frames["t"]) > 0.0).all()
    places = np.searchsorted(rows["t"], frames["t"] - 1e-9)
    assert_allclose(frames["right_q2"], rows["right_q2"][places])
    assert_allclose(frames["d"], rows["d"][places])


def test_resting(table: Numbers) -> None:
    rows = table("resting")
    s = {key: float(value) for key, value in rows.settings.items()}
    assert set(rows.columns["over"]) == {"n", "v", "w"}
    for over, value, closed in zip(
        rows.columns["over"], rows["value"], rows["d_rest_closed_form"], strict=True
    ):
        point = {key: s[key] for key in ("n", "v", "w")} | {over: value}
        assert closed == budget.resting_distance(s["dm"], point["n"], point["v"], s["u"], point["w"])
    assert np.abs(rows["d_rest_measured"] - rows["d_rest_closed_form"]).max() < 1e-3


def test_threshold(table: Numbers) -> None:
    rows = table("threshold")
    fed = rows["w_added"] == 1.0
    assert rows["d_min"][~fed & (rows["v_over_w"] >= 1.0)].min() >= CRITICAL - SLACK
    assert rows["d_min"][~fed & (rows["v_over_w"] < 0.8)].max() < CRITICAL - 0.01
    assert rows["d_min"][fed].min() >= CRITICAL - SLACK and rows["w_max"][fed].max() > 0.4


def test_laws(table: Numbers) -> None:
    rows = table("laws")
    names = np.array(rows.columns["law"])
    assert set(names) == set(specs(RunSettings)["law"].choices)
    paper, free = names == "smooth_priority", names == "unprotected"
    assert rows["d_min"][paper].min() >= CRITICAL - SLACK
    assert rows["d_min"][free].max() < 0.0 and rows["e2_max"][free].max() < 1e-12
    by_dt = {
        law: dict(zip(rows["dt"][names == law], rows["dq_step_max"][names == law], strict=True))
        for law in set(names)
    }
    coarse, fine = rows["dt"].max(), rows["dt"].min()
    assert by_dt["smooth_priority"][coarse] / by_dt["smooth_priority"][fine] == pytest.approx(
        coarse / fine, rel=0.25
    )
    assert by_dt["strict_switched"][coarse] / by_dt["strict_switched"][fine] < 1.3


@pytest.mark.thorough
def test_the_report_explains_jumps_of_a_law_with_growing_acceleration(folder: Path, approve: Approve) -> None:
    report = (folder / "report.md").read_text(encoding="utf-8")
    said = [line for line in report.splitlines() if "the largest q̈ is at" in line]
    approve("causes of jumps.txt", without_numbers("\n".join(said)) + "\n")
    assert "damaged text" in report and "axis of e²" in report


def test_null_space_avoidance_jumps_where_the_hands_are_parallel(approve: Approve) -> None:
    """In the full experiment the hand leaves little of J_d, and the closest points slide along both hands."""
    plan = Plan()
    jump = laws.largest_jump(
        plan.run(plan.settings({"law": "null_space_avoidance", "pairs": "soft"}, rig="table", dt=0.005), 37.5)
    )
    assert jump.left < 0.02 and jump.lever > 0.3 and jump.activation == 0.0
    assert jump.pair == ("left hand", "right hand") and jump.slide > 0.05
    approve("cause of a jump.txt", without_numbers(laws.cause("x", jump, True)) + "\n")


def test_growth_is_1_for_doubled_and_0_for_equal_acceleration_at_half_the_dt() -> None:
    summary, steps = Plan(quick=True).run(RunSettings(), 0.1).summary, (0.02, 0.01, 0.005)
    assert laws.growth([replace(summary, ddq_max=3.0 / dt) for dt in steps], steps) == pytest.approx(1.0)
    assert laws.growth([replace(summary, ddq_max=3.0) for _ in steps], steps) == 0.0


def test_switches(table: Numbers) -> None:
    rows = table("switches")
    kinds = np.array(rows.columns["pairs"])
    coarse, fine = rows["dt"].max(), rows["dt"].min()

    def at(pairs: str, dt: float, column: str) -> float:
        return float(rows[column][(kinds == pairs) & (rows["dt"] == dt)][0])

    assert at("single", fine, "pair_switches") > 2.0 * at("single", coarse, "pair_switches")
    assert at("single", fine, "dq_step_max") > 0.7 * at("single", coarse, "dq_step_max")
    assert at("soft", coarse, "dq_step_max") / at("soft", fine, "dq_step_max") == pytest.approx(
        coarse / fine, rel=0.25
    )


def test_bias(table: Numbers) -> None:
    rows = table("bias")
    assert (np.diff(rows["e"]) < 0.0).all() and rows["e"][0] > 5e-3
    assert_allclose(rows["e"], rows["e_closed_form"], rtol=0.05)


def test_stability(table: Numbers) -> None:
    rows = table("stability")
    assert_allclose(rows["survival"], 1.0 - rows["lambda"] * rows["rho"] ** 2, atol=1e-12)
    busy = rows["lambda"] > 0.3
    assert busy.any() and (rows["eigenvalue"][busy] < 0.0).any()
    assert (rows["survival"] > 0.0).all() and (rows["survival"] <= 1.0).all()


def test_only_the_law_keeps_first_tasks_at_the_rate_of_the_closed_form(
    table: Numbers,
) -> None:
    rows = table("first_tasks")
    task, law, exact = np.array(rows.columns["quantity"]), rows["law"] == 1.0, rows["exact"] == 1.0
    assert set(task) == {"joint_stops", "plane", "own_links", "singular_value", "centre_of_mass"}
    for name in set(task):
        own = task == name
        assert rows["h"][own & law].min() >= rows["h_m"][own][0]
        # σ cannot be negative.
        assert rows["h"][own & ~law].min() < (1e-3 if name == "singular_value" else 0.0)
        kept = own & law & exact & (rows["lambda"] > 0.1)
        assert kept.sum() > 10
        for h, h_m, lam in zip(rows["h"][kept], rows["h_m"][kept], rows["lambda"][kept], strict=True):
            assert lam == activation(h, h_m, float(rows.settings["n"]))
    closed = rows["lambda"] * rows["v"] - (1.0 - rows["lambda"]) * rows["u"] - rows["w"]
    assert_allclose(rows["rate_closed_form"], closed, atol=1e-15)
    assert_allclose(rows["rate"][exact], rows["rate_closed_form"][exact], atol=1e-9)
    assert_allclose(rows["w"][task == "plane"], float(rows.settings["wall_speed"]))
    assert not rows["w"][task != "plane"].any()


@pytest.mark.thorough
def test_the_report_has_a_section_per_figure_and_the_numbers_of_the_files(
    folder: Path, table: Numbers
) -> None:
    text = (folder / "report.md").read_text(encoding="utf-8")
    sections = re.split(r"^## ", text, flags=re.MULTILINE)[1:]
    assert [section.splitlines()[0] for section in sections] == [figure.heading for figure in CATALOGUE]
    for figure, section in zip(CATALOGUE, sections, strict=True):
        assert figure.paper in section
        for kind in ("png", "svg", "csv"):
            assert f"({figure.stem}.{kind})" in section and (folder / f"{figure.stem}.{kind}").is_file()
        found = section.split("**What we found.**")[1]
        assert figure.name == "scheme" or re.search(r"\d", found)
        assert "nan" not in found
    assert "Quick" in text and "--seed 1 --quick" in text
    for name, words in (
        ("hold", "its minimum is"),
        ("imitation", "its minimum is"),
        ("path", "the actual one stays"),
    ):
        assert f"{words} {1000 * table(name)['d'].min():.1f} mm" in text
    jumps = table("switches")
    single = [
        f"{x:.3g}"
        for x, kind in zip(jumps["dq_step_max"], jumps.columns["pairs"], strict=True)
        if kind == "single"
    ]
    assert f"largest step of q̇ {', '.join(single)} rad/s" in text


def test_figures_are_chosen_by_number_or_name() -> None:
    for only, found in (
        ("5,2", (2, 5)),
        (" hold, activation ,2", (2, 5)),
        ("", range(1, 9)),
        (" , ", range(1, 9)),
    ):
        assert [figure.number for figure in chosen_figures(only) if figure.number] == list(found)
    assert chosen_figures("") == chosen_figures(" , ") == CATALOGUE
    assert [figure.name for figure in chosen_figures("LAWS")] == ["laws"]


@pytest.mark.parametrize("only", ["9", "0", "two", "2;5", "-1"])
def test_unknown_figures_are_refused(only: str) -> None:
    with pytest.raises(BadSetting) as refusal:
        chosen_figures(f"2,{only}")
    message = str(refusal.value)
    assert repr(only) in message and "\n" not in message
    for figure in CATALOGUE:
        assert figure.name in message and (not figure.number or str(figure.number) in message)


@pytest.mark.thorough
def test_only_the_requested_figures_are_drawn_the_same_each_time(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = dict(matplotlib.rcParams)
    out = tmp_path / "new" / "folder"
    assert draw_figures(Figures(only="2,4", out=out, quick=True)) == 0
    drawings = {
        f"{stem}.{kind}" for stem in ("fig2_activation", "fig4_scheme") for kind in ("csv", "png", "svg")
    }
    assert {path.name for path in out.iterdir()} == {"report.md", *drawings}
    for name in drawings:
        assert (out / name).read_bytes() == (folder / name).read_bytes(), name
    assert str(out / "report.md") in capsys.readouterr().out
    assert dict(matplotlib.rcParams) == before
    assert "λ over the distance" in (out / "report.md").read_text(encoding="utf-8")


def test_invalid_folder_seed_and_number_of_workers_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadSetting, match="another folder"):
        draw_figures(Figures(only="2", out=tmp_path / "file" / "inside"))
    (tmp_path / "out" / "fig2_activation.png").mkdir(parents=True)
    with pytest.raises(BadSetting, match="cannot be written"):
        draw_figures(Figures(only="2", out=tmp_path / "out"))
    for seed in (-1, 10_000):
        with pytest.raises(BadSetting, match="seed"):
            draw_figures(Figures(only="2", out=tmp_path, seed=seed))
    with pytest.raises(BadSetting, match="workers = -1"):
        draw_figures(Figures(only="2", out=tmp_path, workers=-1))
