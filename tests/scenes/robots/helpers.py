"""Our robots, also as another program reads them."""

import importlib.metadata
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import get_args

import numpy as np
import pinocchio as pin
import trimesh
import yourdfpy

from controllers.kinematics import Array
from scenes.headless import run
from scenes.lwr.urdf import URDF_FILE
from scenes.robots import RobotName, robot
from scenes.robots.example_data import EXAMPLES
from scenes.settings import RunSettings, validate
from scenes.simulation import Simulation
from tests.scenes.helpers import beyond, column

NAMES: tuple[RobotName, ...] = get_args(RobotName)
OTHERS: tuple[RobotName, ...] = ("panda", "ur5")
ROOT_LINK = {"lwr": "link0", "panda": "panda_link0", "ur5": "base_link"}


@cache
def other_reader(name: RobotName) -> yourdfpy.URDF:
    if name == "lwr":
        return yourdfpy.URDF.load(str(URDF_FILE), load_meshes=False)
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    (urdf,) = (Path(str(file.locate())) for file in files if str(file).endswith(EXAMPLES[name].urdf))
    share = next(folder for folder in urdf.parents if folder.name == "robots").parent.parent
    return yourdfpy.URDF.load(
        str(urdf),
        load_meshes=False,
        filename_handler=lambda text: str(share / text.removeprefix("package://")),
    )


def link_poses(name: RobotName, q: Array) -> dict[str, Array]:
    """Pose (4, 4) of every link in the frame of the arm's base, by yourdfpy."""
    reader, ours = other_reader(name), EXAMPLES.get(name)
    fingers = [] if ours is None else list(ours.locked.values())
    reader.update_cfg(np.r_[q, fingers[: len(reader.actuated_joint_names) - len(q)]])
    lift = np.eye(4)
    lift[2, 3] = 0.0 if ours is None else ours.column
    return {link: lift @ reader.get_transform(link, ROOT_LINK[name]) for link in reader.link_map}


@cache
def collision_points(name: RobotName) -> dict[str, Array]:
    """Points (k, 3) on the collision shapes of every link, in its frame, by yourdfpy and trimesh."""
    reader, found = other_reader(name), {}
    random = np.random.default_rng(4)
    for link in reader.link_map.values():
        points = [np.zeros((0, 3))]
        for collision in link.collisions:
            shape = collision.geometry
            solid = (
                trimesh.creation.box(shape.box.size)
                if shape.box is not None
                else trimesh.load_mesh(reader._filename_handler(shape.mesh.filename))
            )
            if collision.origin is not None:
                solid.apply_transform(collision.origin)
            weights = random.dirichlet(np.ones(3), (len(solid.faces), 12))
            inner = np.einsum("fkc,fcd->fkd", weights, solid.triangles).reshape(-1, 3)
            points += [np.asarray(solid.vertices), inner]
        found[link.name] = np.concatenate(points)
    return found


def postures(model: pin.Model, count: int, seed: int = 7) -> Array:
    """Random postures (count, n) between the stops."""
    return np.random.default_rng(seed).uniform(
        model.lowerPositionLimit, model.upperPositionLimit, (count, model.nq)
    )


def outside(
    name: RobotName, points: dict[str, Array], q: Array, slimmer: dict[str, float] | None = None
) -> float:
    """Largest distance of the links' points outside the union of the capsules at q, some made slimmer [m]."""
    arm = robot(name)
    data = arm.model.createData()
    pin.forwardKinematics(arm.model, data, q)
    poses = link_poses(name, q)
    world = np.vstack([cloud @ poses[link][:3, :3].T + poses[link][:3, 3] for link, cloud in points.items()])
    return float(
        np.min([away(capsule, data, world, slimmer or {}) for capsule in arm.capsules], axis=0).max()
    )


def away(capsule, data: pin.Data, world: Array, slimmer: dict[str, float]) -> Array:
    """Distances of points (k, 3) of the room outside a capsule, made slimmer by its name [m]."""
    pose = data.oMi[capsule.joint]
    points = (world - pose.translation) @ pose.rotation
    return beyond(points, capsule.start, capsule.end, capsule.radius) + slimmer.get(capsule.name, 0.0)


def assert_they_keep_clear(pair: str, rig: str) -> None:
    """For 5 s d ≥ d_law ≥ d_m; the start is clearly farther apart, away from stops and singularities."""
    settings = validate(replace(RunSettings(), robot=pair, rig=rig, dt=0.01))
    simulation = Simulation(settings, 1)
    start, model = simulation.positions.copy(), simulation.room.model
    assert simulation.sample().distance > 1.2 * settings.law.critical_distance
    assert np.minimum(start - model.lowerPositionLimit, model.upperPositionLimit - start).min() > np.radians(
        14
    )
    for arm in simulation.room.arms:
        assert np.linalg.svd(simulation.kinematics.hand_jacobian(arm, 3), compute_uv=False)[-1] > 0.1
    table = run(settings, 5.0).table
    assert (column(table, "d") >= column(table, "law_d") - 1e-9).all()
    assert column(table, "law_d").min() >= settings.law.critical_distance
