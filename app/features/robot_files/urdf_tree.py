"""Strict reader of URDF files, versions 1.0 to 1.2.

It refuses unknown numbers, attributes and shapes, in which two lenient readers would find different arms.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from controllers.errors import BadInputFile
from controllers.kinematics import Array

VERSIONS: Final = ("1.0", "1.1", "1.2")

KINDS: Final = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical")

SHAPES: Final = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
    "mesh": ("filename", "scale"),
}

GREATEST: Final = 1e6
"""Greatest position or size [m, rad]."""

_NUMBER: Final = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_ANY_NUMBER: Final = re.compile(rf"{_NUMBER.pattern}|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE)


@dataclass(frozen=True)
class Box:
    """Sides along x, y and z [m]; at most one is 0."""

    size: tuple[float, ...]


@dataclass(frozen=True)
class Cylinder:
    """About z [m]; a length of 0 is a disc."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere with its radius [m]."""

    radius: float


@dataclass(frozen=True)
class Pill:
    """About z [m]; length between the centres of the half spheres."""

    radius: float
    length: float


@dataclass(frozen=True)
class MeshFile:
    """`scale`: along x, y and z."""

    filename: str
    scale: tuple[float, ...]


ShapeForm = Box | Cylinder | Sphere | Pill | MeshFile


@dataclass(frozen=True)
class Shape:
    """`pose`: (4, 4) in the link's frame [m]. `colour`: red, green, blue in 0 … 1, or None."""

    form: ShapeForm
    pose: Array
    colour: tuple[float, ...] | None


@dataclass(frozen=True)
class Link:
    name: str
    visuals: tuple[Shape, ...]
    collisions: tuple[Shape, ...]


@dataclass(frozen=True)
class UrdfJoint:
    """A joint.

    Attributes:
        pose: (4, 4) of the child in the parent's frame at angle 0 [m].
        axis: (3,), not normalised.
        lower, upper, velocity: as in the file [rad, rad/s], or None.
        mimic: True if it follows another joint.
        origin, direction: <origin> and axis, as in the file.
    """

    name: str
    kind: str
    parent: str
    child: str
    pose: Array
    axis: Array
    lower: float | None
    upper: float | None
    velocity: float | None
    mimic: bool
    origin: dict[str, str] = field(default_factory=dict)
    direction: str = "1 0 0"


@dataclass(frozen=True)
class UrdfTree:
    """Links and joints in the order of the file, with unique names; `root`: link without a parent."""

    version: str
    links: tuple[Link, ...]
    joints: tuple[UrdfJoint, ...]
    root: str


def short(name: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in name)[:40]


def read_urdf(text: bytes, name: str) -> UrdfTree:
    """Raises `BadInputFile` if damaged, not a URDF file, or ambiguous."""
    return _UrdfReader(name).robot(_root(text, name))


def _root(text: bytes, name: str) -> Element:
    try:
        robot = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BadInputFile(
            "{name}: is not a URDF file: its XML is damaged ({reason}).", name=name, reason=str(error)
        ) from None
    space = re.match(r"\{.*\}", robot.tag)
    for part in robot.iter():
        # A default namespace on <robot> changes nothing.
        part.tag = part.tag.removeprefix(space[0]) if space else part.tag
    if robot.tag != "robot":
        raise BadInputFile(
            "{name}: is not a URDF file: it begins with <{tag}>, a URDF with <robot>.",
            name=name,
            tag=str(robot.tag)[:40],
        )
    unexpanded = re.compile(r"\$[{(]")
    if any("xacro" in part.tag or any(map(unexpanded.search, part.attrib.values())) for part in robot.iter()):
        raise BadInputFile(
            "{name}: is xacro, from which a URDF is made: run `xacro {name} > robot.urdf` and give that file.",
            name=name,
        )
    if robot.find("link") is None:
        raise BadInputFile("{name}: is not a URDF file with a robot: it has no links.", name=name)
    return robot


class _UrdfReader:
    def __init__(self, name: str) -> None:
        self._name = name
        self._version = VERSIONS[0]
        self._colours: dict[str, tuple[float, ...]] = {}

    def robot(self, robot: Element) -> UrdfTree:
        self._version = robot.get("version", VERSIONS[0]).strip()
        if self._version not in VERSIONS:
            raise self._fault(
                f"is URDF of version {short(self._version)!r}; Duet reads the versions {', '.join(VERSIONS)}"
            )
        for material in robot.findall("material"):
            called, colour = self._called(material, "material"), self._colour(material, "robot")
            if called in self._colours:
                raise self._fault(f"two materials have the name {short(called)}; give each its own")
            if colour is not None:
                self._colours[called] = colour
        links = tuple(map(self._link, robot.findall("link")))
        joints = tuple(map(self._joint, robot.findall("joint")))
        for kind, names in (
            ("links", [link.name for link in links]),
            ("joints", [joint.name for joint in joints]),
        ):
            if twice := next((one for one in names if names.count(one) > 1), None):
                raise self._fault(
                    f"{names.count(twice)} {kind} have the name {short(twice)}; give each its own"
                )
        return UrdfTree(self._version, links, joints, self._tree_root(links, joints))

    def _tree_root(self, links: Sequence[Link], joints: Sequence[UrdfJoint]) -> str:
        names = {link.name for link in links}
        for joint in joints:
            for end in (joint.parent, joint.child):
                if end not in names:
                    raise self._fault(
                        f"its joint {short(joint.name)} is at the link {short(end)}, which is not in the file"
                    )
        on = [joint.child for joint in joints]
        if len(set(on)) != len(on):
            raise BadInputFile("{name}: a link hangs on two joints; an arm is one chain.", name=self._name)
        roots = [link.name for link in links if link.name not in set(on)]
        if len(roots) != 1:
            raise BadInputFile(
                "{name}: has {count} links without a parent; an arm has one, its base.",
                name=self._name,
                count=len(roots),
            )
        children: dict[str, list[str]] = {}
        for joint in joints:
            children.setdefault(joint.parent, []).append(joint.child)
        waiting, seen = list(roots), set(roots)
        while waiting:
            found = children.get(waiting.pop(), [])
            waiting += found
            seen.update(found)
        if lost := sorted(names - seen):
            raise self._fault(
                f"its link {short(lost[0])} hangs in a circle of joints; an arm is one chain from its base"
            )
        return roots[0]

    def _link(self, link: Element) -> Link:
        name = self._called(link, "link")
        place = f"link {short(name)}"
        return Link(
            name,
            tuple(self._shape(one, f"{place}, visual") for one in link.findall("visual")),
            tuple(self._shape(one, f"{place}, collision") for one in link.findall("collision")),
        )

    def _shape(self, part: Element, place: str) -> Shape:
        geometry = self._only(part, "geometry", place)
        forms = [] if geometry is None else list(geometry)
        if len(forms) != 1:
            plural = "s" if len(forms) > 1 else ""
            raise self._fault(
                f"{place}: it has {len(forms) or 'no'} shape{plural} in its <geometry>; give one"
            )
        material = self._only(part, "material", place)
        colour = None
        if material is not None:
            colour = self._colour(material, place) or self._colours.get(material.get("name", ""))
        return Shape(
            self._form(forms[0], place), self._pose(self._only(part, "origin", place), place), colour
        )

    def _form(self, form: Element, place: str) -> ShapeForm:
        if form.tag not in SHAPES:
            raise self._fault(f"{place}: its shape is <{short(form.tag)}>; Duet reads {', '.join(SHAPES)}")
        self._check_attributes(form, SHAPES[form.tag], place)
        if form.tag == "mesh":
            filename = form.get("filename", "")
            if not filename.strip():
                raise self._fault(f"{place}: its mesh has no filename")
            scale = self._numbers(form, "scale", (1, 3), place, (1.0, 1.0, 1.0))
            scale = scale * 3 if len(scale) == 1 else scale
            if scale.count(0.0) > 1:
                raise self._fault(
                    f"{place}: its mesh has the scale {_shown(scale)}, which leaves a line or a point of it"
                )
            return MeshFile(filename, scale)
        if form.tag == "box":
            size = self._numbers(form, "size", (3,), place)
            if min(size) < 0.0 or size.count(0.0) > 1:
                raise self._fault(f"{place}: its box has the size {_shown(size)} m; give positive lengths")
            return Box(size)
        radius, *rest = (self._numbers(form, key, (1,), place)[0] for key in SHAPES[form.tag])
        if not radius > 0.0 or any(length < 0.0 for length in rest):
            raise self._fault(
                f"{place}: its {form.tag} measures {_shown((radius, *rest))} m; give positive lengths"
            )
        if not rest:
            return Sphere(radius)
        return Pill(radius, rest[0]) if form.tag == "capsule" else Cylinder(radius, rest[0])

    def _joint(self, joint: Element) -> UrdfJoint:
        name, kind = self._called(joint, "joint"), joint.get("type", "")
        place = f"joint {short(name)}"
        if kind not in KINDS:
            raise self._fault(f"{place}: its type is {short(kind)!r}; URDF knows {', '.join(KINDS)}")
        ends: list[str] = []
        for key in ("parent", "child"):
            end = self._only(joint, key, place)
            if end is None or not end.get("link"):
                raise self._fault(f"{place}: it names no {key} link")
            ends.append(end.attrib["link"])
        origin, axis, limit = (self._only(joint, key, place) for key in ("origin", "axis", "limit"))
        direction = "1 0 0"
        if axis is not None:
            self._check_attributes(axis, ("xyz",), place)
            direction = axis.get("xyz", "")
            self._numbers(axis, "xyz", (3,), place)
        bounds = {key: self._bound(limit, key, place) for key in ("lower", "upper", "velocity")}
        return UrdfJoint(
            name=name,
            kind=kind,
            parent=ends[0],
            child=ends[1],
            pose=self._pose(origin, place),
            axis=np.array(list(map(float, direction.split()))),
            **bounds,
            mimic=joint.find("mimic") is not None,
            origin={} if origin is None else dict(origin.attrib),
            direction=direction,
        )

    def _bound(self, limit: Element | None, key: str, place: str) -> float | None:
        text = None if limit is None else limit.get(key)
        if text is None:
            return None
        if not _ANY_NUMBER.fullmatch(text.strip()):
            raise self._fault(f"{place}: its limit has {key} = {short(text)!r}, which is not a number")
        return float(text)

    def _pose(self, origin: Element | None, place: str) -> Array:
        if origin is None:
            return np.eye(4)
        # Slow to import.
        from trimesh import transformations

        self._check_attributes(origin, ("xyz", "rpy", "quat_xyzw"), place)
        if "quat_xyzw" in origin.attrib:
            if self._version == VERSIONS[0]:
                raise self._fault(
                    f"{place}: its <origin> has quat_xyzw, which URDF has from version 1.1 on; give the robot the version 1.1, or write rpy"
                )
            if "rpy" in origin.attrib:
                raise self._fault(
                    f"{place}: its <origin> has a turn as rpy and another one as quat_xyzw; leave one out"
                )
            x, y, z, w = self._numbers(origin, "quat_xyzw", (4,), place)
            if not np.linalg.norm((x, y, z, w)) > 1e-6:
                raise self._fault(f"{place}: its quat_xyzw is {_shown((x, y, z, w))}, which is not a turn")
            pose = transformations.quaternion_matrix((w, x, y, z))
        else:
            pose = transformations.compose_matrix(
                angles=self._numbers(origin, "rpy", (3,), place, (0.0, 0.0, 0.0))
            )
        pose[:3, 3] = self._numbers(origin, "xyz", (3,), place, (0.0, 0.0, 0.0))
        return pose

    def _colour(self, material: Element, place: str) -> tuple[float, ...] | None:
        colour = self._only(material, "color", place)
        if colour is None:
            return None
        return tuple(min(max(share, 0.0), 1.0) for share in self._numbers(colour, "rgba", (3, 4), place)[:3])

    def _called(self, part: Element, kind: str) -> str:
        if not (name := part.get("name", "")).strip():
            raise self._fault(f"one of its {kind}s has no name")
        return name

    def _only(self, part: Element, tag: str, place: str) -> Element | None:
        found = part.findall(tag)
        if len(found) > 1:
            raise self._fault(f"{place}: it has {len(found)} <{tag}>; give one")
        return found[0] if found else None

    def _check_attributes(self, part: Element, known: Sequence[str], place: str) -> None:
        for key in part.attrib:
            if key not in known:
                raise self._fault(
                    f"{place}: its <{part.tag}> has {short(key)}, which Duet does not read; it reads {', '.join(known)}"
                )

    def _numbers(
        self,
        part: Element,
        key: str,
        counts: Sequence[int],
        place: str,
        usual: tuple[float, ...] | None = None,
    ) -> tuple[float, ...]:
        """Finite numbers. `counts`: allowed lengths. `usual`: default."""
        text = part.get(key)
        if text is None:
            if usual is None:
                raise self._fault(f"{place}: its <{part.tag}> has no {key}")
            return usual
        parts = text.split()
        if len(parts) not in counts or not all(map(_NUMBER.fullmatch, parts)):
            wanted = f"{counts[-1]} numbers with spaces between them" if counts[-1] > 1 else "a number"
            raise self._fault(f"{place}: its <{part.tag}> has {key} = {short(text)!r}; give {wanted}")
        numbers = tuple(map(float, parts))
        if max(map(abs, numbers)) > GREATEST:
            raise self._fault(f"{place}: its <{part.tag}> has {key} = {short(text)!r}, which is too large")
        return numbers

    def _fault(self, text: str) -> BadInputFile:
        return BadInputFile(f"{self._name}: {text}.")


def _shown(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:g}" for number in numbers)
