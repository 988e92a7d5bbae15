"""Texts of panel, card and plots are true when they are shown, for random settings, postures and people."""

import math
import re
from html import unescape

import pytest

from app.page.panels.contact_card import contact_note
from app.page.panels.distance_rate import BELOW, budget_terms, least_lever, promise_html, trend
from app.page.panels.readout import status_html
from app.plots.time_series import resting_now
from app.session.clock import Pace
from app.session.frame import contact
from app.text.lever_texts import lever_text
from scenes.history import Sample
from scenes.random_draws import random_run
from scenes.settings import changed
from scenes.simulation import Simulation

RUNNING = Pace(False, 1.0, False)
LEVER_WORDS = ("no joint moves this point", "the joints hardly move this point")


def text(html: object) -> str:
    return unescape(re.sub(r"<[^>]+>", "", str(html))).replace("\u00a0", " ")


FALLS = 0.02
"""A distance rate that a sentence must not deny [m/s]."""


def untrue(simulation: Simulation) -> list[str]:
    """False sentences about the newest step."""
    sample, run = simulation.sample(), simulation.settings
    if sample.pair < 0:
        return []
    now = contact(simulation, sample)
    terms = budget_terms(simulation, sample, now)
    note, pills = (
        text(contact_note(simulation, sample, now, terms)[1]),
        text(promise_html(simulation, sample)),
    )
    said = f"{note} | {pills} | {text(status_html(RUNNING, simulation, sample))}"
    d, d_m, v, w = sample.distance, run.law.critical_distance, run.law.nominal_velocity, sample.law_approach
    failed, s = d < d_m - BELOW, least_lever(sample)
    levers = [sample.lever] if sample.second is None else [sample.lever, sample.second.lever]
    wrong = {
        "may fail": failed,
        "has failed": not failed,
        "dm is promised": min(d, sample.law_distance) < d_m - BELOW,
        ": below dm": not failed,
        "an endless retreat": v == 0.0 or now.true_change <= 0.0,
        "w > v": w <= v,
        "faster than v": w <= v,
        "no rest": not math.isnan(resting_now(simulation, sample)),
        "no lever": True,
        "may come nearer": failed and d < d_m,
        "has to open": d >= d_m,
        **{words: words not in map(lever_text, levers) for words in LEVER_WORDS},
    }
    faults = [f"{words!r} in {said!r}" for words, false in wrong.items() if words in said and false]
    reach = "joints move this point: s"
    if (
        reach in pills
        and 'class="halt"' in str(promise_html(simulation, sample)).split(reach)[0]
        and not lever_text(s)
    ):
        faults.append(f"a weak lever of {s}")
    return faults


@pytest.mark.parametrize("index", range(24))
def test_no_sentence_is_false_when_it_is_shown(index: int) -> None:
    random = random_run(38, index)
    for extreme in ({}, {"v": 0.0, "dm": 0.3}):
        run = random.settings
        for key, value in extreme.items():
            run = changed(run, key, value)
        simulation = Simulation(run)
        if random.start is not None:
            simulation.reset(random.start)
        source, faults = simulation.source(), untrue(simulation)
        before: tuple[Sample, int, str] | None = None
        while simulation.time < 2.0:
            simulation.step(source.target(simulation.time))
            sample = simulation.sample()
            if before is not None:
                faults += belied(*before, sample, run.dt)
                before = None
            if simulation.steps % 16 == 0 and sample.pair >= 0:
                faults += untrue(simulation)
                before = (
                    sample,
                    trend(contact(simulation, sample).true_change, 0),
                    text(promise_html(simulation, sample)),
                )
        assert not faults, (run, faults[:3])


def belied(was: Sample, said: int, promise: str, sample: Sample, dt: float) -> list[str]:
    """Statements about d that the next step contradicts; none if another pair is closest then."""
    if sample.pair != was.pair:
        return []
    rate = (sample.distance - was.distance) / dt
    faults = [f"the trend {said} at {rate:.3f} m/s"] if said * rate < 0.0 and abs(rate) > FALLS else []
    fallen = (sample.law_distance - was.law_distance) / dt < -FALLS
    return [*faults, "falls further"] if fallen and "falling no further" in promise else faults
