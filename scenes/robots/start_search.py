"""Start postures of arms, far from singular postures and stops."""

from functools import cache
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array
from scenes.rigs import RIGS
from scenes.robots import robot
from scenes.robots.description import Robot
from scenes.robots.example_data import EXAMPLES
from scenes.settings import ArmName

SAMPLES: Final = 1500

KEPT: Final = 12

IMPROVEMENTS: Final = 25

STOP: Final = np.radians(17.0)
"""Least angle from every stop [rad]."""


def start_posture(robot_name: str, rig_name: str, side: ArmName) -> Array | None:
    """Known start q (n,) [rad] of an arm, a copy, or None."""
    if robot_name == "lwr" and rig_name in RIGS:
        return RIGS[rig_name].starts[side == "right"].copy()
    if robot_name not in EXAMPLES or rig_name not in RIGS:
        return None
    return np.radians(EXAMPLES[robot_name].starts[rig_name][side == "right"])


def found_postures(made: Robot, base: pin.SE3, other: pin.SE3, side: ArmName, rig_name: str) -> list[Array]:
    """Start postures q (n,) [rad], the best first; only the known one, if any.

    Args:
        base, other: poses of both bases, world; equal for a single arm.
    """
    known = start_posture(made.key, rig_name, side)
    if known is not None:
        return [known]
    away = other.translation - base.translation
    return [q.copy() for q in _searched(made.key, base.homogeneous.tobytes(), _goal(made, base, away, side))]


def arm_reach(made: Robot) -> float:
    """Length along the joints from shoulder to hand [m]."""
    model = made.model
    hand = model.frames[model.getFrameId(made.hand)].placement.translation
    ways = (
        float(np.linalg.norm(model.jointPlacements[j].translation))
        for j in range(made.shoulder + 1, model.njoints)
    )
    return sum(ways) + float(np.linalg.norm(hand))


def _goal(made: Robot, base: pin.SE3, away: Array, side: ArmName) -> tuple[float, float, float]:
    """Goal of the hand, world [m]."""
    reach = arm_reach(made)
    distance = float(np.linalg.norm(away[:2]))
    out = 1.0 if side == "left" else -1.0
    if base.rotation[2, 2] < 0.9:
        ahead = np.array([0.62, 0.36 * out, 0.12]) * reach
    elif distance > 0.3 and float(base.rotation[:, 0] @ away) > 0.5 * distance:
        # Face to face.
        ahead = away / distance * min(0.45 * reach, 0.27 * distance)
        ahead[2] = 0.62 * reach
    else:
        ahead = base.rotation[:, 0] * 0.5 * reach
        ahead[2] = 0.5 * reach
    x, y, z = (base.translation + ahead).tolist()
    return x, y, z


@cache
def _searched(key: str, place: bytes, goal: tuple[float, float, float]) -> tuple[Array, ...]:
    """Random search, always the same. `place`: pose of the base (4, 4) as bytes."""
    made = robot(key)
    model, data, base = made.model, made.model.createData(), pin.SE3(np.frombuffer(place).reshape(4, 4))
    low, high = model.lowerPositionLimit + STOP, model.upperPositionLimit - STOP
    narrow = high < low
    low, high = np.where(narrow, (low + high) / 2.0, low), np.where(narrow, (low + high) / 2.0, high)
    low, high = np.maximum(low, -np.pi), np.minimum(high, np.pi)
    hand, target = model.getFrameId(made.hand), base.actInv(np.array(goal))
    frame = pin.LOCAL_WORLD_ALIGNED
    reach = arm_reach(made)

    def value(q: Array) -> float:
        J = pin.computeFrameJacobian(model, data, q, hand, frame)[:3]
        pin.framesForwardKinematics(model, data, q)
        point = data.oMf[hand].translation
        heights = [float(base.act(data.oMi[j].translation)[2]) for j in range(made.shoulder, model.njoints)]
        shoulder, elbow, wrist = (data.oMi[j].translation for j in (made.shoulder, made.elbow, made.wrist))
        bent = float(np.linalg.norm(elbow - shoulder)) + float(np.linalg.norm(wrist - elbow))
        straight = float(np.linalg.norm(wrist - shoulder)) / max(bent, 1e-9)
        # Its own foot, which the law does not know.
        near = min(float(np.linalg.norm(wrist[:2])), float(np.linalg.norm(point[:2])))
        score = -6.0 * float(np.linalg.norm(point - target)) / reach
        score += 3.0 * float(np.linalg.svd(J, compute_uv=False)[2]) / reach
        score -= 4.0 * max(0.0, straight - 0.9) + 8.0 * max(0.0, 0.22 - near)
        score -= 8.0 * max(0.0, float(base.translation[2]) + 0.08 - min(heights))
        score += 0.6 * min(float(base.act(elbow)[2]) - float(base.translation[2]), 0.6)
        return score - 0.05 * float(np.abs(q).mean())

    random = np.random.default_rng(5)
    samples = random.uniform(low, high, (SAMPLES, model.nq))
    best = sorted(samples, key=value, reverse=True)[: 4 * KEPT]
    improved: list[Array] = []
    for start in best:
        q = start.copy()
        for _ in range(IMPROVEMENTS):
            J = pin.computeFrameJacobian(model, data, q, hand, frame)[:3]
            pin.framesForwardKinematics(model, data, q)
            error = target - data.oMf[hand].translation
            step = J.T @ np.linalg.solve(J @ J.T + 0.01 * np.eye(3), error)
            q = np.clip(q + step, low, high)
        improved.append(np.round(q, 3))
    return tuple(sorted(improved, key=value, reverse=True)[:KEPT])
