"""Robots of example-robot-data and of URDF files with their capsules from the user's cache: to fit them takes most of a second, and
all that comes of it is a few numbers each."""

import importlib.metadata
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


def stored_file(key: str) -> Robot:
    """Return a robot of a registered file.

    Raises:
        BadInputFile: it or a mesh cannot be read.
    """
    from scenes.robots.urdf_file import fit_capsules, load_arm

    arm = load_arm(key)
    sources = [
        Path(__file__).with_name(f"{source}.py") for source in ("fitting", "enclosing", "robot_files", "urdf_chain", "urdf_file")
    ]
    versions = (importlib.metadata.version(package) for package in ("yourdfpy", "scipy", "pin"))

    def fit() -> tuple[bytes, ...]:
        return tuple(
            np.concatenate([[c.joint], c.start, c.end, [c.radius]]).tobytes() + c.name.encode() for c in fit_capsules(arm)
        )

    capsules: list[Capsule] = []
    for blob in glb.cached(f"{key}-capsules", glb.source_key(sources, key, *versions), fit):
        n = np.frombuffer(blob[:64])
        capsules.append(Capsule(blob[64:].decode(), int(n[0]), n[1:4].copy(), n[4:7].copy(), float(n[7])))
    return arm.robot(tuple(capsules))
