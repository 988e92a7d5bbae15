"""A recorded person does the same again, from a log and from a file."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.errors import BadInputFile
from scenes.headless import run
from scenes.inputs import Recorded, RecordedPerson
from scenes.inputs_file import read_person, read_recorded, recorded_bytes, recorded_from
from scenes.packing import PackedTargets, encoded
from scenes.rerun import rerun
from scenes.settings import RunSettings, SceneName, changed
from scenes.targets import HandTarget, Target
from tests.scenes.helpers import SCENES, logged_run, scene_settings
from tests.scenes.inputs.helpers import arrays, everything, same, sample_file, targets


@pytest.mark.parametrize("scene", SCENES)
def test_a_recorded_person_does_the_same_again(scene: SceneName) -> None:
    settings = scene_settings(scene)
    simulation, log = logged_run(settings, 2.5)
    again = run(settings, 2.5, RecordedPerson(everything(log)))
    assert again.table.tobytes() == simulation.history.table().tobytes()


def test_a_recorded_person_acts_at_other_time_steps_and_rests_at_the_end() -> None:
    simulation, log = logged_run(RunSettings(), 0.2)
    simulation.apply(changed(simulation.settings, "dt", 0.02))
    for place in (1.0, 2.0):
        log.record(simulation, HandTarget(np.full(3, place)))
        simulation.step(None)
    person, wanted = RecordedPerson(everything(log)), list(everything(log).targets())
    assert len(wanted) == 42
    early = [(0.0, 0), (0.0025, 0), (0.005, 1), (0.1999, 39)]
    for time, index in [*early, (0.2, 40), (0.219, 40), (0.22, 41), (0.24, 41), (99.0, 41)]:
        assert same(person.target(time), wanted[index]), time


@pytest.mark.parametrize("scene", SCENES)
def test_a_file_brings_everything_back(scene: SceneName, tmp_path: Path) -> None:
    recorded, data = sample_file(scene)
    (tmp_path / "a.npz").write_bytes(data)
    back = read_recorded(tmp_path / "a.npz")
    assert back.settings == recorded.settings and back.steps == recorded.steps and len(back.stretches) == 2
    assert rerun(back).table.tobytes() == rerun(recorded).table.tobytes()


POSSIBLE = targets(arrays(3, -2.0, 2.0), arrays(3, -3.0, 3.0).map(pin.exp3), arrays(7, -3.0, 3.0), arrays(8, -3.0, 3.0))


@settings(max_examples=50)
@given(st.lists(st.tuples(POSSIBLE, st.integers(1, 5)), min_size=1, max_size=12))
def test_every_possible_target_goes_through_a_file(runs: list[tuple[Target | None, int]]) -> None:
    codes, numbers = zip(*(encoded(target) for target, _ in runs), strict=True)
    packed = PackedTargets(
        np.array(codes, np.uint8), np.array([count for _, count in runs], np.uint32), np.frombuffer(b"".join(numbers))
    )
    base, _ = sample_file()
    back = recorded_from(recorded_bytes(Recorded(base.snapshot, (base.stretches[0]._replace(targets=packed),))), "a.npz")
    wanted = [target for target, count in packed.runs() for _ in range(count)]
    assert all(same(a, b) for a, b in zip(back.targets(), wanted, strict=True))


def test_inputs_of_either_kind_are_a_person(tmp_path: Path) -> None:
    recorded, data = sample_file("ball")
    (tmp_path / "a.npz").write_bytes(data)
    (tmp_path / "a.csv").write_text("t,x,y,z\n0,0.4,0,1\n")
    person = read_person(tmp_path / "a.npz", recorded.settings)
    assert same(person.target(0.5), RecordedPerson(recorded).target(0.5))
    hand = read_person(tmp_path / "a.csv", RunSettings()).target(0.0)
    assert isinstance(hand, HandTarget) and hand.position.tolist() == [0.4, 0.0, 1.0]
    with pytest.raises(BadInputFile, match=r"in the scene ball, not hold; add --scene ball\."):
        read_person(tmp_path / "a.npz", RunSettings())
