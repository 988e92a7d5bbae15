"""Both arms keep clear and add the obstacle's speed to v: nothing alternates from step to step."""

from dataclasses import replace

import numpy as np
import pytest

from scenes.headless import run
from scenes.settings import RunSettings

LARGEST_STEP = 0.1
"""Of a joint's velocity from one time step to the next [rad/s]."""


def largest_step(settings: RunSettings) -> float:
    simulation = run(settings, 10.0).simulation
    history = simulation.history
    return float(np.abs(np.diff(history.velocities(history.table()), axis=0)).max())


@pytest.mark.parametrize("seed", range(1, 7))
def test_two_arms_that_add_w_to_v_do_not_ring(seed: int) -> None:
    order, dt = ((6.0, 0.01), (20.0, 0.005))[seed % 2]
    law = replace(RunSettings().law, feed_forward=True, order=order)
    settings = RunSettings(scene="master_slave", law=law, hand_speed=0.8, seed=seed, dt=dt)
    assert settings.one_row and largest_step(settings) <= LARGEST_STEP
