"""Runs shared by many tests, and ways into particular situations."""

import json
import struct
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import platformdirs
import pytest

from controllers.choices import Treatment
from controllers.errors import DuetError
from controllers.kinematics import Array
from scenes.avoidance_group import AvoidanceGroup
from scenes.experiments import EXPERIMENTS
from scenes.history import COLUMN
from scenes.inputs import InputsLog, Recorded
from scenes.roles import TargetSource
from scenes.settings import LawSettings, RigName, RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget, Target
from scenes.world_stages import clearance, kept_clear

T = TypeVar("T")
RIG_NAMES: tuple[RigName, ...] = ("torso", "table")
SCENES = tuple(EXPERIMENTS)


def refusal(what: Callable[[], object]) -> str:
    """Message of the error that `what` raises."""
    with pytest.raises(DuetError) as caught:
        what()
    return str(caught.value)


TREATMENTS: tuple[Treatment, ...] = ("single", "soft")


def hold_settings(
    rig: RigName = "torso",
    seed: int = 1,
    pairs: Treatment = "soft",
    law: str = "smooth_priority",
    dt: float = 0.005,
) -> RunSettings:
    return RunSettings(rig=rig, seed=seed, dt=dt, law=LawSettings(law=law, pairs=pairs))


def inside_limits(simulation: Simulation) -> bool:
    model, q, dq = simulation.room.model, simulation.positions, simulation.velocities
    inside = (q >= model.lowerPositionLimit - 1e-12).all() and (q <= model.upperPositionLimit + 1e-12).all()
    return bool(np.isfinite(q).all() and inside and (np.abs(dq) <= model.velocityLimit + 1e-12).all())


def column(table: Array, name: str) -> Array:
    return table[:, COLUMN[name]]


def play(simulation: Simulation, targets: Iterable[Target | None]) -> Array:
    for target in targets:
        simulation.step(target)
    return simulation.history.table()


def moved(settings: RunSettings, until: Callable[[Simulation], object]) -> Simulation:
    """The experiment moved by its own person until `until` is true, at most 20 s."""
    simulation = Simulation(settings)
    person = simulation.source()
    while not until(simulation):
        assert simulation.time < 20.0, "the condition was never met"
        simulation.step(person.target(simulation.time))
    return simulation


def guided_hand(simulation: Simulation) -> Array:
    simulation.kinematics.update(simulation.positions)
    return simulation.kinematics.hand_pose(simulation.guided).translation.copy()


def avoiding_hand(simulation: Simulation) -> Array:
    simulation.kinematics.update(simulation.positions)
    return simulation.kinematics.hand_pose(simulation.avoiding).translation.copy()


def place_of(simulation: Simulation) -> Array:
    """Wanted position of the avoiding hand (3,), a live view [m]."""
    assert simulation.keeper is not None
    return simulation.keeper.place


def true_distance(simulation: Simulation, positions: Array) -> float:
    """Smallest distance between the arms at q (nv,) [m]."""
    simulation.kinematics.update(positions)
    return simulation.detector.detect().distance


def wander(simulation: Simulation, steps: int, seed: int = 1) -> list[HandTarget | None]:
    """Targets around the guided hand, with pauses, reproducible by `seed`."""
    random = np.random.default_rng(seed)
    place = guided_hand(simulation)
    targets: list[HandTarget | None] = []
    while len(targets) < steps:
        target = HandTarget(place + random.uniform(-0.4, 0.4, 3)) if random.random() < 0.8 else None
        targets += [target] * int(random.integers(5, 40))
    return targets[:steps]


@cache
def overlapping_start(rig: RigName, depth: float = 0.05) -> tuple[float, ...]:
    """Posture (nv,) with arms that overlap by `depth` [m]: one was pushed into an unprotected one."""
    simulation = Simulation(hold_settings(rig, law="unprotected"))
    goal = avoiding_hand(simulation)
    for _ in range(4000):
        simulation.step(HandTarget(goal))
        if true_distance(simulation, simulation.positions) < -depth:
            return tuple(simulation.positions.tolist())
    raise AssertionError("the arms never met")


def with_law(settings: RunSettings, **changes: object) -> RunSettings:
    return replace(settings, law=replace(settings.law, **changes))  # pyright: ignore[reportArgumentType]


def with_values(settings: T, **changes: object) -> T:
    """Run or page settings with other values of some keys."""
    for key, value in changes.items():
        settings = changed(settings, key, value)
    return settings


def given_settings(**changes: object) -> RunSettings:
    return with_values(RunSettings(), **changes)


def logged_run(
    settings: RunSettings,
    seconds: float,
    log: InputsLog | None = None,
    changes: dict[float, dict[str, Any]] | None = None,
) -> tuple[Simulation, InputsLog]:
    """A run of the experiment's own person, and its log; settings change at shares of its time."""
    simulation, log = Simulation(settings), log or InputsLog()
    person, due = simulation.source(), dict(changes or {})
    while simulation.time < seconds - 1e-9:
        for share in [share for share in due if simulation.time >= share * seconds]:
            for key, value in due.pop(share).items():
                simulation.apply(changed(simulation.settings, key, value))
        target = person.target(simulation.time)
        log.record(simulation, target)
        simulation.step(target)
    return simulation, log


def scene_settings(scene: str, **changes: object) -> RunSettings:
    return given_settings(scene=scene, ball="cross" if scene == "ball" else "still", **changes)


def recorded_run(
    settings: RunSettings, seconds: float, window: float, changes: dict[float, dict[str, Any]] | None = None
) -> tuple[Simulation, Recorded]:
    """The same run, and its last `window` seconds."""
    simulation, log = logged_run(settings, seconds, changes=changes)
    recorded = log.window(window)
    assert recorded is not None
    return simulation, recorded


def beyond(points: Array, start: Array, end: Array, radius: float) -> Array:
    """Distances of points (k, 3) from a capsule (a ball if the ends are equal); negative inside (k,) [m]."""
    way = end - start
    share = np.clip((points - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * way, axis=1) - radius


@contextmanager
def own_cache(folder: Path, *memories: Any) -> Iterator[Path]:
    """The disk cache in this folder, and empty memory caches: everything is built again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(platformdirs, "user_cache_dir", lambda *_: str(folder))
        for memory in memories:
            memory.cache_clear()
        yield folder
    for memory in memories:
        memory.cache_clear()


def glb_head(data: bytes) -> dict[str, Any]:
    """JSON head of a GLB file."""
    magic, version, length, size, kind = struct.unpack("<IIIII", data[:20])
    assert (magic, version, length, kind) == (0x46546C67, 2, len(data), 0x4E4F534A)
    return json.loads(data[20 : 20 + size])


def groups_of(simulation: Simulation) -> tuple[AvoidanceGroup, ...]:
    return tuple(simulation._groups)


def least_clearance(simulation: Simulation, source: TargetSource, seconds: float) -> float:
    """Least clearance from the surroundings while a source moves the simulation [m]."""
    kept, least = kept_clear(simulation.world), np.inf
    while simulation.time < seconds:
        simulation.step(source.target(simulation.time))
        simulation.kinematics.update(simulation.positions)
        least = min(least, clearance(kept))
    return least
