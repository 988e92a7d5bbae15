"""The hold experiment in mink (MuJoCo and a QP): `FrameTask` and `CollisionAvoidanceLimit`, on a MuJoCo model made of ours.

Settings: gain K dt of the task, costs 1 per metre and per radian, damping 1e-3 as in mink's examples, pairs from 2 d_m on, joint stops as
ours. `CollisionAvoidanceLimit` bounds the displacement of a step by gain · (d − d_m) / dt, so that its documented range of gains, (0, 1],
lets two bodies come closer than d_m within one step; `matched_gain` means 10/s. Below d_m it asks for no retreat.
"""

from typing import Any, Final

import mink
import mujoco
import numpy as np
import pinocchio as pin
from mink.exceptions import NoSolutionFound

from app.bench.peer_hold import PEER_GAIN, Baked, GivenMotion, PeerArm
from controllers.kinematics import Array

SOLVER: Final = "daqp"
DAMPING: Final = 1e-3
FAR: Final = 100.0
"""Larger than any distance [m]."""


def matched_gain(dt: float) -> float:
    """Return the gain of mink's collision limit that means `PEER_GAIN` [1/s]."""
    return PEER_GAIN * dt * dt


def mujoco_model(baked: Baked) -> mujoco.MjModel:
    """Return our model as MuJoCo's: the same joints, the same capsules under the same names, the avoiding hand as the site "hand"."""
    room = baked.room
    model = room.model
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    bodies: list[Any] = [spec.worldbody]
    axes = _axes(model)
    for i in range(1, model.njoints):
        placement = model.jointPlacements[i]
        body = bodies[model.parents[i]].add_body(name=f"body {model.names[i]}", pos=placement.translation, quat=_wxyz(placement))
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        column = model.joints[i].idx_v
        free = baked.guided.start <= column < baked.guided.stop
        body.add_joint(
            name=model.names[i],
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=axes[i],
            limited=not free,
            range=(model.lowerPositionLimit[column], model.upperPositionLimit[column]),
        )
        bodies.append(body)
    for capsule in room.geometry.geometryObjects:
        shape, placement = capsule.geometry, capsule.placement
        bodies[capsule.parentJoint].add_geom(
            name=capsule.name,
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=(shape.radius, shape.halfLength, 0.0),
            pos=placement.translation,
            quat=_wxyz(placement),
        )
    frame = model.frames[baked.hand]
    bodies[frame.parentJoint].add_site(name="hand", pos=frame.placement.translation, quat=_wxyz(frame.placement))
    return spec.compile()


def _wxyz(placement: pin.SE3) -> Array:
    quaternion = pin.Quaternion(placement.rotation)
    return np.array([quaternion.w, quaternion.x, quaternion.y, quaternion.z])


def _axes(model: pin.Model) -> list[Array]:
    """Return the axis (3,) of every joint in its own frame, whatever kind of revolute joint it is; of the world's, nothing."""
    data = model.createData()
    pin.forwardKinematics(model, data, np.ones(model.nq))
    return [pin.log3((model.jointPlacements[i].actInv(data.liMi[i])).rotation) for i in range(model.njoints)]


class MinkGivenMotion(GivenMotion, mink.Task):
    """The guided arm's motion for mink."""


class MinkArm(PeerArm):
    """The avoiding arm moved by mink. `gain`: of `CollisionAvoidanceLimit`."""

    def __init__(self, baked: Baked, gain: float) -> None:
        settings, room = baked.settings, baked.room
        model = mujoco_model(baked)
        motion = MinkGivenMotion(baked.guided, model.nv, cost=np.ones(baked.guided.stop - baked.guided.start))
        super().__init__(baked, mink.Configuration(model, room.start), motion, NoSolutionFound)
        self._task = mink.FrameTask("hand", "site", position_cost=1.0, orientation_cost=1.0, gain=settings.gain * settings.dt)
        self._task.set_target_from_configuration(self._configuration)
        names = room.model.names
        speeds = {
            names[i]: float(room.model.velocityLimit[joint.idx_v])
            for i, joint in enumerate(room.model.joints)
            if i and baked.avoiding.start <= joint.idx_v < baked.avoiding.stop
        }
        self.limit = collision_limit(baked, model, gain, 2.0 * settings.law.critical_distance)
        self._limits = [
            mink.ConfigurationLimit(model, gain=settings.limit_gain * settings.dt),
            mink.VelocityLimit(model, speeds),
            self.limit,
        ]

    def solve(self) -> Array:
        posture, tasks, given = self._configuration, [self._task], self.constraints
        return mink.solve_ik(posture, tasks, self._dt, SOLVER, damping=DAMPING, limits=self._limits, constraints=given)


def collision_limit(baked: Baked, model: mujoco.MjModel, gain: float, reach: float) -> mink.CollisionAvoidanceLimit:
    """Return mink's limit for our pairs. `gain`: see the head of this file; `reach`: distance from which pairs are looked at [m]."""
    bodies = baked.room.geometry.geometryObjects
    pairs = [([bodies[pair.first].name], [bodies[pair.second].name]) for pair in baked.room.geometry.collisionPairs]
    return mink.CollisionAvoidanceLimit(
        model,
        pairs,
        gain=gain,
        minimum_distance_from_collisions=baked.settings.law.critical_distance,
        collision_detection_distance=reach,
    )


class MinkEngine:
    """An `Engine`: distances as mink and MuJoCo see them, of the pairs that mink has kept."""

    def __init__(self, baked: Baked) -> None:
        self._model = mujoco_model(baked)
        self._configuration = mink.Configuration(self._model)
        self._pairs = collision_limit(baked, self._model, 0.5, FAR).geom_id_pairs
        bodies = baked.room.geometry.geometryObjects
        ours = [(bodies[pair.first].name, bodies[pair.second].name) for pair in baked.room.geometry.collisionPairs]
        self._ours = {frozenset(pair): pair for pair in ours}

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        self._configuration.update(positions)
        model, data, ends = self._model, self._configuration.data, np.empty(6)
        found: dict[tuple[str, str], float] = {}
        for pair in self._pairs:
            found[self._ours[frozenset(model.geom(i).name for i in pair)]] = mujoco.mj_geomDistance(model, data, *pair, FAR, ends)
        return found

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._configuration.update(positions)
        site = self._configuration.data.site("hand")
        return site.xpos.copy(), site.xmat.reshape(3, 3).copy()
