"""The comparison tab: results computed beside the run, in numbers and words."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from app.features.studies.background_studies import BackgroundStudies
from app.features.studies.compare import attack_html, smoothness_html, what_if_html
from app.features.studies.counterexample import Attack, Found, Loss
from app.features.studies.counterexample_search import CounterexampleSearch
from app.features.studies.studies import Smoothness
from app.i18n.speaking import set_language
from app.runtime.job_pool import JobPool
from app.settings import Settings
from scenes.experiments import EXPERIMENTS
from scenes.headless import summarise
from scenes.rerun import WhatIf
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from scenes.smoothness import StepStudy
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import shown

SCENES = tuple(EXPERIMENTS)

PATIENCE = 180.0
"""Longest wait for a study on a busy machine [s]."""


def text(html: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", str(html)))


def test_smoothness_in_a_table() -> None:
    run = RunSettings()
    dts = (0.005, 0.0025, 0.00125, 0.000625)
    smooth = StepStudy(run, 10.0, dts, (0.08, 0.04, 0.02, 0.01))
    half = StepStudy(run, 10.0, dts, (0.5, None, 0.51, None))
    html = text(smoothness_html(Smoothness(smooth, half)))
    assert "5 ms 0.0800 0.5000" in html and "2.5 ms 0.0400 …" in html and "0.625 ms 0.0100 …" in html
    assert "Law: Smooth: half the time step, half the largest step." in html and "Ghost: Measuring …" in html
    assert "Ghost" not in text(smoothness_html(Smoothness(smooth, None)))


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        (
            (5.977e-4, 5.145e-4, 4.027e-4, 2.444e-4),
            "Between: at dt/8, 41 % of the largest step are left; 12 % would be smooth",
        ),
        ((0.4, 0.2, 0.105, 0.1), "A jump of 0.1 rad/s: it stays, however small the time step."),
        ((0.0, 0.0, 0.0, 0.0), "Nothing moved that keeps clear."),
    ],
)
def test_smoothness_is_described(steps: tuple[float, ...], words: str) -> None:
    study = StepStudy(RunSettings(), 10.0, (0.005, 0.0025, 0.00125, 0.000625), steps)
    assert words in text(smoothness_html(Smoothness(study, None)))


def test_the_tables_use_the_readers_decimal_sign() -> None:
    set_language("de")
    run, dts = RunSettings(), (0.005, 0.0025, 0.00125, 0.000625)
    between = StepStudy(run, 10.0, dts, (0.5, 0.45, 0.4, 0.33))
    jump = StepStudy(run, 10.0, dts, (0.5, 0.5, 0.5, 0.5))
    simulation = Simulation(RunSettings(scene="master_slave"))
    simulation.step(None)
    table = simulation.history.table()
    found = summarise(simulation, table)
    answer = WhatIf(table[:, 0], table[:, 1], table[:, 3], simulation.settings, found, found)
    for html in (smoothness_html(Smoothness(between, jump)), what_if_html(answer)):
        assert re.search(r"\d,\d", text(html)) and not re.search(r"\d\.\d", text(html)), text(html)


@contextmanager
def held(jobs: JobPool, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Start no job meanwhile: a quick job would end before the page shows that it is computed."""
    with monkeypatch.context() as context:
        context.setattr(jobs, "_pump", lambda: None)
        yield
    jobs._pump()


def test_the_tab_on_comparisons_follows_the_studies(
    house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = house()
    one, jobs = arrive(opened, "scene=hold"), opened.context.jobs
    assert isinstance(jobs, JobPool)

    def says(*words: str) -> None:
        one.visitor.wait_for(lambda v: all(word in text(shown(v)) for word in words), PATIENCE)

    # Right after a reset there is too little data, however fast the frames come.
    one.ask(lambda s: (s.reset(), s.parts.of(BackgroundStudies).measure_smoothness()))
    says("few seconds")
    one.ask(lambda s: s.change("whatif", True))
    says("Now move")
    one.run_on(1.5)
    with held(jobs, monkeypatch):
        one.ask(lambda s: [s.control.toggle_pause(), s.change("dm", 0.2)])
        says("Computing")
    for d_m in (0.2, 0.1):
        one.ask(lambda s, d_m=d_m: s.change("dm", d_m))
        says("as it was", f"With d m = {1000 * d_m:.0f} mm")
    with held(jobs, monkeypatch):
        one.ask(lambda s: s.parts.of(BackgroundStudies).measure_smoothness())
        says("Measuring")
    one.visitor.wait_for(
        lambda v: "Largest step" in text(shown(v)) and "Measuring" not in text(shown(v)), PATIENCE
    )
    one.ask(lambda s: s.change("scene", "solo"))
    one.visitor.wait_for(
        lambda v: "as it was" not in shown(v) and not v.mirror.labelled("how smooth")["visible"], PATIENCE
    )


@pytest.mark.parametrize("scene", ["hold", "master_slave"])
def test_what_if_in_a_table(scene: str) -> None:
    simulation = Simulation(RunSettings(scene=scene))
    for _ in range(40):
        simulation.step(None)
    table = simulation.history.table()
    before = summarise(simulation, table)
    before = replace(before, d_min=-0.0334)
    summary = replace(before, d_min=0.1234, share_below=0.25, e2_max=0.01, dq_step_max=0.5)
    answer = WhatIf(table[:, 0], table[:, 1], table[:, 3], simulation.settings, summary, before)
    html = text(what_if_html(answer))
    assert "−33 mm 123 mm" in html and "25 %" in html and "0.500 rad/s" in html
    assert ("5.7°" in html) == (scene == "master_slave") and ("100 mm" in html) == (scene == "hold")


def test_what_if_of_another_first_task_has_its_symbol_and_unit() -> None:
    simulation = Simulation(RunSettings(scene="first_task", first="stops"))
    for _ in range(40):
        simulation.step(None)
    table = simulation.history.table()
    before = replace(summarise(simulation, table), d_min=0.0334)
    answer = WhatIf(table[:, 0], table[:, 1], table[:, 3], simulation.settings, before, before)
    html = text(what_if_html(answer))
    assert "least h 33 mrad" in html and "With h m = 150 mrad." in html and "below h m" in html
    search = CounterexampleSearch(None, lambda: None, Settings, lambda recorded, name: None)
    attack = Attack(simulation.settings, np.zeros(7), np.zeros((3, 3)))
    search.worst, search.runs = Found(attack, Loss(0.105, 0.0, 0.003, {}), {}, 40), 40
    said = text(attack_html(search))
    assert "h law falls 105.0 mrad below h m" in said and "a regular J a" in said


@pytest.mark.parametrize(
    ("law", "lost", "strict", "words"),
    [
        ("smooth_priority", 0.105, 0.0, ("falls 105.0 mm below", "What was missing: one closest pair.")),
        (
            "smooth_priority",
            0.105,
            0.02,
            ("falls 105.0 mm below", "All conditions held: here the promise breaks."),
        ),
        ("unprotected", 0.105, 0.02, ("falls 105.0 mm below", "This law makes no promise.")),
        ("smooth_priority", 0.0, 0.0, ("none broke the promise", "comes to 3.0 mm above")),
    ],
)
def test_a_search_names_the_missing_condition(
    law: str, lost: float, strict: float, words: tuple[str, str]
) -> None:
    search = CounterexampleSearch(None, lambda: None, Settings, lambda recorded, name: None)
    attack = Attack(RunSettings(scene="hold", law=LawSettings(law=law)), np.zeros(14), np.zeros((3, 3)))
    search.worst, search.runs = Found(attack, Loss(lost, strict, 0.003, {}), {}, 40), 40
    said = attack_html(search)
    assert (
        said.startswith("40 runs")
        and all(part in said for part in words)
        and said.endswith((words[1], "hold."))
    )
