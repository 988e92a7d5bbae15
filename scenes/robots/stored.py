"""Robots of example-robot-data and of URDF files with their capsules from the user's cache: to fit them takes most of a second, and
all that comes of it is a few numbers each."""

import importlib.metadata
from collections.abc import Callable
from pathlib import Path

import numpy as np

from scenes import glb
from scenes.robots.description import Capsule, Robot
from scenes.robots.example_data import EXAMPLES, PACKAGE, load_example


def stored_example(name: str) -> Robot:
    """Return a robot of the package, the same as `build_example` does.

    Raises:
        BadSetting: the package is not installed, or not all of it.
    """
    example = EXAMPLES[name]
    model, _ = load_example(example)

    def fit() -> tuple[Capsule, ...]:
        # Brings scipy's optimiser with it, which is slow to import.
        from scenes.robots.fitting import build_example

        return build_example(example).capsules

    return example.robot(model, _stored(name, ("fitting", "example_data"), PACKAGE, fit))


def stored_file(key: str) -> Robot:
    """Return a robot of a registered file.

    Raises:
        BadInputFile: it or a mesh cannot be read.
    """
    from scenes.robots.urdf_file import fit_capsules, load_arm

    arm = load_arm(key)
    sources = ("fitting", "robot_files", "urdf_chain", "urdf_file")
    return arm.robot(_stored(key, sources, "yourdfpy", lambda: fit_capsules(arm)))


def _stored(name: str, sources: tuple[str, ...], package: str, fit: Callable[[], tuple[Capsule, ...]]) -> tuple[Capsule, ...]:
    """Return a robot's capsules, fitted again if one of these sources of ours, or the package, has changed."""
    files = [Path(__file__).with_name(f"{source}.py") for source in ("stored", *sources)]
    key = glb.source_key(files, name, *(importlib.metadata.version(one) for one in (package, "scipy", "pin")))

    def build() -> tuple[bytes, ...]:
        return tuple(np.concatenate([[c.joint], c.start, c.end, [c.radius]]).tobytes() + c.name.encode() for c in fit())

    capsules: list[Capsule] = []
    for blob in glb.cached(f"{name}-capsules", key, build):
        n = np.frombuffer(blob[:64])
        capsules.append(Capsule(blob[64:].decode(), int(n[0]), n[1:4].copy(), n[4:7].copy(), float(n[7])))
    return tuple(capsules)
