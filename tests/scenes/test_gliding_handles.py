"""Every handle glides along obstacles with `world`; without it the same input enters an obstacle."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from controllers import compiled
from scenes.person.clips import REST
from scenes.person.source import PersonTarget, SampledAngles
from scenes.recording import read_inputs
from scenes.roles import Scripted, TargetSource
from scenes.simulation import Simulation
from scenes.targets import HandTarget, JointTarget, PairTarget
from tests.scenes.helpers import given_settings, least_clearance

BELOW = np.array([0.3, 0.25, 0.3])
"""A place below the bench (3,) [m]."""


@pytest.fixture(autouse=True, scope="module")
def machine_code() -> None:
    compiled.load_now()


def least(source_of: Callable[[Simulation], TargetSource], world: bool, scene: str, rig: str) -> float:
    """Least clearance of both arms in 5 s [m]."""
    simulation = Simulation(given_settings(scene=scene, rig=rig, world=world, wmax=0.5))
    return least_clearance(simulation, source_of(simulation), 5.0)


def elbow(_: Simulation) -> TargetSource:
    return Scripted(lambda _: HandTarget(np.array([0.3, 0.25, 0.8]), elbow=BELOW))


def second_person(_: Simulation) -> TargetSource:
    return Scripted(lambda _: PairTarget(None, HandTarget(BELOW)))


def key_of_a_joint(simulation: Simulation) -> TargetSource:
    joints = simulation.guided.joints
    wanted = simulation.positions[joints].copy()
    wanted[1] = simulation.room.model.lowerPositionLimit[joints][1]
    return Scripted(lambda _: JointTarget(wanted))


def person_who_reaches_behind(_: Simulation) -> TargetSource:
    behind = REST.copy()
    behind[1] = np.radians([-31.0, -5.0, -65.0, 70.0])
    return PersonTarget(SampledAngles(np.array([0.0, 2.0]), np.array([REST, behind])))


@pytest.mark.parametrize(
    ("source_of", "scene", "rig"),
    [
        (elbow, "hold", "table"),
        (second_person, "hold", "table"),
        (second_person, "hold", "torso"),
        (key_of_a_joint, "master_slave", "table"),
        (person_who_reaches_behind, "imitation", "torso"),
    ],
)
def test_a_handle_glides(source_of: Callable[[Simulation], TargetSource], scene: str, rig: str) -> None:
    if rig == "torso" and source_of is second_person:
        inside = Scripted(lambda _: PairTarget(None, HandTarget(np.array([-0.05, 0.0, 0.75]))))
        source_of = lambda _: inside  # noqa: E731
    assert least(source_of, False, scene, rig) < -0.02
    assert least(source_of, True, scene, rig) > 0.02


def test_a_file_of_inputs_glides(tmp_path: Path) -> None:
    file = tmp_path / "below.csv"
    file.write_text("t,x,y,z\n0,0.3,0.25,1.0\n1,0.3,0.25,0.3\n5,0.3,0.25,0.3\n", encoding="utf-8")
    person = read_inputs(file)
    assert least(lambda _: person, False, "hold", "table") < -0.02
    assert least(lambda _: person, True, "hold", "table") > 0.02
