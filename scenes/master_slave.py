"""Master and slave (Fig. 6): a person moves one arm, the other follows its joints, and they keep clear of each other."""

import numpy as np
import pinocchio as pin

from scenes.autopilot import Autopilot
from scenes.cast import Cast, Person, mirror_signs
from scenes.movers.follower import JointFollower, Master
from scenes.movers.guided import GuidedArm
from scenes.robots import Robot
from scenes.settings import RunSettings
from scenes.world import World


def cast(world: World, settings: RunSettings) -> Cast:
    """Return who takes part."""
    room = world.room
    master, slave = room.arm(settings.guided), room.other(settings.guided)
    made = room.robots[0]
    held = GuidedArm(world, master, made)
    follower = JointFollower(world, slave, Master(world, master, slave, mirror_signs(_axes(made))))
    return Cast((held, follower), master, slave, follower, held, (follower, held))


def person(world: World, settings: RunSettings) -> Person:
    """Return who moves the master by itself, beginning where its hand is."""
    start = world.kinematics.hand_pose(world.room.arm(settings.guided)).translation.copy()
    return Autopilot(world.room, settings.guided, settings.seed, start)


def _axes(robot: Robot) -> np.ndarray:
    data = robot.model.createData()
    return pin.computeJointJacobians(robot.model, data, pin.neutral(robot.model))[3:].copy()
