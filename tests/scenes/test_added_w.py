"""A master that avoids alone and adds w to v: the slave's copy of its motion must not count as w."""

from dataclasses import replace

import numpy as np
import pytest

from controllers.kinematics import Array
from controllers.laws.situation import Situation
from controllers.laws.smooth_priority import SmoothPriority
from scenes.headless import run
from scenes.history import COLUMN
from scenes.promise import Condition, missing
from scenes.settings import Following, RunSettings, changed
from scenes.simulation import Simulation


def master_alone(**values: object) -> RunSettings:
    settings = RunSettings(scene="master_slave", avoid="guided")
    for key, value in ({"ff": True} | values).items():
        settings = changed(settings, key, value)
    return settings


def test_the_velocity_does_not_alternate() -> None:
    """The barrier adds w; with the master's own velocity in w, q̇ jumped by 0.5 rad/s per step."""
    settings = master_alone(law="barrier_qp", rig="table", robot="panda", n=20.0)
    largest = []
    for substeps in (1, 4):
        done = run(replace(settings, dt=settings.dt / substeps), 6.0)
        velocities = done.simulation.history.velocities(done.table)[:, done.simulation.guided.joints]
        largest.append(float(np.abs(np.diff(velocities, axis=0)).max()))
    assert done.summary.d_min < 0.16, "the law had nothing to do"
    assert largest[0] < 0.05
    assert largest[1] < 0.5 * largest[0]


class Told(SmoothPriority):
    """The paper's law, recording its situations."""

    def __call__(self, situation: Situation) -> Array:
        heard.append(situation)
        return super().__call__(situation)


heard: list[Situation] = []


@pytest.mark.parametrize("following", ["mirrored", "identical"])
@pytest.mark.parametrize("rushing", [-1.0, 1.0])
def test_w_contains_only_the_slave_s_own_motion(following: Following, rushing: float) -> None:
    """For any last step of the master, only K (q_d − q) of the slave counts, and only if it approaches."""
    told, recorded = {}, {}
    for speed in (0.0, rushing):
        for adds in (False, True):
            heard.clear()
            simulation = Simulation(master_alone(ff=adds, following=following), 4)
            simulation.use(Told(0.15, 6.0, 0.3, adds))
            slave = simulation.avoiding.joints
            simulation.positions[slave] += np.linspace(-0.2, 0.2, 7)
            simulation.velocities[simulation.guided.joints] = speed * np.linspace(0.1, 0.4, 7)
            simulation.step(None)
            told[speed, adds] = heard[-1].approach
            recorded[speed, adds] = float(simulation.history.table()[-1, COLUMN["w_law"]])
    assert told[rushing, True] == told[0.0, True] == max(told[0.0, False], 0.0)
    assert abs(told[rushing, False] - told[0.0, False]) > 1e-3
    # The history has the true w.
    assert recorded[rushing, True] == recorded[rushing, False] == told[rushing, False]


def test_the_promise_needs_w_at_most_v() -> None:
    """The law omits a part of w, so it does not compensate for any w."""
    alone = master_alone()
    assert (
        not alone.adds_w and changed(alone, "avoid", "free").adds_w and changed(alone, "avoid", "both").adds_w
    )
    assert changed(alone, "scene", "hold").adds_w and not changed(alone, "ff", False).adds_w
    table = run(alone, 0.1).table.copy()
    w = table[:, COLUMN["w_law"]] = np.linspace(0.0, 1.0, len(table))
    assert (missing(alone, table)[Condition.SPEED] == (w > 0.3)).all()
    assert not missing(changed(alone, "avoid", "free"), table)[Condition.SPEED].any()
