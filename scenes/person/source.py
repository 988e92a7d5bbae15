"""Where a person's arms come from: one question, whatever the answer is made of."""

from typing import Protocol

import numpy as np

from controllers.errors import DuetError
from controllers.kinematics import Array
from scenes.targets import AnglesTarget, between


class MissingPackage(DuetError):
    """An optional package is not installed; the message says which, what for, and how to install it."""


class PersonSource(Protocol):
    """A person to imitate."""

    def angles(self, time: float) -> Array | None:
        """Return the four angles of both arms at a time [s] of the run: (2, 4) [rad], left first, as `scenes.person.angles` defines.

        None while no person is seen. The array is the caller's to keep.
        """
        ...


class PersonTarget:
    """A person as a source of targets.

    Args:
        source: of the angles.
        loop: start again after this time [s]; None for a source that does not end.
    """

    def __init__(self, source: PersonSource, loop: float | None = None) -> None:
        self._source, self._loop = source, loop

    def target(self, time: float) -> AnglesTarget:
        """State of the person's arms at a time [s]."""
        return AnglesTarget(self._source.angles(time % self._loop if self._loop else time))


class SampledAngles:
    """A person through samples: straight between two of them, at rest before the first and after the last.

    Args:
        times: (k,) [s], strictly increasing, at least one.
        table: angles (k, 2, 4) [rad]; a row with a NaN is a moment when no person was seen.

    Raises:
        ValueError: shapes that don't fit, or times that don't increase.
    """

    def __init__(self, times: Array, table: Array) -> None:
        if times.ndim != 1 or len(times) == 0 or table.shape != (len(times), 2, 4):
            raise ValueError(f"times (k,) and angles (k, 2, 4) do not fit: {times.shape} and {table.shape}")
        if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
            raise ValueError("times must be finite and increase")
        self.times, self.table = times, table

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.times[-1])

    def angles(self, time: float) -> Array | None:
        """Return the angles (2, 4) at a time [s], or None between samples if one of them is without a person."""
        i, j, part = between(self.times, time)
        angles = self.table[i].copy() if part == 0.0 else self.table[i] + part * (self.table[j] - self.table[i])
        return angles if np.isfinite(angles).all() else None
