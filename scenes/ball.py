"""A ball in the way (Fig. 1) of a hand that moves from A to B and back."""

from functools import cache
from typing import Final

import coal
import numpy as np
import pinocchio as pin

from controllers.kinematics import Arm, Array
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.arm_tasks.hold_task import HoldTask
from scenes.guide import FOLLOW_GAIN, SMOOTHING_TIME, shortened
from scenes.rigs import ALONE
from scenes.robots import robot
from scenes.roles import NO_TARGETS, Roles, Scenario, Scripted, TargetSource
from scenes.room import Room, World, pair_bodies, with_arm
from scenes.setting_spec import makes
from scenes.settings import ControlPoint, RunSettings
from scenes.solo import ALONE_NAME, alone_start
from scenes.targets import BallTarget, Target, quintic

BALL_RADIUS: Final = 0.08
"""[m]"""

POINT_RADIUS: Final = 0.05
"""Sphere about a control point [m]."""

PATH: Final = np.array([0.0, 0.64, 0.0])
"""From A to B (3,) [m]."""

PATH_TURN: Final = -0.60
"""Turn of the first joint from its usual start [rad]."""

PATH_CLEARANCE: Final = 0.03
"""Clearance of the control point on the undisturbed path [m]."""

BALL_ROOM: Final = 2.5
"""Limit of position along each world axis, ± [m]."""

BALL_SPEED: Final = 1.5
"""Limit along each axis [m/s]."""

TRAVEL: Final = 5.0
"""Time from A to B [s]."""

REST: Final = 1.5
"""[s]"""

SWING: Final = 0.25
"""Amplitude [m]."""


def path(time: float, home: Array) -> tuple[Array, Array]:
    """Desired position (3,) [m] and velocity (3,) [m/s] of the hand: quintics from A (home) to B and back."""
    period = TRAVEL + REST
    leg, t = divmod(max(time - REST, 0.0), period)
    share, rate = quintic(min(t / TRAVEL, 1.0))
    back = int(leg) % 2 == 1
    return home + PATH * (1.0 - share if back else share), PATH * ((-rate if back else rate) / TRAVEL)


@cache
def build_ball_room(robot_name: str = "lwr", point: ControlPoint = "hand") -> Room:
    """Room of one arm and a ball that moves by three joints."""
    made, geometry = robot(robot_name), pin.GeometryModel()
    model, arm = with_arm(pin.Model(), geometry, made, ALONE_NAME, ALONE.bases[0])
    start = alone_start(robot_name)
    start[0] += PATH_TURN
    first = model.nv
    bound = np.full(3, BALL_ROOM)
    joint = model.addJoint(
        0,
        pin.JointModelTranslation(),
        pin.SE3.Identity(),
        "ball",
        np.zeros(3),
        np.full(3, BALL_SPEED),
        -bound,
        bound,
    )
    geometry.addGeometryObject(
        pin.GeometryObject("ball", joint, pin.SE3.Identity(), coal.Sphere(BALL_RADIUS))
    )
    if point == "arm":
        # The pedestal cannot move.
        pair_bodies(model, geometry, f"{ALONE_NAME} ", "ball", movable=True)
    else:
        hand = model.frames[arm.hand]
        carrier, place = (
            (arm.elbow, pin.SE3.Identity()) if point == "elbow" else (hand.parentJoint, hand.placement)
        )
        shape = pin.GeometryObject(f"control point at the {point}", carrier, place, coal.Sphere(POINT_RADIUS))
        geometry.addCollisionPair(
            pin.CollisionPair(geometry.addGeometryObject(shape), geometry.getGeometryId("ball"))
        )
    ball_start = _beside_the_path(model, arm, start, point)
    whole = np.concatenate([start, ball_start])
    return Room(ALONE, (made,), model, geometry, (arm,), whole, slice(first, first + 3), point)


def _beside_the_path(model: pin.Model, arm: Arm, start: Array, point: ControlPoint) -> Array:
    """Start of the ball (3,) [m]."""
    data = model.createData()
    aside = BALL_RADIUS + POINT_RADIUS + PATH_CLEARANCE
    q = np.concatenate([start, np.zeros(3)])
    if point == "elbow":
        ways: list[Array] = []
        for turn in (0.0, -2.0 * PATH_TURN):
            q[0] = start[0] + turn
            pin.forwardKinematics(model, data, q)
            ways.append(data.oMi[arm.elbow].translation.copy())
        way = ways[1] - ways[0]
        # The elbow itself would not go all the way.
        return ways[1] + way * ((aside - 0.05) / float(np.linalg.norm(way)))
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[arm.hand].translation + PATH / 2.0 - np.array([0.0, 0.0, aside])


class BallInTheWay(Scenario):
    """The visitor moves the ball, or it swings by itself."""

    def room(self, settings: RunSettings) -> Room:
        return build_ball_room(makes(settings.robot)[0], settings.point)

    def roles(self, world: World, settings: RunSettings) -> Roles:
        del settings
        arm = world.room.arms[0]
        keeper, ball = HoldTask(world, arm, path), BallTask(world)
        return Roles((ball, keeper), arm, arm, keeper, None, (keeper,))

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        if settings.ball == "still":
            return NO_TARGETS
        assert world.room.ball is not None
        return ball_swing(world.room.start[world.room.ball], settings.seed)

    def way(self, settings: RunSettings, home: Array) -> Array:
        return np.array([home, home + PATH])


def ball_swing(middle: Array, seed: int) -> Scripted:
    """Target that swings the ball across the path about `middle` (3,) [m]; `seed` sets the period."""
    period = float(np.random.default_rng(seed).uniform(7.0, 11.0))
    return Scripted(
        lambda time: BallTarget(middle + np.array([SWING * np.sin(2.0 * np.pi * time / period), 0.0, 0.0]))
    )


class BallTask(ArmTask):
    """Moves the ball to its target, at most at a person's speed."""

    def __init__(self, world: World) -> None:
        columns = world.room.ball
        assert columns is not None
        self.joints = columns
        self._positions = world.positions[columns]
        self._box = world.bounds.part(columns)
        self._velocities = np.zeros(3)

    def begin(self) -> None:
        self._velocities[:] = 0.0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """The ball's velocity (3,) [m/s]; the array is reused."""
        del time
        wanted: Array | float = 0.0
        if isinstance(target, BallTarget):
            wanted = shortened((target.position - self._positions) * FOLLOW_GAIN, settings.hand_speed)
        v = self._velocities
        v += (wanted - v) * (settings.dt / (SMOOTHING_TIME + settings.dt))
        v[:] = self._box.clip(v)
        return v

    def memory(self) -> Memory:
        return (self._velocities.copy(),)

    def remember(self, memory: Memory) -> None:
        self._velocities[:] = memory[0]
