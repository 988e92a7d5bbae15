"""Every arm moves as its file says; any two start well and keep clear in a room."""

import importlib.metadata
import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from controllers.kinematics import Kinematics
from controllers.proximity import ProximityDetector
from scenes.headless import run
from scenes.rigs import place_bases
from scenes.robots import RobotName, robot
from scenes.robots.example_data import EXAMPLES
from scenes.robots.fitting import fit_example
from scenes.robots.start_search import start_posture
from scenes.room import build_room
from scenes.settings import RigName, RunSettings, changed
from scenes.simulation import Simulation
from tests.approved import Approve, case_lines
from tests.scenes.helpers import RIG_NAMES, column, refusal
from tests.scenes.robots.helpers import NAMES, assert_they_keep_clear, link_poses, other_reader, postures

WRONG_BASES = ("1,2,3", "0,0,9,0", "nan,0,0,0", "a,b,c,d")


@pytest.mark.parametrize("name", NAMES)
def test_both_readers_and_the_file_agree(name: RobotName) -> None:
    model = robot(name).model
    data = model.createData()
    for q in postures(model, 10):
        pin.framesForwardKinematics(model, data, q)
        poses = link_poses(name, q)
        assert robot(name).hand in poses
        for link, pose in poses.items():
            assert_allclose(data.oMf[model.getFrameId(link)].homogeneous, pose, atol=1e-9, err_msg=link)
    model, reader = robot(name).model, other_reader(name)
    for i, joint in enumerate(list(model.names)[1:]):
        limit = reader.joint_map[joint].limit
        assert (model.lowerPositionLimit[i], model.upperPositionLimit[i]) == (limit.lower, limit.upper)
        assert model.velocityLimit[i] == limit.velocity


@pytest.mark.parametrize(("name", "joints"), [("lwr", 7), ("panda", 7), ("ur5", 6)])
def test_a_robot_is_complete(name: RobotName, joints: int) -> None:
    arm = robot(name)
    assert robot(name) is arm
    assert arm.model.nq == arm.model.nv == len(arm.labels) == len(set(arm.labels)) == joints
    assert arm.model.existFrame(arm.hand) and 1 <= arm.shoulder < arm.elbow < arm.wrist <= joints
    assert 1 <= len(arm.capsules) <= 6
    assert len({capsule.name for capsule in arm.capsules}) == len(arm.capsules)
    carriers = [capsule.joint for capsule in arm.capsules]
    assert min(carriers) == 0 and carriers == sorted(set(carriers))


def test_robots_by_name() -> None:
    assert robot("lwr") is robot("lwr") and robot("lwr").name == "KUKA LWR 4+"


def test_a_wrong_robot_or_base_is_refused_with_a_remedy(approve: Approve) -> None:
    gone = replace(EXAMPLES["ur5"], urdf="ur_description/urdf/gone.urdf")
    said = {
        "unknown": refusal(lambda: robot("r2d2")),  # pyright: ignore[reportArgumentType]
        "not given": refusal(lambda: changed(RunSettings(), "robot", "lwr_other-0123456789ab")),
        "bases not given": refusal(lambda: changed(RunSettings(), "rig", "-0.5,0,0.75,0:0.5,0,0.75,180")),
        "damaged": refusal(lambda: fit_example(gone)),
        **{text: refusal(lambda text=text: place_bases(text, "")) for text in WRONG_BASES},
    }
    # The package's folder.
    approve("refusals.txt", re.sub(r"/\S*/(?=ur_description)", "…/", case_lines(said)))


@pytest.mark.parametrize("name", NAMES)
def test_landmarks_make_an_arm(name: RobotName) -> None:
    arm = robot(name)
    data = arm.model.createData()
    pin.forwardKinematics(arm.model, data, start_posture(name, "table", "left"))
    shoulder, elbow, wrist = (
        data.oMi[joint].translation.copy() for joint in (arm.shoulder, arm.elbow, arm.wrist)
    )
    upper, fore = elbow - shoulder, wrist - elbow
    assert min(np.linalg.norm(upper), np.linalg.norm(fore)) > 0.3
    bend = np.arccos(upper @ fore / np.linalg.norm(upper) / np.linalg.norm(fore))
    assert np.radians(50) < bend < np.radians(140)


def test_missing_packages_are_reported_with_a_remedy(
    monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    def missing(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.files", missing)
    said = {"no package": refusal(lambda: fit_example(EXAMPLES["panda"]))}
    monkeypatch.setattr("importlib.metadata.files", lambda _: [])
    said["no robots"] = refusal(lambda: fit_example(EXAMPLES["panda"]))
    approve("missing packages.txt", case_lines(said))


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_arms_start_apart_away_from_their_stops_and_mirrored(name: RobotName, rig: RigName) -> None:
    """25 cm apart, 15° from every stop; hands in front, mirrored, at the same height."""
    room = build_room(rig, name)
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    assert ProximityDetector(kinematics, room.geometry).detect("single").distance >= 0.25
    margin = np.minimum(
        room.start - room.model.lowerPositionLimit, room.model.upperPositionLimit - room.start
    )
    assert margin.min() > np.radians(15)
    left, right = (kinematics.hand_pose(arm).translation for arm in room.arms)
    assert_allclose(left, right * ((1, -1, 1) if rig == "torso" else (-1, -1, 1)), atol=2e-3)
    assert left[0] > 0.6 if rig == "torso" else -0.45 < left[0] < -0.15
    assert 0.8 < left[2] < 1.6


@pytest.mark.parametrize("rig", ["torso", "table"])
@pytest.mark.parametrize("pair", ["lwr_panda", "ur5_panda"])
def test_two_arms_start_clear_and_keep_clear(pair: str, rig: str) -> None:
    assert_they_keep_clear(pair, rig)


def test_a_slave_with_fewer_joints_follows() -> None:
    table = run(replace(RunSettings(), robot="ur5_lwr", scene="master_slave", rig="table"), 1.0).table
    assert np.isfinite(column(table, "d")).all()


def test_given_bases(registry: None) -> None:
    name = place_bases("0,0.5,0.2,0", "0,-0.5,0.2,0")
    settings = changed(replace(RunSettings(), robot="ur5_panda"), "rig", name)
    left, right = Simulation(settings, 1).room.rig.bases
    assert left.translation.tolist() == [0.0, 0.5, 0.2] and right.translation.tolist() == [0.0, -0.5, 0.2]
    assert column(run(settings, 2.0).table, "d").min() >= settings.law.critical_distance
