"""Who moves what can be moved in a run: a person's hand on the page, the experiment's own person, or a guest."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.roles import TargetSource
from scenes.room import BALL_ROOM
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import BallTarget, HandTarget, Target

LONGEST_REACH: Final = 0.3
"""A key held down runs no further ahead of what it moves [m]."""


class InputSource:
    """Who moves.

    Attributes:
        held: what a person holds, and where; None while nobody touches anything. Goes before everybody else.
    """

    def __init__(self) -> None:
        self.held: Target | None = None
        self._guest: TargetSource | None = None
        self._person: TargetSource | None = None
        self._begin = 0.0

    def invite(self, guest: TargetSource | None) -> None:
        """Let somebody else than the experiment's own person move; None for the own one again."""
        self._guest, self._person, self.held = guest, None, None

    def begin_anew(self) -> None:
        """Have whoever stands in for a person begin from the beginning; nobody holds anything."""
        self._person = self.held = None

    def restart(self) -> None:
        """Have whoever stands in for a person begin from the beginning."""
        self._person = None

    def target(self, simulation: Simulation, autopilot: bool) -> Target | None:
        """Return what whoever moves wants now; None if nobody moves. `autopilot`: whether somebody stands in for a person."""
        if self.held is not None:
            return self.held
        if not autopilot:
            return None
        if self._person is None:
            self._person = self._guest or simulation.source()
            self._begin = simulation.time
        return self._person.target(simulation.time - self._begin)


def nudged(simulation: Simulation, held: Target | None, way: Array) -> Target | None:
    """Return what a person holds after a nudge of the hand, or of the ball; None where there is neither.

    Args:
        simulation: the run.
        held: what they hold now.
        way: (3,) by how much [m], world.
    """
    if simulation.settings.scene == "imitation":
        # A person's own arms cannot be nudged.
        return None
    if simulation.room.ball is not None:
        ball = simulation.positions[simulation.room.ball].copy()
        place = ahead(held.position if isinstance(held, BallTarget) else ball, way, ball)
        return BallTarget(np.clip(place, -BALL_ROOM, BALL_ROOM))
    pose = simulation.kinematics.hand_pose(simulation.guided)
    if not isinstance(held, HandTarget):
        held = HandTarget(pose.translation.copy(), pose.rotation.copy())
    return HandTarget(ahead(held.position, way, pose.translation), held.rotation)


def ahead(place: Array, way: Array, here: Array) -> Array:
    """Return a place (3,) moved by a way (3,), but no further from here (3,) than `LONGEST_REACH` along each axis [m]."""
    return np.clip(place + way, here - LONGEST_REACH, here + LONGEST_REACH)


def who(run: RunSettings) -> tuple[object, ...]:
    """Return what decides on who moves what in a run: another one of these is another person."""
    return (run.scene, run.rig, run.robot, run.guided, run.path, run.point, run.ball, run.clip, run.seed)
