"""What all tasks have."""

from controllers.kinematics import Array
from scenes.settings import RunSettings
from scenes.targets import Target

Memory = tuple[Array, ...]
"""Everything that a task carries from one tick to the next, as copies."""


class ArmTask:
    """Moves some of the joints.

    Attributes:
        joints: its columns in q.
        squared_error: of its task in the last `nominal`, [m²] of a hand's position or [rad²] of joints.
        desired: q (n,) that it follows, None if it follows none [rad].
    """

    joints: slice
    squared_error: float = 0.0
    desired: Array | None = None
    _jacobian: Array | None = None

    @property
    def task_jacobian(self) -> Array | None:
        """J (m, n) of its task in the last `nominal`; None if the task uses every joint."""
        return self._jacobian

    def own_velocity(self, others: slice) -> Array | None:
        """q̇_n (n,) of the last `nominal` if other joints had stood still; None if it does not copy their velocity.

        Args:
            others: their columns in q.
        """
        del others
        return None

    def begin(self) -> None:
        """Come to rest, and take the present state as where everything begins."""

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """Return q̇_n (n,) inside the task's bounds [rad/s].

        Args:
            target: what the person wants now; a task takes up what is meant for it.
            settings: of the run.
            time: since the start [s].
        """
        raise NotImplementedError

    def memory(self) -> Memory:
        """Return the state that `remember` restores."""
        return ()

    def remember(self, memory: Memory) -> None:
        """Go on from where `memory` was taken."""
