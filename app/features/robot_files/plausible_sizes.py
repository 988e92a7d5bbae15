"""Check of shapes: sizes reveal wrong units and plates."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
import pinocchio as pin

from app.features.robot_files.urdf_tree import MeshFile, ShapeForm, short
from controllers.errors import BadInputFile
from controllers.kinematics import Array

if TYPE_CHECKING:
    import trimesh

ShapeKind = Literal["visuals", "collisions"]

LARGEST: Final = 2.0
"""Largest size of a link [arm lengths]."""

LARGEST_FOOT: Final = 4.0
"""Largest size of the foot [arm lengths]; a plate may be as wide as its arm is long."""

SMALLEST: Final = 0.005
"""Smallest size of a link [arm lengths]."""

FAR: Final = 4.0
"""Distance of a misplaced shape from its joint [arm lengths]."""

FLAT: Final = 0.05
"""Thickness of a plate [its size]."""

UNITS: Final = (("millimetres", 0.001), ("inches", 0.0254), ("centimetres", 0.01), ("feet", 0.3048))
"""Units of drawings [m]."""

USUAL: Final = 0.15
"""Usual size of a link [arm lengths]; selects the likely unit."""


@dataclass(frozen=True)
class Solid:
    """A shape of an arm.

    Attributes:
        mesh: in the frame of its joint [m].
        colour: (3,) in 0 … 255.
        pose: (4, 4) in the frame of its joint [m].
    """

    link: str
    joint: int
    form: ShapeForm
    mesh: trimesh.Trimesh
    colour: Array
    pose: Array


def arm_length(model: pin.Model) -> float:
    """Length along all joints [m]."""
    data = model.createData()
    pin.forwardKinematics(model, data, np.zeros(model.nq))
    return float(sum(np.linalg.norm(b.translation - a.translation) for a, b in pairwise(data.oMi[1:])))


def check_sizes(solids: Iterable[Solid], model: pin.Model, kind: ShapeKind, name: str) -> None:
    """Raises `BadInputFile` for a wrong size or position, with the likely cause."""
    length = arm_length(model)
    largest: dict[int, tuple[float, Solid]] = {}
    parts: dict[str, list[Solid]] = {}
    for solid in solids:
        parts.setdefault(solid.link, []).append(solid)
    word = "collision shapes" if kind == "collisions" else "drawn shapes"
    for link, found in parts.items():
        low = np.min([solid.mesh.bounds[0] for solid in found], axis=0)
        high = np.max([solid.mesh.bounds[1] for solid in found], axis=0)
        size = float((high - low).max())
        one = max(found, key=lambda solid: float(np.ptp(solid.mesh.bounds, axis=0).max()))
        thick, width, _ = np.sort(high - low).tolist()
        # A foot may be a frame or a pillar, larger than its arm.
        most = LARGEST if one.joint else LARGEST_FOOT
        if size > most * length or (one.joint == 0 and thick <= FLAT * size and width > length):
            raise _fault(name, link, word, size, length, _cause(one, length))
        away = float(np.linalg.norm(np.maximum(np.maximum(low, -high), 0.0)))
        if away > FAR * length:
            cause = "its <origin> is probably in other units than metres"
            raise BadInputFile(
                f"{name}: the {word} of its link {short(link)} are {away:.3g} m away from its joint, and its arm is "
                f"{length:.3g} m long; {cause}."
            )
        if size > largest.get(one.joint, (-1.0, one))[0]:
            largest[one.joint] = size, one
    # A small mark is allowed beside a link of usual size, and as the only drawing of a link.
    if kind == "visuals" and any(size > SMALLEST * length for size, _ in largest.values()):
        return
    for size, one in largest.values():
        if size <= SMALLEST * length:
            raise _fault(name, one.link, word, size, length, _cause(one, length))


def _fault(name: str, link: str, word: str, size: float, length: float, cause: str) -> BadInputFile:
    return BadInputFile(
        f"{name}: the {word} of its link {short(link)} are {size:.3g} m large, and its arm is {length:.3g} m long; {cause}."
    )


def _cause(solid: Solid, length: float) -> str:
    sides = np.sort(np.ptp(solid.mesh.bounds, axis=0))
    size, form = float(sides[-1]), solid.form
    if not isinstance(form, MeshFile):
        if size > length and sides[0] <= FLAT * size:
            return "it is probably a plate of the world, which is no part of an arm: remove it"
        return f"lengths in a URDF are in metres, and these are probably in {_unit(size, length) or 'another unit'}"
    called, unit = short(form.filename), _unit(size, length)
    scaled = any(part != 1.0 for part in form.scale)
    if unit is not None:
        scale = " ".join(f"{part * dict(UNITS)[unit]:g}" for part in form.scale)
        return f'its mesh {called} is probably in {unit}: give it scale="{scale}"'
    if size > length and sides[0] <= FLAT * size:
        return f"its mesh {called} is probably a plate of the world, which is no part of an arm: remove it"
    if size < length and scaled:
        return f'its mesh {called} is probably in metres already: leave out scale="{" ".join(f"{part:g}" for part in form.scale)}"'
    return f"its mesh {called} is probably not in metres: give it a{'nother' * scaled} scale"


def _unit(size: float, length: float) -> str | None:
    share = size / length
    usual = [
        (abs(np.log(share * factor / USUAL)), unit)
        for unit, factor in UNITS
        if SMALLEST < share * factor < LARGEST / 2.0
    ]
    return min(usual)[1] if share > 1.0 and usual else None
