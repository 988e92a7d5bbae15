"""A URDF file with its meshes."""

import hashlib
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.features.robot_files.joint_chain import Chain, find_chain
from app.features.robot_files.urdf_chain import USUAL_SPEED, chain_model, frame_names, hand_frame, top_speed
from app.features.robot_files.urdf_tree import MeshFile, UrdfTree, read_urdf, short
from controllers.errors import BadInputFile
from scenes.files import input_content

LARGEST_URDF: Final = 10_000_000
"""Largest file [B]."""

LARGEST_MESHES: Final = 64_000_000
"""Largest size of all meshes together [B]."""


MOST_NAMES: Final = 8


@dataclass(frozen=True)
class RobotFile:
    """A URDF file with the arm found in it.

    Attributes:
        key: file name, and a hash of file, meshes and a named hand.
        meshes: name in the URDF → file.
    """

    key: str
    path: Path
    text: bytes
    chain: Chain
    meshes: dict[str, Path]
    guesses: str


def robot_file(path: Path, hand: str = "") -> RobotFile:
    """Read a URDF file.

    Args:
        hand: link of the hand; "" for the likely one.

    Raises:
        BadInputFile: unreadable, not a URDF file, too large, or without a suitable chain, a mesh or that
            link.
    """
    text = input_content(path, LARGEST_URDF, larger=_too_large(path, LARGEST_URDF))
    tree = read_urdf(text, str(path))
    chain = find_chain(tree, str(path), hand)
    model, _ = chain_model(tree, chain.joints, str(path))
    forms = (shape.form for link in tree.links for shape in (*link.visuals, *link.collisions))
    names = dict.fromkeys(form.filename for form in forms if isinstance(form, MeshFile))
    digest, meshes, left = hashlib.sha256(text), {}, LARGEST_MESHES
    for name in names:
        file = _mesh_file(path, name)
        content = input_content(file, left, larger=_too_large(f"{path}: its meshes", LARGEST_MESHES))
        left -= len(content)
        digest.update(content)
        meshes[name] = file
    if hand:
        digest.update(b"hand " + hand.encode())
    stem = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-")[:24] or "robot"
    guesses = _guesses(tree, chain, *hand_frame(model))
    return RobotFile(
        f"{stem}-{digest.hexdigest()[:12]}", path.absolute(), text, chain, meshes, f"{path.name}: {guesses}"
    )


def _guesses(tree: UrdfTree, chain: Chain, hand: str, part: str) -> str:
    link = chain.hand or next(name for name, frame in frame_names(tree).items() if frame == hand)
    if chain.hand:
        how = ""
    elif part:
        how = f' (by "{part}" in its name; --hand-left or --hand-right LINK names another one)'
    else:
        how = " (the farthest link on the last joint; --hand-left or --hand-right LINK names another one)"
    said = (
        f"the arm has the {len(chain.joints)} joints {_listed(chain.joints)}, its hand is {short(link)}{how}."
    )
    if chain.still:
        said += f" Held still: {_listed(chain.still)}."
    slow = [j.name for j in tree.joints if j.name in chain.joints and top_speed(j) != j.velocity]
    if slow:
        said += f" Taken with {USUAL_SPEED:g} rad/s, as their own top speed is missing or not one of an arm: {_listed(slow)}."
    return said


def _listed(names: Sequence[str]) -> str:
    more = len(names) - MOST_NAMES
    return ", ".join(map(short, names[:MOST_NAMES])) + (f" and {more} more" if more > 0 else "")


def _too_large(name: Path | str, limit: int) -> BadInputFile:
    return BadInputFile(
        "{name}: larger than {size} MB, more than can be drawn here; give a robot with simpler meshes.",
        name=name,
        size=limit // 1_000_000,
    )


def _mesh_file(urdf: Path, name: str) -> Path:
    """Relative to the URDF file, or in a ROS package: a folder around it, or in one of these.

    Raises:
        BadInputFile: the file is missing.
    """
    rest = name.removeprefix("file://")
    folders = [urdf.absolute().parent]
    if name.startswith("package://"):
        rest = name.removeprefix("package://")
        folders = list(urdf.absolute().parents)
    for folder in folders:
        # Unlike `Path.is_file` it accepts a text that is too long for a name.
        if os.path.isfile(file := folder / rest):
            return file
    raise BadInputFile(
        "{name}: the mesh {mesh} is missing; put it next to the URDF file, or in a folder of the package's name above it.",
        name=urdf,
        mesh=name,
    )
