"""Lesson cases of the core's `test_charts.py`."""

import math
import re
from itertools import pairwise

import pytest

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import measure
from app.plots.lap_charts import laps_html
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.app.plots.helpers import marks
from tests.scenes.helpers import moved


@pytest.mark.parametrize("joints", [False, True])
def test_the_plot_of_laps_shows_the_drift_of_each_lap(joints: bool) -> None:
    simulation = moved(RunSettings(scene="solo", path="circle", gain=0.0, dt=0.01), lambda s: s.time >= 8.2)
    evidence = Evidence(simulation)
    drift = measure(evidence, "joint_drift_per_lap" if joints else "drift_per_lap")
    assert drift is not None
    html = laps_html(simulation, None, joints, 150)
    assert (
        f"lap 1: {drift * (180.0 / math.pi if joints else 1000.0):.2f} {'°' if joints else 'mm'}"
        in html.replace("\u00a0", " ")
    )
    for numbers in re.findall(r'<div class="xs">(.*?)</div>', html):
        ticks = re.findall(r'left:([\d.]+)%">(.*?)</i>', numbers)
        apart = 0.9 * min(float(right) - float(left) for (left, _), (right, _) in pairwise(ticks))
        assert apart > 6.5 * max(len(text) for _, text in ticks), ticks
    (begin, end) = marks(html, "digit d")
    assert begin == (0.5, 0.5) and math.hypot(end[0] - 0.5, end[1] - 0.5) > 0.2, "the drift is magnified"
    assert laps_html(Simulation(RunSettings(scene="solo", path="circle")), None, joints, 150) == ""
