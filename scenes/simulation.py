"""Scene, law and a fixed time step: inputs → joint velocities → joint positions, one tick at a time, always the same bits."""

from dataclasses import replace
from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array, Kinematics
from controllers.laws.situation import Law, Situation, row_damping
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.unprotected import Unprotected
from controllers.limits import Authority, Bounded, VelocityBox, bounded_row
from controllers.proximity import ProximityDetector
from controllers.tasks import hold, pose_error
from scenes.guide import Guide, HandTarget
from scenes.history import History, Sample
from scenes.room import Room, build_room
from scenes.settings import LawSettings, RunSettings

HISTORY: Final = 16_000
"""Steps kept by default: 20 s at the smallest time step."""


def make_law(settings: LawSettings) -> Law:
    """Return the law that the settings describe."""
    if settings.law == "unprotected":
        return Unprotected()
    return SmoothPriority(
        settings.critical_distance, settings.order, settings.nominal_velocity, settings.feed_forward, settings.one_sided
    )


class Simulation:
    """The hold experiment (Fig. 5): a person moves one arm, the other keeps its hand in place and gets out of the way.

    Args:
        settings: of the run; already checked.
        capacity: steps that the history keeps.
    """

    def __init__(self, settings: RunSettings, capacity: int = HISTORY) -> None:
        self.settings = settings
        self.room: Room = build_room(settings.rig)
        self.history = History(capacity, self.room.model.nv)
        self._enter(self.room)
        self.apply(settings)
        self.reset()

    def _enter(self, room: Room) -> None:
        self.room = room
        self.kinematics = Kinematics(room.model, room.arms)
        self.detector = ProximityDetector(self.kinematics, room.geometry)
        nv = room.model.nv
        self.positions: Array = room.start.copy()
        self.velocities: Array = np.zeros(nv)
        self._step_of_positions = np.zeros(nv)
        gain = self.settings.limit_gain
        lower, upper, speed = room.model.lowerPositionLimit, room.model.upperPositionLimit, room.model.velocityLimit
        self._boxes = {
            arm.name: VelocityBox(lower[arm.joints].copy(), upper[arm.joints].copy(), speed[arm.joints].copy(), gain)
            for arm in room.arms
        }
        self._guides = {
            arm.name: Guide(self.kinematics, arm, robot, self._boxes[arm.name], room.start[arm.joints])
            for arm, robot in zip(room.arms, room.robots, strict=True)
        }

    @property
    def guided(self) -> Arm:
        """The arm that the person moves."""
        return self.room.arm(self.settings.guided)

    @property
    def avoiding(self) -> Arm:
        """The arm that keeps its place and keeps clear."""
        return self.room.other(self.settings.guided)

    def apply(self, settings: RunSettings) -> None:
        """Change the settings from the next step on. The arms stay where they are, unless they are put on another rig."""
        before = self.settings
        self.settings = settings
        self.law = make_law(settings.law)
        for box in self._boxes.values():
            box.gain = settings.limit_gain
        if settings.rig != before.rig:
            self._enter(build_room(settings.rig))
            self.reset()
        elif settings.guided != before.guided:
            self._take_places()

    def reset(self, positions: Array | None = None) -> None:
        """Begin anew at time 0, at rest, in the rig's start posture or at q (nv,) [rad]. The settings stay."""
        self.positions[:] = self.room.start if positions is None else positions
        self.steps = 0
        self.time = 0.0
        self.bounded = Bounded(np.zeros(0))
        self.history.clear()
        self._take_places()

    def _take_places(self) -> None:
        """The avoiding hand's place is where it is now, and nobody moves."""
        self.velocities[:] = 0.0
        for guide in self._guides.values():
            guide.reset()
        self.kinematics.update(self.positions)
        pose = self.kinematics.hand_pose(self.avoiding)
        self.place: Array = pose.translation.copy()
        self.place_rotation: Array = pose.rotation.copy()

    def step(self, target: HandTarget | None) -> None:
        """Advance by dt. `target` is where the person wants the guided hand; None leaves the guided arm alone."""
        settings, kinematics = self.settings, self.kinematics
        q, dq = self.positions, self.velocities
        law_settings, guided, avoiding = settings.law, self.guided, self.avoiding
        kinematics.update(q)
        near = self.detector.detect(law_settings.pairs, law_settings.beta)

        dq_guided = self._guides[guided.name].follow(target, q[guided.joints], settings.dt, settings.hand_speed)
        law_approach = -float(near.row[guided.joints].dot(dq_guided))
        approach = law_approach if near.row is near.pair_row else -float(near.pair_row[guided.joints].dot(dq_guided))

        box = self._boxes[avoiding.name]
        q_avoiding, J_d = q[avoiding.joints], near.row[avoiding.joints]
        box.update(q_avoiding)
        error = pose_error(kinematics.hand_pose(avoiding), self.place, self.place_rotation)
        nominal = box.clip(hold(kinematics, avoiding, settings.task, error, settings.gain))
        situation = Situation(q_avoiding, nominal, J_d, near.law_distance, law_approach)
        wanted = self.law(situation)
        lam = self.law.activation(near.law_distance)
        self.bounded = bounded = self._bound(situation, wanted, box, lam)

        dq[guided.joints] = dq_guided
        dq[avoiding.joints] = bounded.velocities
        self.history.append(
            (
                self.time,
                near.distance,
                lam,
                float(error[:3].dot(error[:3])),
                situation.pull,
                approach,
                near.pair,
                near.law_distance,
                law_approach,
                float(error[3:].dot(error[3:])) ** 0.5,
                bounded.authority,
                bounded.joint,
            ),
            q,
            dq,
        )
        np.multiply(dq, settings.dt, out=self._step_of_positions)
        q += self._step_of_positions
        self.steps += 1
        self.time += settings.dt

    def _bound(self, situation: Situation, wanted: Array, box: VelocityBox, lam: float) -> Bounded:
        if not box.contains(wanted):
            return bounded_row(situation.nominal, situation.row, float(situation.row.dot(wanted)), box)
        square = float(situation.row.dot(situation.row))
        damping = row_damping(square)
        # Less than half of what the law asked for is left after damping: the arm has no lever against this approach.
        if damping > square and lam > 0.5:
            return Bounded(wanted, Authority.LEVERAGE)
        return Bounded(wanted)

    def sample(self) -> Sample:
        """Return the newest step; makes none if there is none yet, but measures the present state."""
        if self.history.count == 0:
            return self._measured()
        return self.history.last()

    def _measured(self) -> Sample:
        self.kinematics.update(self.positions)
        near = self.detector.detect(self.settings.law.pairs, self.settings.law.beta)
        lam = self.law.activation(near.law_distance)
        return Sample(
            self.time, near.distance, lam, 0.0, 0.0, 0.0, near.pair, near.law_distance, 0.0, 0.0, 0, -1,
            self.positions.copy(), self.velocities.copy(),
        )  # fmt: skip

    def with_time_step(self, dt: float) -> None:
        """Change dt [s] alone."""
        self.apply(replace(self.settings, dt=dt))
