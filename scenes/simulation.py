"""One experiment in fixed time steps: targets → joint velocities → joint positions, always the same bits."""

from dataclasses import dataclass
from typing import Final

import numpy as np

# Loops are compiled together, also those of an experiment or a first task that is loaded when it is chosen.
import controllers.first_tasks.centre_of_mass  # noqa: F401
import controllers.first_tasks.joint_stops  # noqa: F401
import controllers.first_tasks.links_over_boxes  # noqa: F401
import controllers.first_tasks.points_over_plane  # noqa: F401
import controllers.first_tasks.smallest_singular_value  # noqa: F401
import scenes.person.retarget  # noqa: F401
from controllers.errors import BadSetting
from controllers.kinematics import Arm, Array, Kinematics
from controllers.laws.situation import FIRM_LEVER, Law, Unanswered, lever
from controllers.limits import TOLERANCE, Authority, Bounded
from controllers.proximity import Proximity, ProximityDetector
from controllers.row_stage import through_stages
from scenes.arm_tasks.arm_task import Memory
from scenes.arm_tasks.hold_task import HoldTask
from scenes.avoidance_group import AvoidanceGroup
from scenes.hardware import Actuation, Sensing, before_stops, measured_positions
from scenes.history import ArmSample, History, Sample
from scenes.roles import TargetSource, room_of, scenario_of
from scenes.room import Room, World
from scenes.settings import HardwareSettings, RunSettings
from scenes.starts import start_of
from scenes.targets import Target
from scenes.world_stages import WorldStages

IDEAL: Final = HardwareSettings()

HISTORY: Final = 16_000


@dataclass(frozen=True)
class Snapshot:
    """Full state between two steps; `Simulation.resume` continues from it, bit for bit.

    Attributes:
        time: simulated [s].
        positions, velocities: (nv,).
        robot: commands in transit, and the last frame of the distance sensor; () for an ideal robot.
    """

    settings: RunSettings
    steps: int
    time: float
    positions: Array
    velocities: Array
    memories: tuple[Memory, ...]
    robot: Memory = ()


class Simulation:
    """One experiment.

    Args:
        capacity: steps that the history keeps.
    """

    def __init__(self, settings: RunSettings, capacity: int = HISTORY) -> None:
        self.settings = settings
        self._capacity = capacity
        self.near: Proximity | None = None
        """Input of the newest decision; None after a change of settings."""
        self.law: Law = settings.law.made()
        self.given_law: Law | None = None
        self._hardware: HardwareSettings | None = None
        self.answers: tuple[float | Array, ...] = ()
        """Answers of the law in the newest step: λ, and q̇ of each avoiding group, perhaps a view [rad/s]."""
        self._enter(room_of(settings))
        self.reset()

    def _enter(self, room: Room) -> None:
        self.room = room
        self.world = World(room, self.settings.limit_gain)
        self.kinematics: Kinematics = self.world.kinematics
        self.detector: ProximityDetector = self.world.detector
        self.positions: Array = self.world.positions
        self.velocities: Array = self.world.velocities
        self._way = np.zeros(room.model.nv)
        self._desired = np.full(room.model.nv, np.nan)
        self._actuation, self._sensing = Actuation(room.model.nv), Sensing(self.world)
        self._assign()

    def _assign(self) -> None:
        self.roles = scenario_of(self.settings).roles(self.world, self.settings)
        self.guided: Arm = self.roles.guided
        self.avoiding: Arm = self.roles.avoiding
        """Arm of the shown task: the one that keeps its place and avoids, or the slave."""
        self._followers = [task for task in self.roles.tasks if task.desired is not None]
        self._desired[:] = np.nan
        self._form()

    def _form(self) -> None:
        tasks, avoiding = self.roles.tasks, self.roles.avoiders(self.settings.avoid)
        groups = [avoiding] if self.settings.one_row else [(task,) for task in avoiding]
        self._groups = [AvoidanceGroup(self.world, group, tasks) for group in groups]
        nominals = {task.joints.start: group.part(task) for group in self._groups for task in group.tasks}
        # A task that does not avoid moves its joints directly.
        self._asked = [(m, nominals.get(m.joints.start, self.velocities[m.joints])) for m in tasks]
        self._by_person = [(m, wanted) for m, wanted in self._asked if m.joints.start not in nominals]
        self._by_controller = [(m, wanted) for m, wanted in self._asked if m.joints.start in nominals]
        self._further = scenario_of(self.settings).stages(self.world, self.settings)
        self.stages = stages = WorldStages(self.world) if self.settings.world else None
        self._gliding = [
            (stage, wanted[part])
            for task, wanted in self._by_person
            for part, stage in (stages.inside(task.joints) if stages else ())
        ]
        for group in self._groups:
            group.stages = stages.inside(group.joints) if stages else []
        self.bound_bites = False
        """True if a law's velocity was out of bounds in the last step."""

    def apply(self, settings: RunSettings) -> None:
        """Change the settings from the next step on; arms stay in place unless the room, experiment or start
        changes.
        """
        before = self.settings
        self.settings, self.near = settings, None
        if self.given_law is None:
            self.law = settings.law.made()
        self.world.bounds.gain = settings.limit_gain
        room = room_of(settings)
        reads = [key for key in ("guided", "path") if key in settings.experiment.reads]
        start = start_of(settings, room)
        if (
            room is not self.room
            or settings.experiment is not before.experiment
            or start is not start_of(before, room)
        ):
            self._enter(room)
            self.reset()
        elif any(getattr(settings, key) != getattr(before, key) for key in reads):
            self._assign()
            self._begin()
        elif (settings.avoid, settings.one_row, settings.world) != (
            before.avoid,
            before.one_row,
            before.world,
        ):
            self._form()
        elif settings.law is not before.law:
            self._further, self.start_problem = scenario_of(settings).stages(self.world, settings), None

    def reset(self, positions: Array | None = None) -> None:
        """Restart at time 0, at rest, in the settings' start posture or at q (nv,) [rad]."""
        self.positions[:] = start_of(self.settings, self.room) if positions is None else positions
        self.steps = 0
        self.time = 0.0
        self.history = History(self._capacity, self.room.model.nv)
        self.near = None
        self._form()
        self._begin()

    def _begin(self) -> None:
        self.velocities[:] = 0.0
        self._actuation.clear()
        self._sensing.clear()
        self.world.update()
        for task in self.roles.tasks:
            task.begin()
        self.start_problem: BadSetting | None = scenario_of(self.settings).problem(self.world, self.settings)
        """See `Scenario.problem`."""

    def use(self, law: Law | None) -> None:
        """Use a given law; None for the settings' law."""
        self.given_law = law
        self.law = self.settings.law.made() if law is None else law

    @property
    def keeper(self) -> HoldTask | None:
        """Task of the avoiding hand; None if the arm follows joints."""
        return self.roles.task if isinstance(self.roles.task, HoldTask) else None

    @property
    def way(self) -> Array:
        """Path of the avoiding hand, see `Scenario.way`."""
        return (
            np.zeros((0, 3))
            if self.keeper is None
            else scenario_of(self.settings).way(self.settings, self.keeper.home)
        )

    def source(self) -> TargetSource:
        self.kinematics.update(self.positions)
        return scenario_of(self.settings).source(self.world, self.settings)

    def opening(self) -> TargetSource | None:
        self.kinematics.update(self.positions)
        return scenario_of(self.settings).opening(self.world, self.settings)

    @property
    def avoiding_joints(self) -> int:
        """Length of the law's q̇ in each step."""
        return sum(len(group.nominal) for group in self._groups)

    def joint_label(self, joint: int, second: bool = False) -> str:
        """Label of the joint that costs authority."""
        column = joint + self._groups[int(second and len(self._groups) > 1)].joints.start
        arm = next(arm for arm in self.room.arms if arm.joints.start <= column < arm.joints.stop)
        return arm.labels[column - arm.joints.start]

    def step(self, target: Target | None) -> None:
        """Advance by dt. `target`: None for no change.

        Raises:
            Unanswered: the law has not answered; nothing has changed, and the step can be repeated.
        """
        if self.given_law is None:
            self._advance(target)
            return
        velocities, bites, memories = (
            self.velocities.copy(),
            self.bound_bites,
            [task.memory() for task in self.roles.tasks],
        )
        try:
            self._advance(target)
        except Unanswered:
            self.velocities[:], self.bound_bites = velocities, bites
            for task, memory in zip(self.roles.tasks, memories, strict=True):
                task.remember(memory)
            raise

    def _advance(self, target: Target | None) -> None:
        settings = self.settings
        hardware = settings.hardware
        before = self.velocities.copy() if hardware != IDEAL else None
        self.near = None
        if hardware.sees_wrong:
            scalars, second = self._decide_by_sensors(target)
        else:
            self.world.update()
            near = self.detector.detect(*settings.law.proximity)
            for task, wanted in self._asked:
                wanted[:] = task.nominal(target, settings, self.time)
            self._glide()
            scalars, second = self._decide(near)
            self.near = near
        if hardware is not self._hardware:
            # Only settings in force in a step count, as they are recorded with the inputs: a rerun is equal.
            self._hardware = hardware
            if hardware == IDEAL:
                self._actuation.clear()
            if hardware.frame_rate == 0.0:
                self._sensing.clear()
        if before is not None:
            self._actuate(before)
        for follower in self._followers:
            self._desired[follower.joints] = follower.desired
        self.history.append(
            scalars,
            self.positions,
            self.velocities,
            self._desired if self._followers else None,
            second,
        )
        self.positions += np.multiply(self.velocities, settings.dt, out=self._way)
        self.steps += 1
        self.time += settings.dt

    def _glide(self) -> None:
        for stage, velocities in self._gliding:
            stage.keep(velocities)

    def _decide(
        self, near: Proximity, error: float = 0.0
    ) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        """Command the avoiding arms; return the history's columns. `error`: of all distances [m]."""
        lam = self.law.activation(near.law_distance)
        self.answers, self.bound_bites = (lam,), False
        first, second = self._groups[0], None
        velocities, u, w, w_law, authority, joint, s = self._kept_clear(first, near, lam, error)
        if len(self._groups) > 1:
            # Each arm sees the other's velocity of the last step, so that the order does not matter.
            other = self._groups[1]
            other.velocities[:], *columns = self._kept_clear(other, near, lam, error)
            second = (other.tasks[0].squared_error, *columns)
        first.velocities[:] = velocities
        e2 = self.roles.task.squared_error
        return (
            self.time,
            near.distance,
            lam,
            e2,
            u,
            w,
            near.pair,
            near.law_distance,
            w_law,
            authority,
            joint,
            s,
        ), second

    def _kept_clear(
        self, group: AvoidanceGroup, near: Proximity, lam: float, error: float
    ) -> tuple[Array, float, float, float, int, int, float]:
        """q̇ (n,) of a group [rad/s]; then u, w, w along the law's row, authority, joint and lever."""
        situation = group.situation(self.law, near, error, self.settings.law.knows_w)
        row, w_law = situation.row, group.approach(near.row)
        w = w_law if near.row is near.pair_row else group.approach(near.pair_row)
        wanted = self.law(situation)
        self.answers = *self.answers, wanted
        s = lever(float(row.dot(row)))
        velocities, authority, joint = self._bound(group, row, wanted, lam, s)
        if self._further or group.stages:
            kept = through_stages(velocities, self._further).copy()
            for part, stage in group.stages:
                stage.keep(kept[part])
            lost = float(row.dot(velocities - kept))
            if lam > 0.5 and authority is Authority.FULL and lost > TOLERANCE:
                authority = Authority.WORLD
            velocities = kept
        return velocities, situation.pull, w, w_law, int(authority), joint, s

    def _decide_by_sensors(self, target: Target | None) -> tuple[tuple[float, ...], tuple[float, ...] | None]:
        """`_decide` with the measured state for the controller; the person uses the true one."""
        settings, world, actual = self.settings, self.world, self.positions.copy()
        try:
            world.update()
            there = self.detector.detect()
            for task, wanted in self._by_person:
                wanted[:] = task.nominal(target, settings, self.time)
            self._glide()
            self.positions[:] = measured_positions(settings, actual, self.room.arms, self.steps)
            world.update()
            for task, wanted in self._by_controller:
                wanted[:] = task.nominal(target, settings, self.time)
            seen = self._sensing.proximity(settings, there, self.time, self.steps)
            return self._decide(seen, self._sensing.error)
        finally:
            self.positions[:] = actual
            # The true posture is drawn and measured after a step.
            world.update()
            self.detector.detect()

    def _actuate(self, before: Array) -> None:
        """Replace commanded velocities by the reached ones, within the true bounds."""
        dt, model = self.settings.dt, self.room.model
        reached = self._actuation.reached(self.settings.hardware, self.velocities, before, self.time, dt)
        stopped = np.zeros(len(reached), bool)
        for group in self._groups:
            j, top = group.joints, model.velocityLimit[group.joints]
            stops = model.lowerPositionLimit[j], model.upperPositionLimit[j]
            self.velocities[j] = np.clip(before_stops(reached[j], self.positions[j], *stops, dt), -top, top)
            stopped[j] = self.velocities[j] != reached[j]
        self._actuation.stop(stopped)

    def _bound(self, group: AvoidanceGroup, row: Array, wanted: Array, lam: float, s: float) -> Bounded:
        if group.box.contains(wanted):
            bounded = Bounded(wanted)
        else:
            self.bound_bites = True
            bounded = group.bounded(row, wanted, self.settings.bounds)
        if lam > 0.5 and s < FIRM_LEVER and bounded.authority is Authority.FULL:
            return bounded._replace(authority=Authority.LEVERAGE)
        return bounded

    def snapshot(self) -> Snapshot:
        memories = tuple(task.memory() for task in self.roles.tasks)
        hardware = self.settings.hardware
        robot: Memory = ()
        if hardware != IDEAL:
            *commands, end = self._actuation.memory()
            robot = (*commands, *self._sensing.memory(), end)
        return Snapshot(
            self.settings,
            self.steps,
            self.time,
            self.positions.copy(),
            self.velocities.copy(),
            memories,
            robot,
        )

    def resume(self, snapshot: Snapshot) -> None:
        """Continue from a snapshot with the same scene, rig, robot, guided arm, path and control point, under
        the present settings.
        """
        self.reset(snapshot.positions)
        self.steps, self.time = snapshot.steps, snapshot.time
        self.velocities[:] = snapshot.velocities
        for task, memory in zip(self.roles.tasks, snapshot.memories, strict=True):
            task.remember(memory)
        if snapshot.robot:
            times, commands, held, frame, end = snapshot.robot
            self._actuation.remember((times, commands, end))
            self._sensing.remember((held, frame))
        self._hardware = None

    def sample(self) -> Sample:
        if self.history.count:
            return self.history.last()
        self.kinematics.update(self.positions)
        near = self.detector.detect(*self.settings.law.proximity)
        try:
            lam = self.law.activation(near.law_distance)
        except Unanswered:
            lam = 0.0
        q, dq, desired = self.positions.copy(), self.velocities.copy(), np.full(len(self.positions), np.nan)
        rows = [near.row[group.joints] for group in self._groups]
        s, *others = (lever(float(row.dot(row))) for row in rows)
        nothing = 0.0, 0.0, 0.0, 0.0, 0, -1
        second = ArmSample(*nothing, others[0]) if others else None
        return Sample(
            *nothing, s, self.time, near.distance, lam, near.pair, near.law_distance, second, q, dq, desired
        )
