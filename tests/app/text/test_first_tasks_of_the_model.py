"""The document on the model names the thresholds of the first tasks."""

import inspect
import re
from pathlib import Path

import pytest

import app
from controllers.first_tasks.arms_distance import ArmsDistance
from controllers.first_tasks.centre_of_mass import CentreOfMass
from controllers.first_tasks.first_task import FirstTask
from controllers.first_tasks.joint_stops import JointStops
from controllers.first_tasks.own_links import OwnLinks
from controllers.first_tasks.points_over_plane import PointsOverPlane
from controllers.first_tasks.smallest_singular_value import SmallestSingularValue

TEXT = (Path(app.__file__).parent / "documents" / "model.md").read_text(encoding="utf-8")
SECTION = TEXT.split("## Any first task")[1].split("\n## ")[0]
ROWS = [
    ("distance of two arms", ArmsDistance),
    ("way to the joint stops", JointStops),
    ("hand, wrist and elbow over a plane", PointsOverPlane),
    ("links of the arm from each other", OwnLinks),
    ("smallest singular value", SmallestSingularValue),
    ("centre of mass inside the foot", CentreOfMass),
]


@pytest.mark.parametrize(("name", "task"), ROWS, ids=[name for name, _ in ROWS])
def test_the_table_has_unit_and_thresholds_of_each_first_task(name: str, task: type[FirstTask]) -> None:
    cells = next(
        line.strip("| ").split(" | ") for line in SECTION.splitlines() if line.startswith(f"| {name}")
    )
    assert cells[2] == task.unit
    parameters = inspect.signature(task.__init__).parameters
    defaults = [parameters[key].default for key in ("critical_value", "nominal_rate")]
    assert [float(number) for number in re.findall(r"[\d.]+", cells[3])] == defaults


def test_sources_are_named() -> None:
    assert all(
        name in SECTION for name in ("Žlajpah", "Khatib", "Chan & Dubey", "Yoshikawa", "Sugiura", "Sugihara")
    )
