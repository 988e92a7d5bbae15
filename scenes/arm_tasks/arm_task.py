"""Base class of the tasks."""

from controllers.kinematics import Array
from scenes.settings import RunSettings
from scenes.targets import Target

Memory = tuple[Array, ...]


class ArmTask:
    """Asks for velocities of some joints.

    Attributes:
        joints: columns in q.
        squared_error: in the last `nominal`, of a hand's position [m²] or of joints [rad²].
        desired: q (n,) that it follows [rad], or None.
    """

    joints: slice
    squared_error: float = 0.0
    desired: Array | None = None
    _jacobian: Array | None = None

    @property
    def task_jacobian(self) -> Array | None:
        """J (m, n) of the task in the last `nominal`; None if it uses every joint."""
        return self._jacobian

    def own_velocity(self, others: slice) -> Array | None:
        """q̇_n (n,) of the last `nominal` with other joints at rest; None if it does not copy a velocity."""
        del others
        return None

    def begin(self) -> None:
        """Set the velocity to 0 and take the present state as the beginning."""

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """q̇_n (n,) inside the task's bounds [rad/s].

        Args:
            target: ignored if meant for another task.
            time: since the start [s].
        """
        raise NotImplementedError

    def memory(self) -> Memory:
        return ()

    def remember(self, memory: Memory) -> None:
        """Restore a state of `memory`."""
