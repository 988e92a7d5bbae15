"""The arm that a person holds."""

from controllers.kinematics import Arm, Array
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.guide import Guide
from scenes.robots import Robot
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import HandTarget, JointTarget, LinkTarget, PairTarget, Target


class GuidedTask(ArmTask):
    """Follows a hand, an elbow, a pulled link or joint positions at no more than a person's speed; see `scenes.guide`.

    Args:
        world: where.
        arm: which.
        robot: its make.
    """

    def __init__(self, world: World, arm: Arm, robot: Robot) -> None:
        self.joints = arm.joints
        self._positions = world.positions[arm.joints]
        posture = world.room.start[arm.joints]
        self._guide = Guide(world.kinematics, arm, robot, world.bounds.part(arm.joints), posture)
        self._kinematics, self._arm = world.kinematics, arm

    @property
    def task_jacobian(self) -> Array:
        """J (3, n) of the hand's position in the last `nominal`."""
        return self._kinematics.hand_jacobian(self._arm, 3) if self._jacobian is None else self._jacobian

    def begin(self) -> None:
        """Come to rest."""
        self._guide.velocities[:] = 0.0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """Return q̇ (n,) of the person's hand on the arm [rad/s]; the array is reused."""
        del time
        # The camera's last frame is looked at afterwards, with the arms where they were then.
        held = settings.hardware.frame_rate > 0.0
        self._jacobian = self._kinematics.hand_jacobian(self._arm, 3) if held else None
        target = target.first if isinstance(target, PairTarget) else target
        wish = target if isinstance(target, (HandTarget, JointTarget, LinkTarget)) else None
        return self._guide.follow(wish, self._positions, settings.dt, settings.hand_speed)

    def memory(self) -> Memory:
        """Return the velocities that the person's hand has reached."""
        return (self._guide.velocities.copy(),)

    def remember(self, memory: Memory) -> None:
        """Go on with these velocities."""
        self._guide.velocities[:] = memory[0]
