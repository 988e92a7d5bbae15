"""Laws at equal safety, the loss between two pairs, and the drawings of laws and imitation."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from app.features.figures import equal_safety, fig8_film
from app.features.figures.drawn_figure import Plan
from app.features.figures.fig6_fig7_followers import imitation, imitation_run
from app.features.studies.law_knobs import knobs
from scenes.headless import run
from scenes.laws import LAWS
from scenes.settings import RunSettings
from tests.app.features.figures.conftest import KNOBS, Numbers
from tests.approved import Approve
from tests.scenes.helpers import with_values

pytestmark = pytest.mark.thorough

PLAN = Plan(quick=True)


def price(knob_number: int, *e2: float, growth: float = 0.0) -> equal_safety.Price:
    empty = np.zeros((len(e2), 1))
    curve = equal_safety.KnobCurve(knobs()[knob_number], np.zeros(1), empty, empty, [])
    return equal_safety.Price(curve, 0.1, np.array(e2), 2.0, growth, 10.0)


def test_every_point_equals_its_run(table: Numbers, folder: Path) -> None:
    """One curve per knob, several persons, repeatable points; the report has a table at equal distance."""
    rows = table("equal_safety")
    curves = set(zip(rows.columns["law"], rows.columns["w_added"], rows.columns["knob"], strict=True))
    assert curves == {(knob.law, str(int(knob.setting.feed_forward)), knob.setting.key) for knob in KNOBS}
    assert len(set(rows["seed"])) == 2 and equal_safety.SEEDS >= 5, "the full figure has five"
    at = next(i for i, law in enumerate(rows.columns["law"]) if law == "intermediate_value")
    changes = {"law": "intermediate_value", rows.columns["knob"][at]: rows["value"][at]}
    settings = with_values(RunSettings(dt=0.01, seed=int(rows["seed"][at])), **changes)
    summary = run(settings, float(rows.settings["seconds"])).summary
    assert (summary.d_min, summary.e2_max) == (rows["d_min"][at], rows["e2_max"][at])
    section = (folder / "report.md").read_text(encoding="utf-8").partition("## Laws at equal safety")[2]
    assert "| Smooth priority, over" in section and "needs w" in section


def test_values_at_equal_distance_are_interpolated_per_person() -> None:
    """No extrapolation: a law that does not reach a distance has no error there."""
    knob = knobs()[0]
    d, e2 = np.array([[0.1, 0.2], [0.16, 0.2]]), np.array([[0.0, 0.1], [0.0, 0.1]])
    curve = equal_safety.KnobCurve(knob, np.array([0.1, 0.2]), d, e2, [])
    at = curve.at(0.15)
    assert at[0] == pytest.approx(0.05) and np.isnan(at[1])
    assert curve.value_at(0.165) == pytest.approx(0.15)


def test_laws_are_compared_over_persons_for_whom_all_keep_the_distance() -> None:
    """A law that keeps the distance only for the easy person gains nothing from that."""
    prices = [price(0, 0.1, 0.3, 0.5), price(1, np.nan, 0.2, 0.4), price(2, 0.01, 0.4, np.nan)]
    assert equal_safety.common(prices).tolist() == [False, True, False] and equal_safety.common([]).size == 0
    table, sentence, *_ = equal_safety.findings([p.curve for p in prices], prices, RunSettings())
    means = [float(line.split("|")[3].split("(")[0]) for line in table.splitlines()[2:]]
    assert means == [0.2, 0.3, 0.4] and " 1 " in sentence


@pytest.mark.parametrize("law", ["task_activation", "set_based_task"])
def test_every_law_has_its_authors_knob(law: str) -> None:
    mine = {(knob.setting.key, knob.setting.feed_forward): knob for knob in knobs() if knob.law == law}
    near, far = (
        run(mine["dm", False].at(RunSettings(dt=0.01), d_m), 10.0).summary.d_min for d_m in (0.06, 0.19)
    )
    assert near < 0.15 < far
    moved = mine["dm", False].at(RunSettings(), 0.19).law
    assert moved.critical_distance == 0.19 and (moved.influence_distance == pytest.approx(0.34)) == (
        law == "task_activation"
    )
    # Laws that accept w are also compared with w.
    assert {knob.law for knob in knobs() if knob.setting.feed_forward} == {
        n for n, entry in LAWS.items() if "ff" in entry.reads
    }


def test_every_value_of_every_knob_gives_a_run() -> None:
    for knob in knobs():
        for value in knob.setting.points:
            done = run(knob.at(RunSettings(dt=0.01), value), 0.02)
            assert done.simulation.settings.law.law == knob.law and np.isfinite(done.summary.d_min), (
                knob,
                value,
            )


@pytest.mark.parametrize(("ratio", "words"), [(0.5, "is better"), (1.0, "is as good"), (1.5, "is worse")])
def test_the_report_names_where_a_rival_is_better_and_its_cost(
    ratio: float, words: str, approve: Approve
) -> None:
    fed = next(i for i, knob in enumerate(knobs()) if knob.law == "barrier_qp" and knob.setting.feed_forward)
    said = equal_safety.verdict(price(0, 0.1, np.nan), price(fed, 0.1 * ratio, np.nan, growth=1.0))
    assert words in said and f"{ratio:.2f} times" in said and "of 1 persons" in said
    approve(f"verdict {words}.txt", f"{said}\n")


def test_between_two_pairs_only_the_closest_pair_loses(table: Numbers) -> None:
    rows = table("slide_loss")
    pairs = np.array(rows.columns["pairs"])
    assert rows["lost_mm"][(pairs == "single") & (rows["v"] == 0.05)] > 100.0
    assert rows["lost_mm"][(pairs == "single") & (rows["v"] == 0.3)] < 0.0
    assert (rows["lost_mm"][pairs != "single"] <= 0.0).all()
    assert (rows["out_of_authority_s"] == 0.0).all()


def test_a_wanted_line_is_thin_and_dashed_beside_a_solid_actual_one() -> None:
    figure: Figure = imitation(PLAN).figure
    panels = [axes for axes in figure.axes if "q_" in axes.get_ylabel()]
    assert len(panels) == 8
    for axes in panels:
        desired, actual = axes.lines
        assert desired.get_linestyle() == "--" and desired.get_linewidth() < actual.get_linewidth()
        assert actual.get_linestyle() == "-"


def test_the_frames_of_the_film_differ() -> None:
    """Frames differ more from each other than frames evenly spread over time."""
    run, _ = imitation_run(PLAN)

    def least(rows: list[int]) -> float:
        places = fig8_film.marker_places(run, run.table[rows])
        return float((np.linalg.norm(places[:, None] - places, axis=2) + np.diag([np.inf] * len(rows))).min())

    picked = fig8_film.moments_of(run)
    assert len(set(picked)) == fig8_film.FRAMES and picked == sorted(picked)
    assert least(picked) > 1.5 * least(
        np.linspace(0, len(run.table) - 1, fig8_film.FRAMES).astype(int).tolist()
    )
