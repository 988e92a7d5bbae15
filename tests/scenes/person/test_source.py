"""Recorded people: between samples, outside them, and where nobody was seen."""

import numpy as np
import pytest

from scenes.person.source import PersonSource, SampledAngles

TIMES = np.array([0.0, 1.0, 3.0, 4.0])
TABLE = np.arange(4.0)[:, None, None] * np.ones((4, 2, 4))


def value(source: PersonSource, time: float) -> float | None:
    angles = source.angles(time)
    return None if angles is None else float(angles[1, 2])


def test_sampled_angles() -> None:
    # Straight between samples, at rest outside.
    sampled = SampledAngles(TIMES, TABLE)
    assert sampled.duration == 4.0
    times = (-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 3.25, 4.0, 99.0)
    assert [value(sampled, t) for t in times] == [0.0, 0.0, 0.5, 1.0, 1.5, 2.0, 2.25, 3.0, 3.0]
    # No person at a sample with a NaN, nor on the way to or from it.
    table = TABLE.copy()
    table[2, 0, 0] = np.nan
    sampled = SampledAngles(TIMES, table)
    assert [value(sampled, t) for t in (1.0, 1.1, 3.0, 3.9, 4.0)] == [1.0, None, None, None, 3.0]
    # One posture for ever.
    sampled = SampledAngles(np.array([2.0]), TABLE[1:2])
    assert [value(sampled, t) for t in (0.0, 2.0, 5.0)] == [1.0, 1.0, 1.0]
    # The caller may keep what it gets: two arms of four angles.
    sampled = SampledAngles(TIMES, TABLE.copy())
    angles = sampled.angles(1.0)
    assert angles is not None and angles.shape == (2, 4)
    angles[:] = 7.0
    assert value(sampled, 1.0) == 1.0


def test_shapes_and_times_are_checked() -> None:
    misfits = [(TIMES[:3], TABLE), (TIMES[:0], TABLE[:0]), (TIMES, TABLE[:, 0]), (TIMES[::-1], TABLE)]
    misfits += [(np.array([0.0, 1.0, wrong, 2.0]), TABLE) for wrong in (1.0, np.nan)]
    for times, table in misfits:
        with pytest.raises(ValueError, match="times"):
            SampledAngles(times, table)
