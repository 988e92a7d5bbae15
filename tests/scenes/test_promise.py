"""The promise d ≥ d_law ≥ d_m: every run's own columns say what λ and ḋ must be, and which condition a step misses."""

import csv
import io
from typing import get_args

import numpy as np
import pytest

from controllers.activation import activation
from controllers.choices import Treatment
from controllers.kinematics import Array
from controllers.limits import Authority
from scenes.headless import Run, run
from scenes.promise import Condition, broken_by, makes_promise, missing, missing_now
from scenes.random_runs import random_run
from scenes.recording import write_table
from scenes.settings import LawName, RunSettings, SceneName, changed
from scenes.simulation import Simulation
from scenes.world import World
from tests.scenes.helpers import SCENES, column, given_settings, with_law

BETWEEN = given_settings(start="between", avoid="guided", seed=396, v=0.05, pairs="single")


def columns(done: Run) -> dict[str, Array]:
    """The columns of numbers in a run's CSV file, by name."""
    out = io.StringIO()
    write_table(out, done.simulation, done.table, {})
    rows = list(csv.DictReader(io.StringIO(out.getvalue())))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0] if name != "pair"}


@pytest.mark.parametrize("scene", SCENES[1:])
@pytest.mark.parametrize("pairs", get_args(Treatment))
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_columns_of_any_run_say_what_the_rate_is(scene: SceneName, pairs: Treatment, seed: int) -> None:
    """J_d q̇ of all joints, from the q and q̇ columns alone, is the sum of s λ (v + u) − u of the arms that keep clear, less w."""
    settings = random_run(7, seed).settings
    for key, value in {"scene": scene, "pairs": pairs, "law": "smooth_priority", "dt": 0.01}.items():
        settings = changed(settings, key, value)
    done = run(settings, 2.0)
    law, found, room = settings.law, columns(done), done.simulation.room
    lam = np.array([activation(d, law.critical_distance, law.order) for d in found["law_d"]])
    np.testing.assert_allclose(lam, column(done.table, "lambda"), rtol=0.0, atol=1e-12)
    q, dq = (np.column_stack([found[name.format(what)] for name in room.columns]) for what in ("q", "dq"))
    world, rates, distances = World(room, settings.limit_gain), [], []
    for positions, velocities in zip(q, dq, strict=True):
        world.kinematics.update(positions)
        near = world.detector.detect(law.pairs, law.beta, law.convexity)
        rates.append(float(near.row.dot(velocities)))
        distances.append(near.law_distance)
    np.testing.assert_allclose(distances, found["law_d"], rtol=0.0, atol=1e-12)
    two = "u_b" in found
    expected = np.zeros(len(lam)) if two else -found["w_law"]
    for end in ("", "_b") if two else ("",):
        wanted = law.nominal_velocity + found[f"u{end}"] + (found[f"w_law{end}"] if law.feed_forward else 0.0)
        expected += found[f"lever{end}"] * lam * (np.maximum(wanted, 0.0) if law.one_sided else wanted) - found[f"u{end}"]
    free = np.ones(len(lam), bool)
    for end in ("", "_b") if two else ("",):
        free &= ~np.isin(column(done.table, f"authority{end}"), (Authority.STOP, Authority.SPEED))
    assert free.sum() > 20
    off = np.abs(np.array(rates) - expected)[free]
    # Where a bound acts the rate is reached within `controllers.limits.TOLERANCE`.
    assert off.max() < 4e-6
    assert np.median(off) < 1e-12


def test_between_two_pairs_the_promise_is_broken_and_that_is_what_is_missing() -> None:
    done = run(BETWEEN, 8.0)
    law_d = column(done.table, "law_d")
    lost = missing(BETWEEN, done.table)
    assert law_d.min() < BETWEEN.law.critical_distance - 0.1
    assert {condition for condition, steps in lost.items() if steps.any()} == {Condition.PAIRS}
    assert missing_now(BETWEEN, done.simulation.history) == (Condition.PAIRS,)
    assert broken_by(BETWEEN, done.table) < 1e-3
    # The same table without the excuse.
    assert broken_by(with_law(BETWEEN, pairs="soft"), done.table) > 0.1
    for pairs in ("soft", "smooth"):
        cured = with_law(BETWEEN, pairs=pairs)
        done = run(cured, 8.0)
        assert column(done.table, "law_d").min() > cured.law.critical_distance
        assert not any(steps.any() for steps in missing(cured, done.table).values())
        assert missing_now(cured, done.simulation.history) == ()


@pytest.mark.parametrize(
    ("settings", "expected"),
    [(given_settings(wmax=0.8, v=0.05, seed=3), Condition.SPEED), (BETWEEN, Condition.PAIRS)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_page_and_the_table_say_the_same_of_every_step(settings: RunSettings, expected: Condition) -> None:
    """What is known at a step is what the whole table says of it, but for a switch that is still to come."""
    simulation = Simulation(settings)
    person, seen = simulation.source(), []
    while simulation.time < 8.0:
        simulation.step(person.target(simulation.time))
        seen.append(missing_now(settings, simulation.history))
    whole = missing(settings, simulation.history.table())
    for condition in (Condition.SPEED, Condition.LEVER, Condition.BOUND):
        assert [condition in now for now in seen] == whole[condition].tolist()
    assert any(expected in now for now in seen) and () in seen
    known = np.array([Condition.PAIRS in now for now in seen])
    assert not np.any(known & ~whole[Condition.PAIRS])


def test_an_empty_history_misses_nothing_and_one_law_makes_the_promise() -> None:
    assert missing_now(BETWEEN, Simulation(BETWEEN).history) == ()
    assert [name for name in get_args(LawName) if makes_promise(with_law(BETWEEN, law=name).law)] == ["smooth_priority"]
