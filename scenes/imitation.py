"""Imitation (Figs 7, 8): a person drives both robots by four angles per arm."""

from dataclasses import replace
from functools import cache
from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array
from scenes.arm_tasks.arm_task import Memory
from scenes.arm_tasks.follow_task import JointFollower
from scenes.person.clips import REST, Clip
from scenes.person.retarget import DRIVEN, AngleFilter, Retargeter
from scenes.person.source import PersonTarget
from scenes.rigs import FIELD_OF_VIEW, Camera
from scenes.roles import Roles, Scenario, TargetSource
from scenes.room import SIDES, Room, World, build_room
from scenes.settings import RunSettings
from scenes.targets import AnglesTarget, Target

CAMERA: Final = Camera((0.30, -0.24, 1.09), (2.45, -0.45, 0.69), 2.56, 1.34, FIELD_OF_VIEW)
"""Shows raised arms, and a person with outstretched arms beside them."""


@cache
def build_imitation_room() -> Room:
    """The torso with two LWRs, elbows at the sides; no other room or robot fits a person."""
    room = build_room("torso")
    start = room.start.copy()
    for arm, joints in zip(room.arms, Retargeter(room.rig).joints(REST), strict=True):
        start[arm.joints.start : arm.joints.start + DRIVEN] = joints
    return replace(room, start=start, rig=replace(room.rig, camera=CAMERA))


class Imitation(Scenario):
    def room(self, settings: RunSettings) -> Room:
        return build_imitation_room()

    def roles(self, world: World, settings: RunSettings) -> Roles:
        room = world.room
        imitated = ImitatedPerson(world)
        followers = {side: ImitatedArm(world, room.arm(side), imitated) for side in SIDES}
        # Neither arm is the person's own; the right one takes that role here.
        task, held = followers["left"], followers["right"]
        return Roles((task, held), room.arm("right"), room.arm("left"), task, held, (task, held))

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        return PersonTarget(Clip(settings.clip, settings.seed))


class ImitatedPerson:
    def __init__(self, world: World) -> None:
        start = np.array([world.room.start[arm.joints] for arm in world.room.arms])
        self._start = start
        self._retargeter = Retargeter(world.room.rig)
        # Two in series, so that no input makes the desired velocity jump.
        self._filters = AngleFilter(start[:, :DRIVEN]), AngleFilter(start[:, :DRIVEN])
        self._time = -1.0
        self.desired: Array = start.copy()
        """q_d of both arms (2, n) [rad]."""
        self.speed: Array = np.zeros_like(start)
        """Their velocities (2, n) [rad/s]."""

    def begin(self) -> None:
        self._retargeter.reset(self._start[:, :DRIVEN])
        for stage in self._filters:
            stage.reset(self._start[:, :DRIVEN])
        self.desired[:] = self._start
        self.speed[:] = 0.0
        self._time = -1.0

    def update(self, target: Target | None, settings: RunSettings, time: float) -> None:
        """Read the person's angles, at most once per tick."""
        if time == self._time:
            return
        self._time = time
        angles = target.angles if isinstance(target, AnglesTarget) else None
        seen = None if angles is None else self._retargeter.joints(angles)
        first, second = self._filters
        self.desired[:, :DRIVEN] = second.step(first.step(seen, settings.dt), settings.dt)
        self.speed[:, :DRIVEN] = second.rates

    def memory(self) -> Memory:
        first, second = self._filters
        return (
            self.desired.copy(),
            self.speed.copy(),
            *first.memory(),
            *second.memory(),
            *self._retargeter.memory(),
        )

    def remember(self, memory: Memory) -> None:
        self.desired[:], self.speed[:] = memory[:2]
        for stage, kept in zip(self._filters, (memory[2:6], memory[6:10]), strict=True):
            stage.remember(kept)
        self._retargeter.remember(memory[10:])
        self._time = -1.0


class ImitatedArm(JointFollower):
    def __init__(self, world: World, arm: Arm, person: ImitatedPerson) -> None:
        super().__init__(world, arm)
        self._person, self._side = person, SIDES.index(arm.name)

    def begin(self) -> None:
        """The person starts in the room's posture."""
        super().begin()
        self._person.begin()

    def wanted(self, target: Target | None, settings: RunSettings, time: float) -> tuple[Array, Array]:
        self._person.update(target, settings, time)
        return self._person.desired[self._side].copy(), self._person.speed[self._side]

    def memory(self) -> Memory:
        return self._person.memory()

    def remember(self, memory: Memory) -> None:
        self._person.remember(memory)
