"""What the panel, the card and the plots say is true at the moment at which they say it: random settings, postures and people."""

import math
import re
from html import unescape

import numpy as np
import pytest

from app.features.lessons.evidence import Evidence
from app.features.lessons.measures.quantity import measure
from app.features.lessons.room_places import RoomPlace, Start, start_positions
from app.page.panels.contact_card import contact_note, contact_numbers
from app.page.panels.distance_rate import BELOW, budget_terms, least_lever, promise_html, trend
from app.page.panels.readout import status_html
from app.plots.time_series import COLUMNS, resting_now, signals
from app.session.clock import Pace
from app.session.frame import contact, freeze
from app.session.session import Session
from app.settings import Settings
from app.text.lever_texts import lever_text
from controllers.choices import Treatment
from scenes.history import COLUMN, Sample
from scenes.laws import DEFAULT_LAW, LAWS
from scenes.random_runs import random_run
from scenes.settings import changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import place_of

RUNNING = Pace(False, 1.0, False)
LEVER_WORDS = ("no joint moves this point", "the joints hardly move this point")


def text(html: object) -> str:
    return unescape(re.sub(r"<[^>]+>", "", str(html))).replace("\u00a0", " ")


FALLS = 0.02
"""A distance rate that a sentence must not deny [m/s]."""


def untrue(simulation: Simulation) -> list[str]:
    """Sentences of the newest step that are not so in it."""
    sample, run = simulation.sample(), simulation.settings
    if sample.pair < 0:
        return []
    now = contact(simulation, sample)
    terms = budget_terms(simulation, sample, now)
    note, pills = text(contact_note(simulation, sample, now, terms)[1]), text(promise_html(simulation, sample))
    said = f"{note} | {pills} | {text(status_html(RUNNING, simulation, sample))}"
    d, d_m, v, w = sample.distance, run.law.critical_distance, run.law.nominal_velocity, sample.law_approach
    failed, s = d < d_m - BELOW, least_lever(sample)
    levers = [sample.lever] if sample.second is None else [sample.lever, sample.second.lever]
    wrong = {
        "may fail": failed,
        "has failed": not failed,
        "stands": min(d, sample.law_distance) < d_m - BELOW,
        ": below dm": not failed,
        "a retreat for ever": v == 0.0 or now.true_change <= 0.0,
        "w > v": w <= v,
        "faster than v": w <= v,
        "no rest": not math.isnan(resting_now(simulation, sample)),
        "no lever": True,
        "may come nearer": failed and d < d_m,
        "has to open": d >= d_m,
        **{words: words not in map(lever_text, levers) for words in LEVER_WORDS},
    }
    faults = [f"{words!r} in {said!r}" for words, false in wrong.items() if words in said and false]
    if "lever" in pills and 'class="halt"' in str(promise_html(simulation, sample)).split("lever")[0] and not lever_text(s):
        faults.append(f"a weak lever of {s}")
    return faults


@pytest.mark.parametrize("index", range(24))
def test_no_sentence_is_untrue_at_the_moment_at_which_it_is_shown(index: int) -> None:
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
                before = sample, trend(contact(simulation, sample).true_change, 0), text(promise_html(simulation, sample))
        assert not faults, (run, faults[:3])


def belied(was: Sample, said: int, promise: str, sample: Sample, dt: float) -> list[str]:
    """What was said of d and is belied by the next step, in which the same bodies are the closest."""
    if sample.pair != was.pair:
        return []
    rate = (sample.distance - was.distance) / dt
    faults = [f"the trend {said} at {rate:.3f} m/s"] if said * rate < 0.0 and abs(rate) > FALLS else []
    fallen = (sample.law_distance - was.law_distance) / dt < -FALLS
    return [*faults, "falls further"] if fallen and "falling no further" in promise else faults


def begin(simulation: Simulation) -> HandTarget | None:
    """A person who brings the orange hand, or a ball at rest, so near that the silver hand has to leave its place."""
    if simulation.room.ball is None:
        return HandTarget(place_of(simulation) + np.array([0.0, -0.2, 0.0]))
    simulation.reset(start_positions(simulation.room, Start(RoomPlace("goal", (0.0, 0.0, 1.0), 0.1))))
    return None


RESTING = [name for name, entry in LAWS.items() if entry.rests]
RESTS = [
    # Two pairs of bodies tie there: a law that sees the closest one alone has it change all the time.
    ("hold", DEFAULT_LAW, "single", 0.0),
    *(("hold", law, pairs, rate) for law in RESTING for pairs in ("soft", "smooth") for rate in (0.0, 50.0)),
    *(("ball", law, "single", rate) for law in RESTING for rate in (0.0, 50.0)),
]


@pytest.mark.parametrize(("scene", "law", "treatment", "rate"), RESTS)
def test_an_arm_rests_at_the_number_that_is_shown_in_every_treatment_of_pairs(
    scene: str, law: str, treatment: Treatment, rate: float
) -> None:
    settings = Settings()
    chosen = {"law": law, "pairs": treatment, "fps": rate, "autopilot": False, "dt": 0.01, "scene": scene}
    for key, value in chosen.items():
        settings = changed(settings, key, value)
    session = Session(settings)
    simulation = session.simulation
    target = begin(simulation)
    # The hand leaves the goal of the ball experiment after 8 s.
    for _ in range(790 if scene == "ball" else 1000):
        simulation.step(target)
    frame = freeze(session, 0.0)
    sample, run = frame.sample, settings.run
    table = simulation.history.table(60)
    assert np.ptp(table[:, COLUMN["d"]]) < 1e-3 and sample.lever == 1.0 and sample.authority == 0, "at rest, and able to move"
    assert sample.activation > 0.1, "pulled by its task, held back by the law"
    assert resting_now(simulation, sample) == pytest.approx(sample.distance, abs=1e-3)
    # The card, the plot, and what a lesson measures.
    d, law_d, rest, *_ = contact_numbers(frame, frame.contact, budget_terms(simulation, sample, frame.contact), 0)
    assert d is not None and law_d is not None and rest is not None
    assert abs(rest - d) <= 1 and d == round(1e3 * sample.distance)
    columns = signals(simulation, run, table)
    # Pairs that take turns have a d* each.
    assert columns[:, COLUMNS["d*"]].mean() == pytest.approx(columns[:, COLUMNS["d"]].mean(), abs=1e-3)
    evidence = Evidence(simulation)
    assert measure(evidence, "rest_now") == pytest.approx(measure(evidence, "distance_now"), abs=1e-3)
    assert (sample.distance - sample.law_distance > 2e-3) == (treatment != "single"), "d_law is another number there"
