"""Arms that imitate a person from a BVH file glide along their surroundings only with `world`."""

from pathlib import Path

import numpy as np
import pytest

from app.features.person_files.bvh import read_bvh
from controllers.kinematics import Array
from scenes.person.clips import REST
from scenes.person.source import PersonTarget
from scenes.simulation import Simulation
from scenes.targets import quintic
from tests.app.features.person_files.bvh_text import BLENDER, write_bvh
from tests.scenes.helpers import given_settings, least_clearance

BEHIND = np.radians([-31.0, -5.0, -65.0, 70.0])
"""Angles (4,) of a right arm that reaches behind the back [rad]."""


class ReachesBehind:
    """Moves the right arm behind the back in 2 s and keeps it there."""

    def angles(self, time: float) -> Array:
        share, _ = quintic(min(time / 2.0, 1.0))
        return REST + share * (np.array([REST[0], BEHIND]) - REST)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "behind.bvh"
    path.write_text(write_bvh(ReachesBehind(), BLENDER, frames=80), encoding="utf-8")
    return path


def least(file: Path, world: bool) -> float:
    """Least clearance of both arms while the file plays [m]."""
    simulation = Simulation(given_settings(scene="imitation", world=world))
    return least_clearance(simulation, PersonTarget(read_bvh(file)), 5.0)


def test_a_person_from_a_file_moves_an_arm_into_the_stand_without_gliding(file: Path) -> None:
    assert least(file, False) < -0.05
    assert least(file, True) > 0.025
