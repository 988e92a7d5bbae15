"""Robots from URDF files that were given when this process started: the setting `robot` names them by file name and content."""

import hashlib
import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final
from xml.etree import ElementTree

from controllers.errors import BadInputFile, first_line
from scenes.files import input_content
from scenes.robots.urdf_chain import chain_model, find_chain
from scenes.setting_spec import add_choice, added_choices

if TYPE_CHECKING:
    import yourdfpy

LARGEST_URDF: Final = 10_000_000
"""[B]"""

LARGEST_MESHES: Final = 64_000_000
"""All mesh files of a robot together [B]."""


@dataclass(frozen=True)
class RobotFile:
    """A URDF file and what it refers to.

    Attributes:
        key: name of the robot in the setting `robot`: the file's name and a hash of the content of the file and its meshes.
        path: of the file.
        text: its content.
        chain: names of the joints of its arm, base first.
        meshes: name of a mesh, as in the URDF → its file.
    """

    key: str
    path: Path
    text: bytes
    chain: tuple[str, ...]
    meshes: dict[str, Path]


FILES: Final[dict[str, RobotFile]] = {}
"""Key → file, of all that were given."""


def register(path: Path) -> str:
    """Make a URDF file a choice of the setting `robot` in this process and return its name there; raises as `robot_file`."""
    file = robot_file(path)
    FILES[file.key] = file
    add_choice("robot", file.key, file.key.rpartition("-")[0])
    return file.key


def robot_file(path: Path) -> RobotFile:
    """Return a URDF file with the places of its meshes.

    Raises:
        BadInputFile: it cannot be read, is no URDF, is too large, has no suitable chain of joints, or one of its meshes is missing.
    """
    text = input_content(path, LARGEST_URDF, larger=_too_large(path, LARGEST_URDF))
    urdf = parsed(text, str(path))
    chain = find_chain(urdf, str(path))
    chain_model(text, chain, str(path))
    names = dict.fromkeys(
        part.geometry.mesh.filename
        for link in urdf.robot.links
        for part in (*link.visuals, *link.collisions)
        if part.geometry is not None and part.geometry.mesh is not None
    )
    digest, meshes, left = hashlib.sha256(text), {}, LARGEST_MESHES
    for name in names:
        file = _mesh_file(path, name)
        content = input_content(file, left, larger=_too_large(f"{path}: its meshes", LARGEST_MESHES))
        left -= len(content)
        digest.update(content)
        meshes[name] = file
    stem = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-")[:24] or "robot"
    return RobotFile(f"{stem}-{digest.hexdigest()[:12]}", path.absolute(), text, chain, meshes)


GivenAtStart = tuple[dict[str, RobotFile], dict[str, dict[str, str]]]


def given_at_start() -> GivenAtStart:
    """Return the files and choices that only this process knows, for its workers."""
    return FILES, added_choices()


def take_over(given: GivenAtStart) -> None:
    """Know in a worker what the process knows that started it."""
    files, choices = given
    FILES.update(files)
    for key, labels in choices.items():
        for value, label in labels.items():
            add_choice(key, value, label)


def parsed(text: bytes, name: str) -> "yourdfpy.URDF":
    """Return a URDF as yourdfpy reads it, without meshes.

    Raises:
        BadInputFile: it is no URDF.
    """
    import yourdfpy

    bare = dict.fromkeys(("load_meshes", "load_collision_meshes", "build_scene_graph", "build_collision_scene_graph"), False)
    try:
        _check_xml(text, name)
        return yourdfpy.URDF.load(io.BytesIO(text), **bare)
    except BadInputFile:
        raise
    except Exception as error:
        # On a damaged file lxml and yourdfpy raise nearly every kind there is.
        raise BadInputFile("{name}: is no URDF file ({reason}).", name=name, reason=first_line(error)) from None


def _check_xml(text: bytes, name: str) -> None:
    """Refuse what a lenient reader takes for a robot.

    Raises:
        BadInputFile: it is damaged, other XML, still to be expanded by xacro, or has no link.
    """
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise BadInputFile("{name}: is no URDF file: its XML is damaged ({reason}).", name=name, reason=str(error)) from None
    if robot.tag != "robot":
        raise BadInputFile(
            "{name}: is no URDF file: it begins with <{tag}>, a URDF with <robot>.", name=name, tag=str(robot.tag)[:40]
        )
    if any("xacro" in str(part.tag) for part in robot.iter()):
        raise BadInputFile(
            "{name}: is xacro, from which a URDF is made: run `xacro {name} > robot.urdf` and give that file.", name=name
        )
    if robot.find("link") is None:
        raise BadInputFile("{name}: is no URDF file with a robot: it has no links.", name=name)


def _too_large(name: Path | str, limit: int) -> BadInputFile:
    return BadInputFile(
        "{name}: larger than {size} MB, more than can be drawn here; give a robot with simpler meshes.",
        name=name,
        size=limit // 1_000_000,
    )


def _mesh_file(urdf: Path, name: str) -> Path:
    """Return the file of a mesh: relative to the URDF file, or of a ROS package that is one of the folders around it or in one.

    Raises:
        BadInputFile: there is none.
    """
    rest = name.removeprefix("file://")
    folders = [urdf.absolute().parent]
    if name.startswith("package://"):
        rest = name.removeprefix("package://")
        folders = list(urdf.absolute().parents)
    for folder in folders:
        if (file := folder / rest).is_file():
            return file
    raise BadInputFile(
        "{name}: the mesh {mesh} is missing; put it in its place beside the URDF file, or in a folder of the package's name above it.",
        name=urdf,
        mesh=name,
    )
