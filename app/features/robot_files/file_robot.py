"""A robot from a URDF file."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.features.robot_files.robot_file import RobotFile, robot_file
from app.features.robot_files.urdf_file import fit_capsules, load_arm, solids
from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.given_robots import GivenRobot, give
from scenes.robots.description import Capsule, Robot

SOURCES: Final = tuple(sorted(Path(__file__).parent.glob("*.py")))

DARK: Final = 70.0
"""A part is dark below this mean of red, green and blue, 0 … 255."""


@dataclass(frozen=True)
class FileRobot(GivenRobot):
    file: RobotFile

    @property
    def key(self) -> str:
        return self.file.key

    @property
    def label(self) -> str:
        return self.file.key.rpartition("-")[0]

    @property
    def remark(self) -> str:
        return self.file.guesses

    @property
    def origin(self) -> Path:
        return self.file.path

    def sources(self) -> tuple[Path, ...]:
        return SOURCES

    def column(self) -> float:
        return load_arm(self.file).column

    def fitted(self) -> tuple[Capsule, ...]:
        return fit_capsules(load_arm(self.file))

    def made(self, capsules: tuple[Capsule, ...]) -> Robot:
        return load_arm(self.file).robot(capsules)

    def shapes(self) -> Iterator[tuple[int, str, Array, NDArray[np.int64]]]:
        arm = load_arm(self.file)
        shapes = list(solids(arm, "visuals")) or list(solids(arm, "collisions"))
        lights = np.array([float(np.mean(one.colour)) for one in shapes])
        areas = np.array([float(one.mesh.area) for one in shapes])
        # A completely dark arm gets the colour of its side, too.
        darkest = DARK if areas[lights >= DARK].sum() > 0.3 * areas.sum() else -1.0
        for one, light in zip(shapes, lights.tolist(), strict=True):
            yield (
                one.joint,
                "dark" if light < darkest else "body",
                np.asarray(one.mesh.vertices),
                np.asarray(one.mesh.faces),
            )

    def check_files(self) -> None:
        path, file = self.file.path, self.file
        if file.meshes and robot_file(path, file.chain.hand).key != file.key:
            raise BadInputFile(
                f"{path}: is another file on a worker; put the same one and its meshes there, under the same path."
            )


def register(path: Path, hand: str = "") -> str:
    """Add a URDF file to this process's setting `robot`; returns its name. Raises as `robot_file`."""
    return give(FileRobot(robot_file(path, hand)))
