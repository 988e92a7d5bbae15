"""The arms: the paper's, two of the package example-robot-data, and those added at the start.

Capsules are cached, as fitting takes most of a second.
"""

import importlib.metadata
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Final, get_args

import numpy as np
import pinocchio as pin

from controllers.errors import BadSetting
from scenes.given_robots import GIVEN
from scenes.lwr import facts
from scenes.lwr.urdf import FLANGE, URDF_FILE
from scenes.robots.description import Capsule, Robot
from scenes.robots.example_data import EXAMPLES, PACKAGE, load_example
from scenes.setting_spec import start_remedy
from scenes.settings import RobotName

SOURCES: Final = sorted(Path(__file__).parent.glob("*.py"))
"""A change of one of these files rebuilds the stored data of robots."""


@cache
def robot(name: str) -> Robot:
    """Robot by its name, cached and shared: do not change it.

    Raises:
        BadSetting: unknown robot, or its package is not installed.
        BadInputFile: a given robot cannot be read.
    """
    if name == "lwr":
        capsules = tuple(
            Capsule(c.name, c.link, np.array([0.0, 0.0, c.start]), np.array([0.0, 0.0, c.end]), c.radius)
            for c in facts.CAPSULES
        )
        return Robot(
            "lwr",
            "KUKA LWR 4+",
            pin.buildModelFromUrdf(str(URDF_FILE)),
            FLANGE,
            2,
            4,
            6,
            capsules,
            facts.JOINT_LABELS,
        )
    if name in GIVEN:
        given = GIVEN[name]
        return given.made(_stored(name, "trimesh", given.fitted, given.sources()))
    if name not in get_args(RobotName):
        if remedy := start_remedy(name):
            raise BadSetting(remedy)
        raise BadSetting(
            "There is no robot {name!r}; choose from {known}.",
            name=name,
            known=", ".join(get_args(RobotName)),
        )
    return _example_robot(name)


def _example_robot(name: str) -> Robot:
    example = EXAMPLES[name]
    model, _ = load_example(example)

    def fit() -> tuple[Capsule, ...]:
        # Brings scipy's optimiser with it, which is slow to import.
        from scenes.robots.fitting import fit_example

        return fit_example(example)

    return example.robot(model, _stored(name, PACKAGE, fit))


def _stored(
    name: str, package: str, fit: Callable[[], tuple[Capsule, ...]], sources: Sequence[Path] = ()
) -> tuple[Capsule, ...]:
    """Capsules, fitted again after a change of a source or the package."""
    # The LWR does without.
    from scenes import glb

    key = glb.source_key(
        [*SOURCES, *sources], name, *(importlib.metadata.version(one) for one in (package, "scipy", "pin"))
    )

    def build() -> tuple[bytes, ...]:
        return tuple(
            np.concatenate([[c.joint], c.start, c.end, [c.radius]]).tobytes() + c.name.encode() for c in fit()
        )

    capsules: list[Capsule] = []
    for blob in glb.cached(f"{name}-capsules", key, build):
        n = np.frombuffer(blob[:64])
        capsules.append(Capsule(blob[64:].decode(), int(n[0]), n[1:4].copy(), n[4:7].copy(), float(n[7])))
    return tuple(capsules)
