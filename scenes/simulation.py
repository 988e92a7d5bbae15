"""Scene, law and a fixed time step: inputs → joint velocities → joint positions, one tick at a time, always the same bits."""

from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array, Kinematics
from controllers.laws.situation import Law, Situation, row_damping
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.unprotected import Unprotected
from controllers.limits import Authority, Bounded, VelocityBox, bounded_row
from controllers.proximity import ProximityDetector
from controllers.tasks import hold, pose_error, position_error
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
        self._way = np.zeros(nv)
        gain = self.settings.limit_gain
        lower, upper, speed = room.model.lowerPositionLimit, room.model.upperPositionLimit, room.model.velocityLimit
        self._all_joints = VelocityBox(lower.copy(), upper.copy(), speed.copy(), gain)
        self._boxes = {arm.name: self._all_joints.part(arm.joints) for arm in room.arms}
        self._guides = {
            arm.name: Guide(self.kinematics, arm, robot, self._boxes[arm.name], room.start[arm.joints])
            for arm, robot in zip(room.arms, room.robots, strict=True)
        }

        self._assign()

    def _assign(self) -> None:
        """Note who is who: everything that a step would otherwise look up again."""
        side = self.settings.guided
        self.guided: Arm = self.room.arm(side)
        """The arm that the person moves."""
        self.avoiding: Arm = self.room.other(side)
        """The arm that keeps its place and keeps clear."""
        self._guide = self._guides[self.guided.name]
        self._box = self._boxes[self.avoiding.name]
        self._q_guided = self.positions[self.guided.joints]
        self._q_avoiding = self.positions[self.avoiding.joints]
        self._dq_guided = self.velocities[self.guided.joints]
        self._dq_avoiding = self.velocities[self.avoiding.joints]

    def apply(self, settings: RunSettings) -> None:
        """Change the settings from the next step on. The arms stay where they are, unless they are put on another rig."""
        before = self.settings
        self.settings = settings
        self.law = make_law(settings.law)
        self._all_joints.gain = settings.limit_gain
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
        self.bounded = Bounded(np.zeros(self._box.lower.shape))
        """What the avoiding arm did in the last step, and why not more."""
        self.bound_bites = False
        """Whether the law's velocity was outside the arm's bounds in the last step."""
        self.history.clear()
        self._take_places()

    def _take_places(self) -> None:
        """The avoiding hand's place is where it is now, and nobody moves."""
        self._assign()
        self.velocities[:] = 0.0
        for guide in self._guides.values():
            guide.reset()
        self.kinematics.update(self.positions)
        pose = self.kinematics.hand_pose(self.avoiding)
        self.place: Array = pose.translation.copy()
        self.place_rotation: Array = pose.rotation.copy()

    def step(self, target: HandTarget | None) -> None:
        """Advance by dt. `target` is where the person wants the guided hand; None leaves the guided arm alone."""
        settings, kinematics, law = self.settings, self.kinematics, self.settings.law
        guided, avoiding, box = self.guided.joints, self.avoiding, self._box
        kinematics.update(self.positions)
        self._all_joints.update(self.positions)
        near = self.detector.detect(law.pairs, law.beta)

        dq_guided = self._guide.follow(target, self._q_guided, settings.dt, settings.hand_speed)
        law_approach = -float(near.row[guided].dot(dq_guided))
        approach = law_approach if near.row is near.pair_row else -float(near.pair_row[guided].dot(dq_guided))

        pose = kinematics.hand_pose(avoiding)
        error = (
            position_error(pose, self.place) if settings.task == "position" else pose_error(pose, self.place, self.place_rotation)
        )
        nominal = box.clip(hold(kinematics, avoiding, settings.task, error, settings.gain))
        situation = Situation(self._q_avoiding, nominal, near.row[avoiding.joints], near.law_distance, law_approach)
        lam = self.law.activation(near.law_distance)
        self.bounded = bounded = self._bound(situation, self.law(situation), lam)

        self._dq_guided[:] = dq_guided
        self._dq_avoiding[:] = bounded.velocities
        x, y, z = error[:3].tolist()
        self.history.append(
            (
                self.time,
                near.distance,
                lam,
                x * x + y * y + z * z,
                situation.pull,
                approach,
                near.pair,
                near.law_distance,
                law_approach,
                int(bounded.authority),
                bounded.joint,
            ),
            self.positions,
            self.velocities,
        )
        self.positions += np.multiply(self.velocities, settings.dt, out=self._way)
        self.steps += 1
        self.time += settings.dt

    def _bound(self, situation: Situation, wanted: Array, lam: float) -> Bounded:
        """Return what the avoiding arm can do of what the law wants."""
        box, row = self._box, situation.row
        self.bound_bites = not box.contains(wanted)
        bounded = bounded_row(situation.nominal, row, float(row.dot(wanted)), box) if self.bound_bites else Bounded(wanted)
        if lam > 0.5 and bounded.authority is Authority.FULL:
            square = float(row.dot(row))
            # Less than half of what the law asked for is left after damping: the arm has no lever against this approach.
            if row_damping(square) > square:
                return bounded._replace(authority=Authority.LEVERAGE)
        return bounded

    def sample(self) -> Sample:
        """Return the newest step; makes none if there is none yet, but measures the present state."""
        if self.history.count == 0:
            return self._measured()
        return self.history.last()

    def _measured(self) -> Sample:
        self.kinematics.update(self.positions)
        near = self.detector.detect(self.settings.law.pairs, self.settings.law.beta)
        lam = self.law.activation(near.law_distance)
        q, dq = self.positions.copy(), self.velocities.copy()
        return Sample(self.time, near.distance, lam, 0.0, 0.0, 0.0, near.pair, near.law_distance, 0.0, 0, -1, q, dq)
