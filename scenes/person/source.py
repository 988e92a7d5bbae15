"""Sources of a person's angles."""

from typing import Protocol

import numpy as np

from controllers.errors import DuetError
from controllers.kinematics import Array
from scenes.targets import AnglesTarget, between


class MissingPackage(DuetError):
    """An optional package is not installed; the message names it, its use and how to install it."""


class PersonSource(Protocol):
    def angles(self, time: float) -> Array | None:
        """Angles (2, 4) [rad] of both arms at a time [s], left first, a new array; None while no person is
        seen.
        """
        ...


class PersonTarget:
    """A person as a source of targets.

    Args:
        loop: period of a repeated source [s].
    """

    def __init__(self, source: PersonSource, loop: float | None = None) -> None:
        self._source, self._loop = source, loop

    def target(self, time: float) -> AnglesTarget:
        return AnglesTarget(self._source.angles(time % self._loop if self._loop else time))


class SampledAngles:
    """A person through samples: straight between two, at rest before and after.

    Args:
        times: (k,) [s], strictly increasing, at least one.
        table: angles (k, 2, 4) [rad]; NaN if no person was seen.

    Raises:
        ValueError: wrong shapes, or times that do not increase.
    """

    def __init__(self, times: Array, table: Array) -> None:
        if times.ndim != 1 or len(times) == 0 or table.shape != (len(times), 2, 4):
            raise ValueError(f"times (k,) and angles (k, 2, 4) do not fit: {times.shape} and {table.shape}")
        if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
            raise ValueError("times must be finite and increase")
        self.times, self.table = times, table

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    def angles(self, time: float) -> Array | None:
        """Angles at a time [s]; None next to a sample without a person."""
        i, j, part = between(self.times, time)
        angles = (
            self.table[i].copy() if part == 0.0 else self.table[i] + part * (self.table[j] - self.table[i])
        )
        return angles if np.isfinite(angles).all() else None
