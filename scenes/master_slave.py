"""Master and slave (Fig. 6): a person moves one arm, the other follows its joints, and they keep clear of each other."""

import numpy as np
import pinocchio as pin

from scenes.arm_tasks.follow_task import JointFollower, Master
from scenes.arm_tasks.guided_task import GuidedTask
from scenes.robots import Robot
from scenes.roles import Roles, mirror_signs
from scenes.settings import RunSettings
from scenes.world import World


def roles(world: World, settings: RunSettings) -> Roles:
    """Return the roles."""
    room = world.room
    master, slave = room.arm(settings.guided), room.other(settings.guided)
    made = room.robots[room.arms.index(master)]
    held = GuidedTask(world, master, made)
    follower = JointFollower(world, slave, Master(world, master, slave, mirror_signs(_axes(made))))
    return Roles((held, follower), master, slave, follower, held, (follower, held))


def _axes(robot: Robot) -> np.ndarray:
    data = robot.model.createData()
    return pin.computeJointJacobians(robot.model, data, pin.neutral(robot.model))[3:].copy()
