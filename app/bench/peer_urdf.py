"""Our model as URDF, for the peers that read one: the same joints, one link a capsule, the avoiding hand as the link "hand"."""

import xml.etree.ElementTree as ElementTree
from typing import Final

import numpy as np
import pinocchio as pin

from app.bench.peer_method import Baked
from controllers.kinematics import Array

ENOUGH: Final = 100.0
"""More than any joint's speed, or than any joint's angle."""

HAND: Final = "hand"


def urdf_text(baked: Baked, ground: str = "universe") -> str:
    """Return the URDF. Every capsule is a cylinder under its own name, the guided arm has no bounds, and nothing has a mass.

    Args:
        ground: name of the link that everything stands on.
    """
    model, root = baked.room.model, ElementTree.Element("robot", name="duet")
    data = model.createData()
    pin.forwardKinematics(model, data, np.ones(model.nq))
    ElementTree.SubElement(root, "link", name=ground)
    for i in range(1, model.njoints):
        name, column = model.names[i], model.joints[i].idx_v
        joint, _ = _link(root, name, "revolute", _body(model, model.parents[i], ground), f"body {name}", model.jointPlacements[i])
        # The axis in the joint's own frame, whatever kind of revolute joint it is.
        axis = pin.log3(model.jointPlacements[i].actInv(data.liMi[i]).rotation)
        ElementTree.SubElement(joint, "axis", xyz=_text(axis / np.linalg.norm(axis)))
        low, high, speed = model.lowerPositionLimit[column], model.upperPositionLimit[column], model.velocityLimit[column]
        if baked.guided.start <= column < baked.guided.stop:
            low, high, speed = -ENOUGH, ENOUGH, ENOUGH
        bounds = {"lower": _text(low), "upper": _text(high), "velocity": _text(speed), "effort": "1000"}
        ElementTree.SubElement(joint, "limit", bounds)
    for capsule in baked.room.geometry.geometryObjects:
        parent, name, shape = _body(model, capsule.parentJoint, ground), capsule.name, capsule.geometry
        _, link = _link(root, f"at {name}", "fixed", parent, name, capsule.placement)
        geometry = ElementTree.SubElement(ElementTree.SubElement(link, "collision", name=name), "geometry")
        ElementTree.SubElement(geometry, "cylinder", radius=_text(shape.radius), length=_text(2.0 * shape.halfLength))
        # Pinocchio reads a cylinder with this mark as a capsule.
        ElementTree.SubElement(ElementTree.SubElement(link, "collision_checking"), "capsule", name=name)
    frame = model.frames[baked.hand]
    _link(root, "at hand", "fixed", _body(model, frame.parentJoint, ground), HAND, frame.placement)
    return ElementTree.tostring(root, encoding="unicode")


def _body(model: pin.Model, joint: int, ground: str) -> str:
    return f"body {model.names[joint]}" if joint else ground


def _link(
    root: ElementTree.Element, name: str, kind: str, parent: str, child: str, placement: pin.SE3
) -> tuple[ElementTree.Element, ElementTree.Element]:
    """Add a link behind a new joint; return the joint and the link."""
    link = ElementTree.SubElement(root, "link", name=child)
    joint = ElementTree.SubElement(root, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=_text(placement.translation), rpy=_text(pin.rpy.matrixToRpy(placement.rotation)))
    return joint, link


def _text(numbers: Array | float) -> str:
    return " ".join(repr(number) for number in np.atleast_1d(numbers).tolist())
