"""`python -m tests.tools.bench peers`: the hold experiment with four libraries and our laws, in one
interleaved run.

Every method has the same arms, capsules, pairs, joint bounds, pose to hold, and obstacle: the guided arm's
joints from a run of our simulation. Its velocity is known only to methods with "+w" in the name. Whole steps
are timed, ours with the record in the history. The peers solve a general problem for the 14 joints of both
arms, ours is one row for the 7 of the avoiding arm.
"""

import platform
import statistics
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from time import perf_counter_ns
from typing import Any, Final

import numpy as np

from app.version import duet_version
from controllers.errors import BadSetting, DuetError
from controllers.kinematics import Array
from scenes.room import Room
from scenes.settings import RunSettings
from tests.tools.bench.peer_method import Baked, Method, bake
from tests.tools.bench.peer_ours import METHODS, Ours

PACKAGES: Final = {
    "pink": "pin-pink",
    "mink": "mink",
    "mujoco": "mujoco",
    "qpsolvers": "qpsolvers",
    "daqp": "daqp",
}
"""Module → package of the extra `peers`."""

SOMEWHERE: Final = {"embodik": "embodik", "roboplan": "roboplan-oink"}
"""Module → package of peers that are not available for every machine."""

AGREEMENT: Final = 1e-9
"""Largest difference of distances [m] and poses [m, -] between two engines."""

POSTURES: Final = 1000
"""Random postures at which the engines are compared."""

STILL_KEPT: Final = 1e-4
"""Tolerance of "below d_m" [m]: a law that rests exactly at d_m overshoots by a share of dt."""

BLOCK: Final = 100
"""Steps of one method per turn; the first block of each method is not timed."""


def peer_names() -> tuple[str, ...]:
    """Installed peers; some exist only for some machines and versions of Python."""
    return ("pink", "mink", *(name for name in SOMEWHERE if find_spec(name) is not None))


def needs_peers() -> None:
    """Check the packages of the peers.

    Raises:
        BadSetting: a package is not installed.
    """
    absent = [package for module, package in PACKAGES.items() if find_spec(module) is None]
    if absent:
        raise BadSetting(
            f"The peers need {', '.join(absent)}, which is not installed: pip install -e '.[peers]'."
        )


def disagreement(mine: Ours, other: Method, room: Room) -> dict[str, float]:
    """Largest differences between two engines over random postures, and the smallest distance, all in [m].

    For an engine that only reports overlaps, the difference is at least the distance of a wrong report.

    Raises:
        DuetError: they have different pairs.
    """
    model, random = room.model, np.random.default_rng(1)
    distances, poses, nearest = [0.0], [0.0], np.inf
    for _ in range(POSTURES):
        q = random.uniform(model.lowerPositionLimit, model.upperPositionLimit)
        a, b = mine.distances(q), other.distances(q)
        if isinstance(b, bool):
            distances.append(0.0 if b == (min(a.values()) < 0.0) else abs(min(a.values())))
        elif a.keys() != b.keys():
            pair = " / ".join(min(a.keys() ^ b.keys()))
            raise DuetError(
                f"Peers: {pair} is a pair in one engine and not in the other; they cannot be compared."
            )
        else:
            distances += [abs(a[pair] - b[pair]) for pair in a]
        nearest = min(nearest, *a.values())
        poses += [
            float(np.abs(x - y).max()) for x, y in zip(mine.hand_pose(q), other.hand_pose(q), strict=True)
        ]
    # numpy's maximum, unlike Python's, does not ignore nan.
    return {"distance": float(np.max(distances)), "hand_pose": float(np.max(poses)), "nearest": nearest}


def gate(baked: Baked, engines: Mapping[str, Method]) -> dict[str, dict[str, float]]:
    """Agreement of the engines with ours.

    Raises:
        DuetError: they differ too much for a comparison.
    """
    mine, found = Ours(baked), {}
    for name, engine in engines.items():
        found[name] = differences = disagreement(mine, engine, baked.room)
        for what in ("distance", "hand_pose"):
            if not differences[what] <= AGREEMENT:
                raise DuetError(
                    f"Peers: {what.replace('_', ' ')} of {name} differs from ours by {differences[what]:.1e}, more than {AGREEMENT:g}; "
                    "the comparison would mean nothing."
                )
    return found


def measure_peers(steps: int) -> dict[str, Any]:
    """All figures, ready for JSON.

    Args:
        steps: per method, of the hold experiment with a pose to hold, a task known to all of them.

    Raises:
        BadSetting: a peer is not installed.
        DuetError: the engines do not agree.
    """
    needs_peers()
    baked = bake(RunSettings(task="pose"), steps)
    names = peer_names()
    peers: dict[str, dict[str, Callable[[Baked], Method]]] = {
        name: import_module(f"tests.tools.bench.peer_{name}").METHODS for name in names
    }
    agreement = gate(baked, {name: next(iter(made.values()))(baked) for name, made in peers.items()})
    methods = {name: make(baked) for made in (METHODS, *peers.values()) for name, make in made.items()}
    records = interleaved(methods, baked)
    figures = {name: summary(record, baked) for name, record in records.items()}
    for name, method in methods.items():
        figures[name]["unsolved"] = float(method.unsolved)
    fastest = figures["ours, single pair (paper)"]["median_us"]
    for row in figures.values():
        row["ratio"] = row["median_us"] / fastest
    return {
        "version": duet_version(),
        "machine": f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}",
        "packages": {
            package: version(package)
            for package in (*PACKAGES.values(), *map(SOMEWHERE.__getitem__, names[2:]))
        },
        "settings": asdict(baked.settings),
        "steps": steps,
        "pairs": len(baked.room.geometry.collisionPairs),
        "agreement": agreement,
        "figures": figures,
    }


@dataclass(frozen=True)
class _Record:
    """Every step of one method: q (steps, nv), q̇ (steps, nv), and wall times [ns]."""

    positions: Array
    velocities: Array
    times: list[int]


def interleaved(methods: Mapping[str, Method], baked: Baked) -> dict[str, _Record]:
    shape = (baked.steps, baked.room.model.nv)
    records = {name: _Record(np.empty(shape), np.empty(shape), []) for name in methods}
    for first in range(0, baked.steps, BLOCK):
        for name, method in methods.items():
            record = records[name]
            for step in range(first, min(first + BLOCK, baked.steps)):
                record.positions[step] = method.positions
                method.prepare(step)
                begin = perf_counter_ns()
                velocities = method.advance(step)
                record.times.append(perf_counter_ns() - begin)
                record.velocities[step] = velocities
    return records


def summary(record: _Record, baked: Baked) -> dict[str, float]:
    off = float(np.abs(record.positions[:, baked.guided] - baked.guided_positions).max())
    if off > AGREEMENT:
        raise DuetError(f"Peers: the obstacle was {off:.1e} rad off; all methods must have the same one.")
    engine = Ours(baked)
    d = np.array([engine.nearest(q) for q in record.positions])
    misses = np.array([engine.hand_pose(q)[0] - baked.place for q in record.positions])
    change = np.abs(np.diff(record.velocities[:, baked.avoiding], axis=0))
    times = record.times[BLOCK:] or record.times
    d_m = baked.settings.law.critical_distance
    return {
        "median_us": statistics.median(times) / 1000.0,
        "p99_us": float(np.percentile(times, 99)) / 1000.0,
        "d_min": float(d.min()),
        "share_below": float((d < d_m - STILL_KEPT).mean()),
        "e2_max": float((misses * misses).sum(axis=1).max()),
        "ddq_max": float(change.max()) / baked.settings.dt if len(change) else 0.0,
    }


def peers_table(result: dict[str, Any]) -> str:
    header = f"{'':34s} {'step µs':>8s} {'ratio':>6s} {'d_min mm':>9s} {'< d_m':>7s} {'e²max m²':>9s} {'q̈max rad/s²':>12s}"
    lines = [f"hold, {result['pairs']} pairs, {result['steps']} steps, interleaved", header]
    for name, row in result["figures"].items():
        lines.append(
            f"{name:34s} {row['median_us']:8.1f} {row['ratio']:6.1f} {1000.0 * row['d_min']:9.2f} {100.0 * row['share_below']:6.1f}% "
            f"{row['e2_max']:9.4f} {row['ddq_max']:12.2f}"
            + (f"   {row['unsolved']:g} steps unsolved" if row["unsolved"] else "")
        )
    lines.append(
        f"The peers solve for the 14 joints of both arms, ours for the 7 of one. Below d_m: by more than {1000.0 * STILL_KEPT:g} mm. "
        "+w: knows the guided arm's velocity; compare like with like. The person's "
        "arm, where it is computed, too, follows the hand that it is pulled by."
    )
    lines += [
        f"{name} is left out: it is not installed." for name in SOMEWHERE if name not in result["agreement"]
    ]
    for name, row in result["agreement"].items():
        lines.append(
            f"{name}'s distances differ from ours by at most {row['distance']:.1e} m ({POSTURES} random postures)"
        )
    return "\n".join(lines)
