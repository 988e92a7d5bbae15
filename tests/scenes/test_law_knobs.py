"""A law's knob is turned until it keeps the distance of another law on the same inputs; or it is said that no value does."""

import pytest

from scenes.inputs import InputsLog, Recorded
from scenes.law_knobs import MATCH, MOST_RERUNS, match_knob
from scenes.rerun import Stopped, rerun
from scenes.settings import RunSettings, changed, values
from scenes.simulation import Simulation

RUN = RunSettings(dt=0.02)


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    simulation, inputs = Simulation(RUN), InputsLog()
    source = simulation.source()
    for _ in range(600):
        target = source.target(simulation.time)
        inputs.record(simulation, target)
        simulation.step(target)
    found = inputs.window(30.0)
    assert found is not None
    return found


def law(name: str, **more: object) -> dict[str, object]:
    settings = changed(RUN, "law", name)
    for key, value in more.items():
        settings = changed(settings, key, value)
    return values(settings.law)


@pytest.mark.parametrize(("name", "key"), [("barrier_qp", "dm"), ("potential_field", "eta"), ("intermediate_value", "dm")])
def test_the_found_value_keeps_the_distance(recorded: Recorded, name: str, key: str) -> None:
    reference = law("smooth_priority")
    found = match_knob(recorded, reference, law(name))
    assert found.key == key and found.value is not None
    ours, theirs = (rerun(recorded, settings).summary.d_min for settings in (reference, {**law(name), key: found.value}))
    assert found.wanted == ours and found.reached == theirs and abs(theirs - ours) <= MATCH


def test_a_distance_out_of_reach_is_reported_after_few_runs(recorded: Recorded) -> None:
    asked: list[int] = []
    found = match_knob(recorded, law("smooth_priority"), law("null_space_avoidance"), lambda: bool(asked.append(1)))
    assert found.value is None and found.key == "d0" and found.reached < found.wanted - MATCH
    none = match_knob(recorded, law("smooth_priority"), law("unprotected"))
    assert none.key == "" and none.value is None and none.reached < none.wanted
    looks = len(asked) // (1 + -(-recorded.steps // 64))
    assert looks <= MOST_RERUNS


def test_it_ends_when_the_answer_is_no_longer_wanted(recorded: Recorded) -> None:
    with pytest.raises(Stopped):
        match_knob(recorded, law("smooth_priority"), law("barrier_qp"), lambda: True)
