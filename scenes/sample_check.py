"""Checks times, units and positions of a hand's samples before a run."""

from typing import Final

import numpy as np
import pinocchio as pin

from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS
from scenes.recording import Recording
from scenes.robots.start_search import arm_reach
from scenes.roles import room_of
from scenes.room import SIDES
from scenes.settings import RunSettings

CLOCK: Final = (3e8, 3e10)
"""Plausible readings of a clock, from 1979 on [s since 1970]."""

CLOCK_UNITS: Final = (("seconds", 1.0), ("milliseconds", 1e3), ("microseconds", 1e6), ("nanoseconds", 1e9))

LONGEST: Final = 1e7
"""Longest plausible recording [s]: four months."""

LEAST_OVERLAP: Final = 0.1

FEW: Final = 5
"""Fewest samples for an estimate of interval and pace."""

SLOW: Final = 0.005
"""A slower hand with an interval above `SPARSE` has times in another unit [m/s]."""

SPARSE: Final = 1.0
"""Interval of samples that is too long for a recording [s]."""

USUAL_PACE: Final = 0.01
"""Slowest usual pace of a moving hand [m/s]."""


def check_samples(recording: Recording, settings: RunSettings, seconds: float, name: str) -> tuple[str, ...]:
    """Warnings about unlikely samples of a run of `seconds` [s].

    Raises:
        BadInputFile: the samples move nothing in this run, or none of them is in it.
    """
    _check_moved(settings, name)
    _check_times(recording.times, seconds, name)
    said = (
        _unit_doubt(recording) or _overlap_doubt(recording.times, seconds),
        _reach_doubt(recording.positions, settings),
    )
    return tuple(f"{name}: {sentence}" for sentence in said if sentence)


def _check_moved(settings: RunSettings, name: str) -> None:
    if settings.experiment.moves != "arm":
        fitting = ", ".join(one.name for one in EXPERIMENTS.values() if one.moves == "arm")
        raise BadInputFile(
            f"{name}: holds places of a hand, which move nothing in the scene {settings.scene}; choose --scene from {fitting}."
        )
    if settings.draws_circle:
        raise BadInputFile(
            f"{name}: holds places of a hand, but with path = circle the hand draws a circle; leave out --path."
        )


def _check_times(times: Array, seconds: float, name: str) -> None:
    first, last = float(times[0]), float(times[-1])
    clock = next(((unit, per) for unit, per in CLOCK_UNITS if CLOCK[0] <= first / per < CLOCK[1]), None)
    if clock is not None and first >= seconds:
        unit, per = clock
        more = "" if per == 1.0 else f", and divide it by {per:.0f}"
        raise BadInputFile(
            f"{name}: t begins at {first:.15g}, which looks like a clock's {unit} since 1970, but a run begins at t = 0; "
            f"subtract the first t from all{more}."
        )
    if first >= seconds:
        raise BadInputFile(
            f"{name}: t begins at {first:.15g} s, when the run of {seconds:g} s is over, so that the hand would not move; "
            f"subtract the first t from all{_in_other_unit(times)}, or give --seconds above {last:.6g}."
        )
    if last < 0.0:
        raise BadInputFile(
            f"{name}: t ends at {last:.15g} s, before the run begins at t = 0, so that the hand would not move; "
            "subtract the first t from all."
        )
    if last - first > LONGEST:
        raise BadInputFile(
            f"{name}: t goes from {first:.15g} to {last:.15g} s, which is longer than any recording; t is in seconds"
            f"{_in_other_unit(times)}."
        )


def _in_other_unit(times: Array) -> str:
    if len(times) < 2:
        return ""
    interval = float(np.median(np.diff(times)))
    unit = next(((unit, per) for unit, per in CLOCK_UNITS if interval / per <= SPARSE), CLOCK_UNITS[-1])
    return "" if unit[1] == 1.0 else f" (these look like {unit[0]}: divide them by {unit[1]:.0f})"


def _unit_doubt(recording: Recording) -> str:
    times = recording.times
    if len(times) < FEW:
        return ""
    gaps = np.diff(times)
    interval = float(np.median(gaps))
    ways = np.linalg.norm(np.diff(recording.positions, axis=0), axis=1)
    moving = ways > 1e-6
    if interval < SPARSE or not moving.any():
        return ""
    pace = float(np.median(ways[moving] / gaps[moving]))
    if pace >= SLOW:
        return ""
    unit, per = next(
        ((unit, per) for unit, per in CLOCK_UNITS[1:] if pace * per >= USUAL_PACE), CLOCK_UNITS[-1]
    )
    return (
        f"t grows by {interval:g} s from sample to sample, and the hand moves at {1000.0 * pace:.3g} mm/s; t looks like {unit}: "
        f"divide it by {per:.0f}."
    )


def _overlap_doubt(times: Array, seconds: float) -> str:
    count, first, last = len(times), float(times[0]), float(times[-1])
    if count < 2:
        return ""
    inside = int(np.count_nonzero((times >= 0.0) & (times <= seconds)))
    share = (min(last, seconds) - max(first, 0.0)) / seconds
    if share >= LEAST_OVERLAP and not (inside < 2 and count >= FEW):
        return ""
    return (
        f"t goes from {first:g} to {last:g} s, and the run from 0 to {seconds:g} s: they hardly overlap, with {inside} of {count} "
        "samples in the run, and the hand rests before the first and after the last one; t is in seconds from the run's start, and "
        "--seconds sets its length."
    )


def _reach_doubt(positions: Array, settings: RunSettings) -> str:
    room = room_of(settings)
    arm = room.arm(settings.guided)
    made = room.robots[min(SIDES.index(settings.guided), len(room.robots) - 1)]
    data, reach = room.model.createData(), arm_reach(made)
    pin.forwardKinematics(room.model, data, room.start)
    shoulder = data.oMi[arm.joints.start + made.shoulder].translation
    nearest = float(np.linalg.norm(positions - shoulder, axis=1).min())
    if nearest <= reach:
        return ""
    x, y, z = shoulder.tolist()
    return (
        f"x, y and z are {nearest:.3g} m or more from the arm's shoulder at {x:.2f}, {y:.2f}, {z:.2f}, and it reaches {reach:.3g} m, "
        "so that the hand cannot follow; positions are in metres, in the frame of the room."
    )
