"""The arms there are: the paper's own, two that come with the package example-robot-data, and those from files given at the start."""

from functools import cache
from typing import get_args

import numpy as np
import pinocchio as pin

from controllers.errors import BadSetting
from scenes.given_choices import start_remedy
from scenes.lwr import facts
from scenes.lwr.urdf import FLANGE, URDF_FILE
from scenes.robots.description import Capsule, Robot
from scenes.robots.robot_files import FILES
from scenes.settings import RobotName

__all__ = ["FILES", "Capsule", "Robot", "RobotName", "robot"]


@cache
def robot(name: str) -> Robot:
    """Return a robot by its name, built once and shared: do not change it.

    Raises:
        BadSetting: there is no robot of that name, or what it needs is not installed.
    """
    if name == "lwr":
        capsules = tuple(
            Capsule(c.name, c.link, np.array([0.0, 0.0, c.start]), np.array([0.0, 0.0, c.end]), c.radius) for c in facts.CAPSULES
        )
        return Robot("lwr", "KUKA LWR 4+", pin.buildModelFromUrdf(str(URDF_FILE)), FLANGE, 2, 4, 6, capsules, facts.JOINT_LABELS)
    if name in FILES:
        from scenes.robots.stored import stored_file

        return stored_file(name)
    if name not in get_args(RobotName):
        if remedy := start_remedy(name):
            raise BadSetting(remedy)
        raise BadSetting("There is no robot {name!r}; choose from {known}.", name=name, known=", ".join(get_args(RobotName)))
    from scenes.robots.stored import stored_example

    return stored_example(name)
