"""Appearance of the LWR 4+: eight generated shells, in link frames and metres; z runs along the arm.

They are inside the collision capsules at every joint angle, so visible contact is contact in the model.

A pitch joint joins two shells side by side, which bulge to opposite sides of the y axis, alternately along
the arm. A roll joint joins two tubes with a thin dark ring.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from scenes import glb, surfaces
from scenes.glb import Material
from scenes.lwr import facts
from scenes.surfaces import (
    Array,
    join,
    moved,
    revolve,
    rounded,
    smooth_max,
    smooth_min,
    swollen,
    thinned_mesh,
)

if TYPE_CHECKING:
    import trimesh

ORANGE: Final = "#e15404"
SILVER: Final = "#c3c8ce"
ANTHRACITE: Final = "#2b2f35"
SLATE: Final = "#56616d"

PARTS: Final = ("body", "cover", "trim", "ring", "dark", "metal", "grip", "mark")


def _painted(body: Material, cover: Material, mark: Material) -> glb.GlbPalette:
    return {
        "body": body,
        "cover": cover,
        "trim": cover,
        "ring": Material("#24272c", 0.5, 0.2),
        "dark": Material(ANTHRACITE, 0.42, 0.1),
        "metal": Material("#aeb4bb", 0.3, 0.8),
        "grip": Material("#1d2024", 0.6, 0.05),
        "mark": mark,
    }


PALETTES: Final[Mapping[str, glb.GlbPalette]] = MappingProxyType(
    {
        "orange": _painted(
            Material(ORANGE, 0.4, 0.05), Material(SILVER, 0.34, 0.55), Material(ORANGE, 0.4, 0.05)
        ),
        "silver": _painted(
            Material("#cdd2d7", 0.36, 0.1), Material(SLATE, 0.38, 0.2), Material(SLATE, 0.4, 0.2)
        ),
        "ghost": dict.fromkeys(PARTS, Material("#2f7dff", 0.5, 0.0, 0.36)),
        "wish": dict.fromkeys(PARTS, Material("#d0246f", 0.5, 0.0, 0.24)),
    }
)

SEEN_THROUGH: Final = ("ghost", "wish")
"""Transparent palettes: of a second run, and of a desired posture."""

SECTIONS: Final = 56

SKIN: Final = 0.0008
"""Clearance of the shells inside the capsules [m]."""

COARSE_SHARE: Final = 0.08

FEW: Final = 24
"""Sections of revolved coarse parts; thinning would make them ragged."""

RAISED: Final = ("cover", "ring", "trim")

PROUD: Final = 0.0007
"""Additional height of coarse parts [m]; less than `SKIN`, to stay inside the capsules."""

GHOST_INSET: Final = 0.0012
COARSE_INSET: Final = 0.004
"""Reduction of a ghost's radius [m]."""

GAP: Final = 0.0012
"""Half of the slit of a pitch joint [m]."""

UP: Final = np.eye(3)
TO_MINUS_Y: Final = np.diag([-1.0, -1.0, 1.0])
FROM_JOINT_TO_MINUS_Y: Final = np.diag([1.0, -1.0, -1.0])
FROM_JOINT_TO_PLUS_Y: Final = np.diag([-1.0, 1.0, -1.0])

Y_UP: Final = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
"""Turns a shape revolved about z to +y."""

Parts: TypeAlias = "dict[str, trimesh.Trimesh]"


@dataclass(frozen=True)
class Casting:
    """Half of a pitch joint with its tube, from the roll joint (z = 0) to the pitch joint (z = length),
    bulging to +y; all in metres.

    Attributes:
        tube, drum: radii of the tube and of the housing about the pitch axis.
        ball, wall: radii of the capsule at the pitch joint and along the tube.
        slit: y of the plane between the two halves.
    """

    length: float
    tube: float
    drum: float
    ball: float
    wall: float
    slit: float = 0.0

    def form(self, p: Array) -> Array:
        x, y, z = p[..., 0], p[..., 1], p[..., 2]
        up = z - self.length
        radius, rho = np.hypot(x, y), np.hypot(x, up)
        lip = 0.004 * np.clip(1 - z / 0.007, 0, 1) ** 2
        tube = smooth_max(radius - (self.tube - lip), up, 0.02)
        drum = (
            (self.drum + self.ball)
            / 2
            * (((rho / self.drum) ** 2.6 + (np.abs(y) / self.ball) ** 2.6) ** (1 / 2.6) - 1)
        )
        body = smooth_min(tube, drum, 0.03)
        # The other half sweeps about the pitch axis: leave it its side as far as two bent tubes need it, then slant
        # out to the full tube.
        slant = np.maximum(rho - 1.22 * self.drum, 0)
        side = self.slit + GAP - 0.95 * slant**2 / (slant + 0.026) - y
        body = smooth_max(body, side, 0.016)
        body = smooth_max(body, y - 0.8 * (self.ball - SKIN), 0.006)
        limit = np.minimum(np.sqrt(radius**2 + up**2) - self.ball, np.maximum(radius - self.wall, up))
        return smooth_max(body, limit + SKIN, 0.004)

    def shell(self) -> trimesh.Trimesh:
        height = np.r_[0.0, 0.003, 0.008, np.linspace(0.02, self.length, 27)]
        blend = np.clip((height - 0.02) / (0.4 * self.length), 0, 1)
        spine = np.stack(
            [np.zeros(len(height)), (self.slit + 0.016) * blend**2 * (3 - 2 * blend), height], -1
        )
        return surfaces.skin(self.form, spine, np.zeros(len(height)), SECTIONS, 0.15, dome=20)

    def cover(self, coarse: bool) -> trimesh.Trimesh:
        return moved(_lid(self.ball - SKIN, coarse), Y_UP, (0, 0, self.length))

    def seam(self, coarse: bool) -> trimesh.Trimesh:
        r, y = self.drum - 0.0035, self.slit
        disc = revolve(
            [(0, y - 2 * GAP), (r, y - 2 * GAP), (r, y + 3 * GAP), (0, y + 3 * GAP)],
            FEW if coarse else SECTIONS,
        )
        return moved(join([disc, _groove(self.ball - SKIN, coarse)]), Y_UP, (0, 0, self.length))


def _lid(ball: float, coarse: bool) -> trimesh.Trimesh:
    edge, seat, rise, top = 0.53 * ball, 0.78 * ball, 0.835 * ball, 0.955 * ball
    if coarse:
        return revolve([(edge, seat), (edge, rise), (0.6 * edge, top - 0.3 * (top - rise)), (0.0, top)], FEW)
    bow = np.linspace(0.0, 1.0, 7)[1:]
    dome = np.stack([(edge - 0.002) * (1 - bow), rise + (top - rise) * (1 - (1 - bow) ** 2)], 1)
    return revolve(np.vstack([rounded([(edge, seat), (edge, rise), *dome[:1]], 0.0015, 3), dome[1:]]), 40)


def _groove(ball: float, coarse: bool) -> trimesh.Trimesh:
    edge, rise = 0.53 * ball, 0.812 * ball
    if coarse:
        return revolve([(edge + 0.0022, rise), (edge - 0.001, rise)], FEW)
    return revolve([(edge + 0.0022, rise - 0.003), (edge + 0.0022, rise), (edge - 0.001, rise)], 40)


def _ring(z: float, radius: float, coarse: bool) -> trimesh.Trimesh:
    return _hoop(radius - 0.012, radius, z - 0.0035, z + 0.0035, 0.0012, 2, coarse)


def _hoop(
    inner: float, outer: float, low: float, high: float, edge: float, steps: int, coarse: bool
) -> trimesh.Trimesh:
    if coarse:
        return revolve([(outer, low), (outer, high)], FEW)
    return revolve(rounded([(inner, low), (outer, low), (outer, high), (inner, high)], edge, steps), SECTIONS)


UPPER: Final = Casting(length=0.2, tube=0.0565, drum=0.0590, ball=0.070, wall=0.070)
SHOULDER: Final = Casting(length=0.2, tube=0.0580, drum=0.0605, ball=0.075, wall=0.075)
SHOULDER_UPPER: Final = Casting(length=0.2, tube=0.0565, drum=0.0605, ball=0.075, wall=0.070)
ELBOW_FORE: Final = Casting(length=0.2, tube=0.0540, drum=0.0590, ball=0.070, wall=0.065)
WRIST: Final = Casting(length=0.19, tube=0.0540, drum=0.0560, ball=0.065, wall=0.065, slit=0.013)


def _cast(casting: Casting, turn: Array, coarse: bool) -> Parts:
    parts, tube = {"body": casting.shell(), "cover": casting.cover(coarse)}, casting.tube
    if turn[2, 2] > 0:
        parts["ring"] = casting.seam(coarse)
        parts["trim"] = _hoop(tube - 0.002, tube + 0.0007, 0.012, 0.017, 0.0006, 1, coarse)
        return {name: moved(part, turn) for name, part in parts.items()}
    groove = moved(_groove(casting.ball - SKIN, coarse), Y_UP, (0, 0, casting.length))
    parts["ring"] = join([groove, _ring(0.0, tube - 0.001, coarse)])
    return {name: moved(part, turn, (0, 0, casting.length)) for name, part in parts.items()}


def _base(coarse: bool) -> Parts:
    edge = [(0, 0), (0.0742, 0), (0.0742, 0.010), (0.066, 0.0125)]
    pedestal = [(0.0615, 0.022), (0.0585, 0.060), (0.0585, 0.102), (0.0545, 0.106)]
    foot = rounded([*edge, *pedestal], 0.004)
    bolt = revolve(rounded([(0.0032, 0.008), (0.0032, 0.0135), (0, 0.0135)], 0.0008, 2), 12)
    turns = np.arange(8) * np.pi / 4 + np.pi / 8
    bolts = [moved(bolt, shift=(0.0695 * np.cos(a), 0.0695 * np.sin(a), 0)) for a in turns]
    if coarse:
        return {"dark": revolve(foot[::3], FEW), "ring": _ring(0.110, 0.0565, coarse)}
    return {"dark": revolve(foot, SECTIONS), "metal": join(bolts), "ring": _ring(0.110, 0.0565, coarse)}


def _wrist(coarse: bool) -> Parts:
    ball, slit = facts.CAPSULES[2].radius - SKIN, WRIST.slit - GAP
    radius, flat = ball - 0.001, 0.79 * ball
    bow = np.linspace(np.arcsin(-slit / radius) + 0.06, np.arcsin(flat / radius), 16)
    outline = [
        (0.04, -slit),
        (0.0575, -slit),
        *np.stack([radius * np.cos(bow), radius * np.sin(bow)], 1),
        (0.03, flat),
    ]
    to_minus_y = Y_UP @ np.diag([1.0, -1.0, -1.0])
    neck = rounded([(0.0465, 0.030), (0.0445, 0.045), (0.0365, 0.052), (0.0365, 0.058)], 0.006, 5)
    if coarse:
        outline, neck = [*outline[:2], *outline[2:-1:3], outline[-1]], neck[::3]
    around = FEW if coarse else SECTIONS
    return {
        "dark": join([moved(revolve(outline, around), to_minus_y), revolve(neck, around)]),
        "cover": moved(_lid(ball, coarse), to_minus_y),
        "ring": moved(_groove(ball, coarse), to_minus_y),
    }


def _tool(coarse: bool) -> Parts:
    """Link 7: flange disc and handle, which fills part of the hand capsule."""
    disc = rounded([(0.030, -0.019), (0.040, -0.019), (0.040, 0.0), (0.0, 0.0)], 0.0018, 3)
    neck = rounded(
        [(0.031, 0.0), (0.031, 0.006), (0.0235, 0.010), (0.0185, 0.019), (0.0185, 0.022)], 0.004, 3
    )
    palm = [(0.0200, 0.0255), (0.0212, 0.030), (0.0190, 0.040), (0.0182, 0.050)]
    grip_line = [*palm, (0.0194, 0.060), (0.0215, 0.069), (0.0205, 0.075)]
    knob = [(0.0215 * np.cos(a), 0.076 + 0.0105 * np.sin(a)) for a in np.linspace(0, np.pi / 2, 8)]
    mark = rounded([(0.015, 0.0215), (0.0202, 0.0215), (0.0202, 0.0255), (0.015, 0.0255)], 0.0008, 2)
    grip = np.vstack([[(0.017, 0.0255)], rounded(grip_line, 0.006, 3), knob])
    if coarse:
        return {
            "metal": join([revolve(disc[::3], FEW), revolve(neck[::3], FEW)]),
            "mark": revolve(mark[::3], FEW),
            "grip": revolve(np.vstack([grip_line, knob[2::2], knob[-1:]]), FEW // 2),
        }
    metal = join([revolve(disc, SECTIONS), revolve(neck, 36)])
    return {"metal": metal, "mark": revolve(mark, 40), "grip": revolve(grip, 36)}


@functools.cache
def link_meshes(coarse: bool) -> tuple[Parts, ...]:
    """Links 0 (base) … 7 (flange and handle): material → mesh in the link frame [m]. Shared: do not change
    them.

    Args:
        coarse: few triangles, for a browser without a graphics card.
    """
    links = (
        _base(coarse),
        _cast(SHOULDER, UP, coarse),
        _cast(SHOULDER_UPPER, FROM_JOINT_TO_MINUS_Y, coarse),
        _cast(UPPER, TO_MINUS_Y, coarse),
        _cast(ELBOW_FORE, FROM_JOINT_TO_PLUS_Y, coarse),
        _cast(WRIST, UP, coarse),
        _wrist(coarse),
        _tool(coarse),
    )
    return (
        tuple({name: _coarse(name, part) for name, part in parts.items()} for parts in links)
        if coarse
        else links
    )


def _coarse(name: str, part: trimesh.Trimesh) -> trimesh.Trimesh:
    if name in RAISED:
        # With few triangles a ring would dive in and out of the shell below it.
        return swollen(part, PROUD)
    return thinned_mesh(part, COARSE_SHARE) if name == "body" else part


def packed_glb(parts: Parts, palette: str, coarse: bool) -> bytes:
    """One link as a GLB file; a coarse one is one mesh with colours on its vertices.

    Raises:
        ValueError: unknown palette.
    """
    if palette not in PALETTES:
        raise ValueError(f"no palette {palette!r}; there are {', '.join(PALETTES)}")
    materials = PALETTES[palette]
    if palette not in SEEN_THROUGH:
        pack = glb.merged_glb if coarse else glb.glb
        return pack(parts, materials)
    # A ghost that coincides with its arm must vanish inside it, not flicker on its surface.
    parts = {name: swollen(part, -(COARSE_INSET if coarse else GHOST_INSET)) for name, part in parts.items()}
    # Colours on vertices would not be transparent. A ghost has one colour anyway.
    return glb.glb({"body": join(parts.values())} if coarse else parts, materials)
