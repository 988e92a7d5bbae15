"""Target of a run, from the visitor's hand, a chosen source, or the experiment."""

from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array
from scenes.ball import BALL_ROOM
from scenes.opening import Opening
from scenes.roles import TargetSource
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import BallTarget, HandTarget, JointTarget, Target

LONGEST_REACH: Final = 0.3
"""Longest lead of a held key over what it moves [m]."""


WAY_STEP: Final = 0.5
"""Time between two points of the coming path [s]."""


class InputSource:
    """Gives a run its target, step by step.

    Attributes:
        held: target that the visitor holds, or None; it overrides every source.
        opens: True if a new run begins with `Scenario.opening`.
    """

    def __init__(self) -> None:
        self.opens = False
        self.held: Target | None = None
        self._chosen: TargetSource | None = None
        self._active: TargetSource | None = None
        self._begin, self._start = 0.0, np.empty(0)

    def set_source(self, source: TargetSource | None) -> None:
        """Choose a source, or None for the experiment's own; releases what is held."""
        self._chosen, self._active, self.held = source, None, None

    def restart(self) -> None:
        self._active = None

    def let_go(self) -> None:
        """Release what is held, and restart the source."""
        self.held = self._active = None

    @property
    def began(self) -> tuple[float, Array] | None:
        """Start of the active source [s], and q (nv,) then; None without one."""
        return None if self._active is None else (self._begin, self._start)

    @property
    def opening(self) -> bool:
        return isinstance(self._active, Opening)

    def resume(
        self, simulation: Simulation, began: tuple[float, Array] | None, opening: bool = False
    ) -> None:
        """Continue with an earlier source; resets the simulation to its start, because it may depend on q."""
        if began is None:
            return
        self._begin, self._start = began
        simulation.reset(self._start)
        self._active = self._chosen or self._own(simulation, opening)

    def target(self, simulation: Simulation, autopilot: bool) -> Target | None:
        """The active source's target, or None. `autopilot`: a source replaces the visitor."""
        if self.held is not None:
            return self.held
        if not autopilot:
            return None
        if self._active is None:
            self._active = self._chosen or self._own(simulation, self._begins_with_opening(simulation))
            self._begin, self._start = simulation.time, simulation.positions.copy()
        return self._active.target(simulation.time - self._begin)

    def _begins_with_opening(self, simulation: Simulation) -> bool:
        return self.opens and simulation.steps == 0

    def _own(self, simulation: Simulation, opening: bool) -> TargetSource:
        return (simulation.opening() if opening else None) or simulation.source()

    def way(self, simulation: Simulation, autopilot: bool, seconds: float) -> Array:
        """Places in the next seconds (k, 3) [m], by the source or else by the experiment's own one; (0, 3)
        if unknown."""
        # A person's angles are not known in advance, and are not positions.
        if self.held is not None or simulation.settings.experiment.moves == "person":
            return np.zeros((0, 3))
        source = (autopilot and (self._active or self._chosen)) or self._own(
            simulation, self._begins_with_opening(simulation)
        )
        begin = simulation.time - self._begin if source is self._active else 0.0
        wanted = [source.target(begin + ahead) for ahead in np.arange(0.0, seconds, WAY_STEP)]
        return np.array(
            [one.position for one in wanted if isinstance(one, (HandTarget, BallTarget))]
        ).reshape(-1, 3)


def nudged(simulation: Simulation, arm: Arm, held: Target | None, way: Array) -> Target | None:
    """Target after a nudge of the hand or the ball by `way` (3,) [m], world; None if a person is imitated."""
    if simulation.settings.experiment.moves == "person":
        # A person's own arms cannot be nudged.
        return None
    if simulation.room.ball is not None:
        ball = simulation.positions[simulation.room.ball].copy()
        place = ahead(held.position if isinstance(held, BallTarget) else ball, way, ball)
        return BallTarget(np.clip(place, -BALL_ROOM, BALL_ROOM))
    pose = simulation.kinematics.hand_pose(arm)
    if not isinstance(held, HandTarget):
        held = HandTarget(pose.translation.copy(), pose.rotation.copy())
    return HandTarget(ahead(held.position, way, pose.translation), held.rotation)


def with_joint(simulation: Simulation, held: Target | None, joint: int, angle: float) -> JointTarget | None:
    """Target after a move of joint `joint` (from 0) to `angle` [rad], clipped to its limits; None without
    a slave or such a joint."""
    model, columns = simulation.room.model, simulation.guided.joints
    if simulation.settings.experiment.follows != "arm" or joint >= columns.stop - columns.start:
        return None
    wanted = held.positions.copy() if isinstance(held, JointTarget) else simulation.positions[columns].copy()
    wanted[joint] = np.clip(
        angle, model.lowerPositionLimit[columns][joint], model.upperPositionLimit[columns][joint]
    )
    return JointTarget(wanted)


def ahead(place: Array, way: Array, here: Array) -> Array:
    """Place moved by `way`, at most `LONGEST_REACH` from `here` along each axis; all (3,) [m]."""
    return np.clip(place + way, here - LONGEST_REACH, here + LONGEST_REACH)


def source_settings(run: RunSettings) -> tuple[object, ...]:
    """Settings whose change restarts the experiment's own source."""
    return (
        run.scene,
        run.rig,
        run.robot,
        run.guided,
        run.path,
        run.point,
        run.ball,
        run.clip,
        run.seed,
        run.first,
        run.load,
        run.together,
    )
