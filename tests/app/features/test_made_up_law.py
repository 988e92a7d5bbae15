"""A law is declared once: a made-up entry in the register works wherever laws appear."""

import html
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.__main__ import run_command as main
from app.features.custom_law.trials import verdict_on
from app.features.exports.csv_table import csv_bytes
from app.features.exports.player import player_html
from app.features.exports.plot_pictures import picture_bytes
from app.features.figures import equal_safety, laws_compared
from app.features.lessons.attempts import StandIn
from app.features.studies.background_studies import SafetyPoint
from app.features.studies.law_knobs import knobs, match_knob
from app.features.studies.trade_off_charts import safety_html
from app.page.page_assets import style_sheet
from app.page.panels import contact_card
from app.page.panels.readout import status_html
from app.plots.law_charts import all_laws, laws_html
from app.plots.pair_strips import pairs_html
from app.plots.stability_text import section_html
from app.plots.time_series import RollingSeries
from app.session.frame import freeze
from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import PageSettings, Settings, from_query, to_query
from app.text.law_texts import LAW_TEXTS, LawTexts, equation_html
from controllers.laws.row_law import RowLaw
from scenes.headless import run
from scenes.laws import LAWS, Knob, LawEntry
from scenes.settings import LawSettings, RunSettings, specs, values
from scenes.simulation import Simulation
from tests.app.cli.test_commands import read
from tests.app.conftest import Arrive, OpenHouse
from tests.app.features.custom_law.helpers import law_of
from tests.app.page.helpers import page_label
from tests.scenes.helpers import moved, recorded_run
from tests.test_imports import ROOT

NAME, LABEL, SHORT = "made_up", "Made up, for a test", "Made up"
SAID = "as made up as its name"


@dataclass(frozen=True)
class MadeUp(RowLaw):
    """λ rises below 2 d_m; a larger k_r makes it rise faster."""

    critical_distance: float
    nominal_velocity: float
    restoring_gain: float

    def activation(self, distance: float) -> float:
        return min(1.0, max(0.0, 2.0 - distance / self.critical_distance) * self.restoring_gain / 5.0)

    def correction(self, distance: float, pull: float, approach: float) -> float:
        del approach
        return self.activation(distance) * (self.nominal_velocity + pull)


ENTRY = LawEntry(
    NAME,
    LABEL,
    SHORT,
    f"{NAME}:MadeUp",
    ("dm", "v", "kr"),
    "share",
    knobs=(Knob("kr", (1.0, 5.0)),),
    in_null_space=True,
)
TEXTS = LawTexts(
    (r"\dot q = {lam}\,\dot q_n",),
    "Example 2026",
    "μ",
    lambda law, line: 0.5 * law.critical_distance,
    SAID,
    missed="it is made up",
)


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The made-up law in the register during a test; the product is otherwise unchanged."""
    monkeypatch.setitem(sys.modules, f"controllers.laws.{NAME}", sys.modules[__name__])
    monkeypatch.setitem(LAWS, NAME, ENTRY)
    monkeypatch.setitem(LAW_TEXTS, NAME, TEXTS)
    all_laws.cache_clear()
    style_sheet.cache_clear()
    yield
    all_laws.cache_clear()
    style_sheet.cache_clear()


def of(**others: Any) -> RunSettings:
    return RunSettings(law=LawSettings(law=NAME, **others))


def near(law: LawSettings | None = None) -> Simulation:
    """A simulation run until λ > 0.05, with the scripted person."""
    settings = RunSettings(law=law or LawSettings(law=NAME, critical_distance=0.3))
    return moved(
        settings, lambda simulation: simulation.sample().activation > 0.05 and simulation.time >= 1.0
    )


def text(page: str) -> str:
    return html.unescape(re.sub(r"<[^>]+>", " ", str(page)))


def test_the_command_line_runs_it_and_writes_its_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        main(["run", "--law", NAME, "--kr", "3", "--seconds", "0.5", "--csv", str(tmp_path / "run.csv")]) == 0
    )
    about, _, rows = read(tmp_path / "run.csv")
    assert about["law"] == NAME
    twin = run(of(restoring_gain=3.0), 0.5)
    assert [float(row["d"]) for row in rows] == pytest.approx(twin.table[:, 1].tolist(), abs=1e-9)
    assert main(["run", "--law", "made_upp"]) == 2
    assert f"{NAME}." in capsys.readouterr().err


def test_the_help_names_the_law_and_a_made_up_experiment() -> None:
    code = (
        "from scenes.experiments import EXPERIMENTS; from scenes.laws import LAWS; from dataclasses import replace\n"
        f"LAWS['{NAME}'] = replace(LAWS['unprotected'], name='{NAME}')\n"
        f"EXPERIMENTS['{NAME}'] = replace(EXPERIMENTS['ball'], name='{NAME}')\n"
        "from app.__main__ import run_command; run_command(['run', '--help'])"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=ROOT, timeout=120
    )
    choices = re.sub(r"[\s│]", "", said.stdout)
    assert f"unprotected,{NAME}}}" in choices and f"first_task,{NAME}}}" in choices


def test_a_link_opens_it_with_its_settings_and_its_ghost() -> None:
    settings, problems = from_query({"law": NAME, "ghost": NAME, "kr": "7"}, Settings())
    assert (
        not problems
        and settings.run.law == LawSettings(law=NAME, restoring_gain=7.0)
        and settings.page.ghost == NAME
    )
    assert from_query(to_query(settings), Settings())[0] == settings
    assert to_query(settings)["law"] == NAME


def test_only_the_settings_that_the_law_reads_matter() -> None:
    shown = {key for key in specs(LawSettings) if matters(key, Settings(of()))}
    assert shown == {"law", "dm", "v", "kr", "pairs", "eps", "beta"}


def test_the_page_shows_its_sliders_in_the_tab_of_the_law(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), f"law={NAME}&ghost={NAME}")
    of_page = lambda key: one.visitor.mirror.labelled(page_label(key))  # noqa: E731
    one.visitor.wait_for(lambda _: all(of_page(key)["visible"] for key in ("dm", "v", "kr", "pairs")))
    one.visitor.wait_for(
        lambda _: not any(of_page(key)["visible"] for key in ("n", "d0", "eta", "gamma", "ff", "one_sided"))
    )
    law, ghost = of_page("law"), of_page("ghost")
    assert law["value"] == LABEL == law["options"][-1] and ghost["value"] == SHORT == ghost["options"][-2]
    assert {of_page(key)["container_uuid"] for key in ("dm", "v", "kr")} == {law["container_uuid"]}
    one.visitor.set_value(page_label("law"), "Barrier QP, all pairs")
    one.wait(lambda s: s.settings.run.law.law == "barrier_qp")
    one.visitor.set_value(page_label("law"), LABEL)
    one.wait(lambda s: isinstance(s.simulation.law, MadeUp))
    assert len({re.sub(r"\W", "", option) for option in ghost["options"]}) == len(LAWS) + 3


def test_the_card_names_its_activation_and_explains_the_gap() -> None:
    simulation = near()
    session = Session(Settings(simulation.settings))
    frame = replace(freeze(session, 0.0), simulation=simulation, sample=simulation.sample())
    terms = contact_card.budget_terms(simulation, frame.sample, frame.contact)
    words = contact_card.contact_words(frame, terms)
    assert words["share"] == "μ" and [
        text(term.symbol).replace(" ", "") for term in terms if term.kind == "u"
    ] == ["(1−μ)u"]
    assert contact_card.contact_note(simulation, frame.sample, frame.contact, []) == ("", SAID)
    assert contact_card.contact_numbers(frame, frame.contact, terms, 0)[2] is None
    assert sum(term.value for term in terms) == pytest.approx(frame.contact.change, abs=0.011)
    assert "Example 2026" in equation_html(simulation.settings)
    assert "avoidance is off" not in status_html(frame.pace, simulation, frame.sample)


def test_the_ghost_runs_it_beside_the_paper_s_law() -> None:
    session = Session(Settings(RunSettings(), PageSettings(ghost=NAME)))
    assert session.ghost is not None and isinstance(session.ghost.law, MadeUp)
    assert session.ghost.law.nominal_velocity == session.settings.run.law.nominal_velocity


def test_the_plots_of_all_laws_have_its_line_number_and_colour() -> None:
    simulation = near()
    now = freeze(Session(Settings(simulation.settings)), 0.0).contact
    chart = laws_html(simulation, near(LawSettings(critical_distance=0.3)), now, 150)
    place = len(LAWS)
    assert f"law{place}" in chart and re.search(rf'digit law{place}"[^>]*>{place}<', chart)
    assert re.search(rf"\.law{place}\{{color:light-dark\(#\w{{6}},#\w{{6}}\)}}", style_sheet("desk"))
    curves = {knob: (SafetyPoint(0.1, 0.01), SafetyPoint(0.2, 0.05)) for knob in knobs()}
    safety = safety_html(curves, 1.0, simulation.settings, 150)
    assert f"<b>{SHORT}</b>: k_r" in safety
    buffer = RollingSeries()
    buffer.feed(simulation)
    assert "smooth minimum over all" in pairs_html(simulation, buffer)
    assert "Of this law it says nothing" in section_html(simulation, simulation.sample(), now)


def test_its_knob_can_be_matched() -> None:
    _, recorded = recorded_run(RunSettings(), 1.0, 99.0, {})
    match = match_knob(
        recorded, {**values(LawSettings()), "k": 2.0}, {**values(LawSettings(law=NAME)), "k": 2.0}
    )
    assert (match.law, match.key) == (NAME, "kr")


def test_the_figures_draw_it() -> None:
    drawn = laws_compared.variants()
    assert drawn[LABEL] == {"law": NAME} and len(drawn) == len(LAWS) + sum(
        law.has_barrier for law in LAWS.values()
    )
    curves = [
        equal_safety.KnobCurve(knob, np.zeros(1), np.ones((1, 1)), np.ones((1, 1)), []) for knob in knobs()
    ]
    assert curves[-1].label == f"{SHORT}, over k_r"
    figure = laws_compared.sheet(2.0)
    whole, zoomed = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    for curve in curves:
        equal_safety.draw_curve(whole, zoomed, curve)
    assert zoomed.get_lines()[-1].get_label() == f"{SHORT}, over $k_r$"


def test_exports_and_the_player_name_it() -> None:
    _, recorded = recorded_run(of(), 0.5, 99.0, {})
    assert f"law={NAME}" in csv_bytes(recorded, 0.5).decode().replace(" ", "").replace(":", "=")
    assert LABEL in player_html(recorded, 0.5, PageSettings(details="laws")).decode()
    drawn = picture_bytes(recorded, 0.5, "laws", "svg").decode()
    assert LABEL in drawn and SHORT in drawn


def test_a_custom_law_runs_instead_of_it_and_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "my_law.py"
    with redirect_stdout(StringIO()):
        assert main(["new-law", str(path)]) == 0
    for ghost in ("off", "own"):
        session = Session(Settings(of(), PageSettings(ghost=ghost)), law=law_of(path))
        try:
            assert isinstance(session.simulation.law, MadeUp) == (ghost == "own")
            frame = freeze(session, 0.0)
            assert contact_card.contact_words(frame, [])["share"] == ("μ" if ghost == "own" else "λ")
        finally:
            session.close()


def test_it_is_graded_as_built_in_laws_are() -> None:
    assert verdict_on(StandIn(LawSettings(law=NAME).made()), "leaves the task alone").passed


def test_no_other_file_of_the_product_names_a_law() -> None:
    # One law has the name of its setting, which is also a column's name.
    quoted = re.compile("|".join(f"[\"']{name}[\"']" for name, law in LAWS.items() if name not in law.reads))
    files = (path for floor in ("app", "scenes", "controllers") for path in (ROOT / floor).rglob("*.py"))
    found = {path.relative_to(ROOT).as_posix() for path in files if quoted.search(path.read_text("utf-8"))}
    assert found == {"scenes/laws.py", "app/text/law_texts.py"}
    assert set(LAW_TEXTS) == set(LAWS)
