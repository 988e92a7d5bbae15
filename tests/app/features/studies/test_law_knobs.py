"""The knob of a law, set to keep the distance of another law."""

import pytest

from app.features.studies.law_knobs import MATCH, MOST_RERUNS, match_knob
from scenes.inputs import Recorded
from scenes.rerun import rerun
from scenes.settings import RunSettings, values
from scenes.wanted import Stopped, until
from tests.scenes.helpers import given_settings, recorded_run

pytestmark = pytest.mark.slow

RUN = RunSettings(dt=0.02)


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    return recorded_run(RUN, 6.0, 30.0)[1]


def law(name: str) -> dict[str, object]:
    return values(given_settings(law=name).law)


@pytest.mark.parametrize(
    ("name", "key"), [("barrier_qp", "dm"), ("potential_field", "eta"), ("intermediate_value", "dm")]
)
def test_the_found_value_keeps_the_distance(recorded: Recorded, name: str, key: str) -> None:
    reference = law("smooth_priority")
    found = match_knob(recorded, reference, law(name))
    assert found.key == key and found.value is not None
    ours, theirs = (
        rerun(recorded, settings).summary.d_min for settings in (reference, {**law(name), key: found.value})
    )
    assert found.wanted == ours and found.reached == theirs and abs(theirs - ours) <= MATCH


def test_an_unreachable_distance_is_reported_after_few_runs(recorded: Recorded) -> None:
    asked: list[int] = []
    with until(lambda: bool(asked.append(1))):
        found = match_knob(recorded, law("smooth_priority"), law("null_space_avoidance"))
    assert found.value is None and found.key == "d0" and found.reached < found.wanted - MATCH
    none = match_knob(recorded, law("smooth_priority"), law("unprotected"))
    assert none.key == "" and none.value is None and none.reached < none.wanted
    assert len(asked) <= MOST_RERUNS * -(-recorded.steps // 64)


def test_a_search_ends_when_its_answer_is_no_longer_wanted(recorded: Recorded) -> None:
    with pytest.raises(Stopped), until(lambda: True):
        match_knob(recorded, law("smooth_priority"), law("barrier_qp"))
