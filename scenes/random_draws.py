"""Random settings, start postures and hand motions for `scenes.random_runs`."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from controllers.curve import curve_text
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS, FIRST_TASK, Series
from scenes.recording import Recording
from scenes.roles import room_of, scenario_of
from scenes.room import Room, World, random_bounds
from scenes.setting_spec import Spec
from scenes.settings import LATER, HardwareSettings, RunSettings, changed, specs, values
from scenes.world_stages import clearance, kept_clear

HARDWARE: Final = specs(HardwareSettings)

UNDRAWN: Final = frozenset({*HARDWARE, *LATER})
"""Settings that are not drawn with the others, so that new ones do not change a seed's series."""

REAL_ROBOTS: Final = 0.25
"""Share of runs with robots that are not ideal, for which there is no promise."""

TRIES: Final = 12
"""Random postures from which a start is chosen."""

FAR: Final = ((-0.9, -0.7, 0.0), (0.9, 0.7, 1.5))
"""Corners of the box of a hand's random places [m]."""

PLACES: Final = 4

PAUSE: Final = 1.5
"""Longest time between two places [s]."""


@dataclass(frozen=True)
class RandomRun:
    """One run.

    Attributes:
        start: q (nv,) [rad, m]; None for the start of the settings.
        hand: its path; None for the autopilot.
    """

    settings: RunSettings
    start: Array | None
    hand: Recording | None = None


def random_run(seed: int, index: int, series: Series = "usual") -> RandomRun:
    """Run `index` of a seed's series; equal arguments give equal runs."""
    dice = np.random.default_rng([seed, index])
    if series == "first-tasks":
        return _first_task_run(dice)
    settings = RunSettings()
    for key, spec in specs().items():
        if key not in UNDRAWN:
            settings = _with_drawn(dice, settings, key, spec)
    start = _start(dice, room_of(settings))
    if series == "world":
        settings = changed(settings, "world", True)
        start = _edge_start(dice, settings, lambda world: clearance(kept_clear(world)))
        return RandomRun(settings, start, _far_hand(dice) if settings.experiment.moves == "arm" else None)
    return RandomRun(_perhaps_real(dice, settings), start)


def _first_task_run(dice: np.random.Generator) -> RandomRun:
    settings = changed(RunSettings(), "scene", FIRST_TASK)
    for key, spec in specs().items():
        if key != "scene" and key not in HARDWARE:
            settings = _with_drawn(dice, settings, key, spec)
    law = settings.law
    start = None
    if dice.random() < 0.75:
        start = _edge_start(
            dice, settings, lambda world: float(world.detector.distances().min()) - law.critical_distance
        )
    if start is None:
        # The room's own start leaves less than the largest h_m.
        world = World(room_of(settings), settings.limit_gain)
        world.update()
        world.detector.detect()
        most = 0.9 * float(world.detector.distances().min())
        settings = replace(
            settings, law=replace(law, critical_distance=float(f"{min(law.critical_distance, most):.4g}"))
        )
    settings = _perhaps_real(dice, settings)
    return RandomRun(settings, start, _far_hand(dice) if dice.random() < 0.5 else None)


def _with_drawn(dice: np.random.Generator, settings: RunSettings, key: str, spec: Spec) -> RunSettings:
    return changed(settings, key, _drawn(dice, key, spec, values(settings)[key]))


def _perhaps_real(dice: np.random.Generator, settings: RunSettings) -> RunSettings:
    if dice.random() < REAL_ROBOTS:
        for key, spec in HARDWARE.items():
            settings = _with_drawn(dice, settings, key, spec)
    return settings


def _drawn(dice: np.random.Generator, key: str, spec: Spec, default: Any) -> object:
    """Random value of a setting; the law and the numbers keep their defaults with probability 1/2."""
    usual = bool(dice.random() < 0.5)
    if key == "scene":
        # Other first tasks have their own series.
        return str(
            dice.choice([name for name, experiment in EXPERIMENTS.items() if experiment.obstacle != "task"])
        )
    if spec.choices:
        return default if key == "law" and usual else str(dice.choice(spec.choices))
    if spec.read is not None:
        # A curve, the only text: a few points in any order of heights, each at least 1 mm from the last.
        gaps = dice.uniform(0.001, 0.15, dice.integers(2, 8))
        return curve_text(tuple(zip(np.cumsum(gaps).tolist(), dice.random(len(gaps)).tolist(), strict=True)))
    if isinstance(default, bool):
        return bool(dice.random() < 0.25)
    if usual and key != "seed":
        return default
    number = float(dice.uniform(spec.low, spec.high))
    return round(number) if isinstance(default, int) else float(f"{number:.4g}")


def _start(dice: np.random.Generator, room: Room) -> Array | None:
    """The room's own start (None), a random posture, or that of `TRIES` with the nearest bodies."""
    tries = (0, 1, TRIES, TRIES)[dice.integers(4)]
    if not tries:
        return None
    world = World(room, 10.0)
    postures = _postures(dice, room, tries)
    distances: list[float] = []
    for posture in postures:
        world.kinematics.update(posture)
        distances.append(world.detector.detect().distance)
    return _inside_stops(room, postures[int(np.argmin(distances))])


def _edge_start(
    dice: np.random.Generator, settings: RunSettings, margin: Callable[[World], float]
) -> Array | None:
    """Of `TRIES` random postures the accepted one with the smallest margin above 0; None without one.

    Args:
        margin: of a world after `detect`.
    """
    room = room_of(settings)
    world, scenario = World(room, settings.limit_gain), scenario_of(settings)
    best: tuple[float, Array] | None = None
    for posture in _postures(dice, room, TRIES):
        world.positions[:] = _inside_stops(room, posture)
        world.update()
        world.detector.detect()
        left = margin(world)
        if left > 0.0 and (best is None or left < best[0]) and scenario.problem(world, settings) is None:
            best = left, world.positions.copy()
    return None if best is None else best[1]


def _postures(dice: np.random.Generator, room: Room, count: int) -> Array:
    return dice.uniform(*random_bounds(room), (count, room.model.nv)).round(3)


def _inside_stops(room: Room, posture: Array) -> Array:
    return posture.clip(room.model.lowerPositionLimit, room.model.upperPositionLimit)


def _far_hand(dice: np.random.Generator) -> Recording:
    pauses = dice.uniform(0.1, PAUSE, PLACES - 1)
    times = np.concatenate([[0.0], np.cumsum(pauses)]).round(3)
    return Recording(times, dice.uniform(*FAR, (PLACES, 3)).round(3))
