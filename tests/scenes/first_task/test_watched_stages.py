"""Recorded values of every stage match the stage, and recording changes nothing."""

import numpy as np
from numpy.testing import assert_allclose

from controllers.limits import Authority
from scenes.history import COLUMN
from scenes.promise import broken_by
from scenes.quantities import ALL, PARTS
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.watched_stages import WatchedStages
from tests.scenes.helpers import given_settings

STEPS = 3000


def made(simulation: Simulation) -> Simulation:
    source = simulation.source()
    for _ in range(STEPS):
        simulation.step(source.target(simulation.time))
    return simulation


def settings(**others: object) -> RunSettings:
    return given_settings(scene="first_task", first=ALL, together="stages", dt=0.01, **others)


def test_every_stage_has_its_value_its_rate_and_its_authority() -> None:
    plain, watched = made(Simulation(settings())), made(WatchedStages(settings()))
    assert isinstance(watched, WatchedStages)
    tables, law = watched.tables(), watched.settings.law
    assert len(tables) == len(PARTS[ALL])
    assert tables[0].tobytes() == plain.history.table().tobytes()
    world = watched.world
    for row in range(0, STEPS, 250):
        world.kinematics.update(watched.history.positions(tables[0])[row])
        world.detector.detect()
        assert_allclose([table[row, COLUMN["law_d"]] for table in tables], world.detector.distances())
    acted = taken = 0
    for table in tables[1:]:
        value, lam, u, s = (table[:, COLUMN[name]] for name in ("law_d", "lambda", "u", "lever"))
        rate = np.diff(value) / watched.settings.dt
        authority = table[:-1, COLUMN["authority"]]
        promised = (s * lam * (law.nominal_velocity + u) - u)[:-1]
        last = table is tables[-1]
        full = (authority == Authority.FULL) & ((lam[:-1] > 0.5) | last)
        # The last stage loses nothing to a later one; the others report such a loss.
        assert (rate - promised)[full].min(initial=0.0) > -0.02
        assert not last or np.abs(rate - promised)[full].max() < 0.02
        acted += int(full.sum())
        taken += int((authority == Authority.WORLD).sum())
        assert not (last and (authority == Authority.WORLD).any())
        assert value.min() > 0.9 * law.critical_distance and broken_by(watched.settings, table) < 0.002
    assert acted > 200 and taken > 0


def test_a_reset_clears_the_tables() -> None:
    watched = WatchedStages(settings())
    for _ in range(2):
        watched.reset()
        for _ in range(5):
            watched.step(None)
        assert [len(table) for table in watched.tables()] == [5] * len(PARTS[ALL])
