"""Robots of example-robot-data with their capsules from the user's cache: to fit them takes most of a second, and all that comes of it is
seven numbers each."""

import importlib.metadata
from pathlib import Path

import numpy as np

from scenes import glb
from scenes.robots.description import Capsule, Robot
from scenes.robots.example_data import EXAMPLES, PACKAGE, load_example
from scenes.settings import RobotName


def stored_example(name: RobotName) -> Robot:
    """Return a robot of the package, the same as `build_example` does.

    Raises:
        BadSetting: the package is not installed, or not all of it.
    """
    example = EXAMPLES[name]
    model, _ = load_example(example)
    sources = [Path(__file__).with_name(f"{source}.py") for source in ("fitting", "enclosing", "example_data")]
    key = glb.source_key(sources, *(importlib.metadata.version(package) for package in (PACKAGE, "scipy", "pin")))

    def fit() -> tuple[bytes, ...]:
        # Brings scipy's optimiser with it, which is slow to import.
        from scenes.robots.fitting import build_example

        return tuple(np.concatenate([c.start, c.end, [c.radius]]).tobytes() for c in build_example(example).capsules)

    numbers = [np.frombuffer(blob) for blob in glb.cached(f"{name}-capsules", key, fit)]
    capsules = tuple(
        Capsule(segment.name, segment.joint, n[:3].copy(), n[3:6].copy(), float(n[6]))
        for segment, n in zip(example.segments, numbers, strict=True)
    )
    return example.robot(model, capsules)
