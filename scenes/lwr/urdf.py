"""Writes `lwr.urdf` from `facts`: python -m scenes.lwr.urdf.

yourdfpy cannot read <capsule>: a capsule is a cylinder and two spheres.

KUKA publishes no inertias. A link is a solid uniform cylinder with its mass, as thick as its capsule and as
long as its share of the segment (whose links meet at the roll joint), about its centre of mass: the tensor is
positive definite and satisfies the triangle inequality.
"""

from pathlib import Path
from typing import Final
from xml.etree import ElementTree as xml

from scenes.lwr.facts import CAPSULES, CENTRES_OF_MASS, JOINTS, MASSES, CapsuleFact

URDF_FILE: Final = Path(__file__).with_name("lwr.urdf")

FLANGE: Final = "flange"


def capsule_share(link: int) -> tuple[CapsuleFact, float, float]:
    """Capsule of a link, and the link's part of its axis, z from … to in the link's frame [m]."""
    carrier = max(capsule.link for capsule in CAPSULES if capsule.link <= link)
    capsule = next(capsule for capsule in CAPSULES if capsule.link == carrier)
    roll = JOINTS[carrier].origin
    return (capsule, capsule.start, roll) if link == carrier else (capsule, 0.0, capsule.end - roll)


def link_inertia(link: int) -> tuple[float, float, float]:
    """Principal moments (xx, yy, zz) about the centre of mass, along the link's axes [kg m²]."""
    capsule, start, end = capsule_share(link)
    m, r, h = MASSES[link], capsule.radius, end - start
    across = m * (3 * r**2 + h**2) / 12
    return across, across, m * r**2 / 2


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.10g}" for value in values)


def _shape(
    parent: xml.Element,
    tag: str,
    z: float,
    radius: float,
    length: float | None = None,
    material: str | None = None,
) -> None:
    element = xml.SubElement(parent, tag)
    xml.SubElement(element, "origin", xyz=_numbers(0, 0, z), rpy="0 0 0")
    geometry = xml.SubElement(element, "geometry")
    if length is None:
        xml.SubElement(geometry, "sphere", radius=_numbers(radius))
    else:
        xml.SubElement(geometry, "cylinder", radius=_numbers(radius), length=_numbers(length))
    if material:
        xml.SubElement(element, "material", name=material)


def _link(robot: xml.Element, number: int) -> None:
    link = xml.SubElement(robot, "link", name=f"link{number}")
    inertial = xml.SubElement(link, "inertial")
    xml.SubElement(inertial, "origin", xyz=_numbers(*CENTRES_OF_MASS[number]), rpy="0 0 0")
    xml.SubElement(inertial, "mass", value=_numbers(MASSES[number]))
    xx, yy, zz = link_inertia(number)
    xml.SubElement(
        inertial, "inertia", ixx=_numbers(xx), ixy="0", ixz="0", iyy=_numbers(yy), iyz="0", izz=_numbers(zz)
    )

    capsule, start, end = capsule_share(number)
    colour = "anthracite" if number in (0, 6, 7) else "orange"
    _shape(link, "visual", (start + end) / 2, 0.8 * capsule.radius, end - start, colour)
    if number == capsule.link > 0:
        _shape(link, "visual", 0.0, 0.9 * capsule.radius, material=colour)
    if number == capsule.link:
        _shape(
            link, "collision", (capsule.start + capsule.end) / 2, capsule.radius, capsule.end - capsule.start
        )
        for z in (capsule.start, capsule.end):
            _shape(link, "collision", z, capsule.radius)


def lwr_urdf() -> str:
    """One arm as XML: links link0 … link7, joints j1 … j7, and a fixed frame "flange"; SI units."""
    robot = xml.Element("robot", name="lwr4plus")
    for name, rgba in (("orange", "0.95 0.41 0.05 1"), ("anthracite", "0.17 0.18 0.21 1")):
        xml.SubElement(xml.SubElement(robot, "material", name=name), "color", rgba=rgba)
    for number in range(len(MASSES)):
        _link(robot, number)
    xml.SubElement(robot, "link", name=FLANGE)
    for number, fact in enumerate(JOINTS):
        joint = xml.SubElement(robot, "joint", name=fact.name, type="revolute")
        xml.SubElement(joint, "parent", link=f"link{number}")
        xml.SubElement(joint, "child", link=f"link{number + 1}")
        xml.SubElement(joint, "origin", xyz=_numbers(0, 0, fact.origin), rpy="0 0 0")
        xml.SubElement(joint, "axis", xyz=_numbers(*fact.axis))
        xml.SubElement(
            joint,
            "limit",
            lower=repr(-fact.position_limit),
            upper=repr(fact.position_limit),
            velocity=repr(fact.velocity_limit),
            effort=_numbers(fact.torque_limit),
        )
    fixed = xml.SubElement(robot, "joint", name=f"{FLANGE}_joint", type="fixed")
    xml.SubElement(fixed, "parent", link=f"link{len(JOINTS)}")
    xml.SubElement(fixed, "child", link=FLANGE)
    xml.SubElement(fixed, "origin", xyz="0 0 0", rpy="0 0 0")
    xml.indent(robot)
    note = "<!-- KUKA LWR 4+. Written by scenes/lwr/urdf.py from scenes/lwr/facts.py: change those, not this file. -->"
    return f'<?xml version="1.0"?>\n{note}\n{xml.tostring(robot, encoding="unicode")}\n'


if __name__ == "__main__":
    URDF_FILE.write_text(lwr_urdf(), encoding="utf-8")
