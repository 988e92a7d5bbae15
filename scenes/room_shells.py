"""Visible stands of the arms, generated as GLB files; not obstacles.

World frame: z up, floor at z = 0, metres. Greys, so that orange arms stand out.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from scenes import furniture, glb, rigs, surfaces
from scenes.furniture import (
    BENCH_HALF_DEPTH,
    BENCH_TOP,
    CART_HALF,
    POST,
    TORSO_BLOCK,
    TORSO_STUB,
    bench_half_length,
)
from scenes.glb import Material
from scenes.rigs import RIGS, TABLE_HEIGHT, Rig
from scenes.surfaces import Array, join, moved, revolve, rounded, smooth_max, smooth_min, thinned_mesh

if TYPE_CHECKING:
    import trimesh

MATERIALS: Final[Mapping[str, Material]] = {
    "light": Material("#74787d", 0.55, 0.05),
    "dark": Material("#3a3b3d", 0.5, 0.05),
    "black": Material("#252628", 0.55, 0.05),
    "metal": Material("#a4aab1", 0.34, 0.6),
}

COARSE_SHARE: Final = 0.12

FEW: Final = 28

BOARDS: Final = ("light", "dark")
"""Fewer triangles would deform these boards and bars."""


def _bolts(radius: float, count: int, height: float, size: float) -> trimesh.Trimesh:
    head = revolve(
        rounded(
            [(size, height - 0.002), (size, height + 0.7 * size), (0, height + 0.7 * size)], 0.25 * size, 2
        ),
        12,
    )
    angles = (np.arange(count) + 0.5) * 2 * np.pi / count
    return join(moved(head, shift=(radius * np.cos(a), radius * np.sin(a), 0)) for a in angles)


def _shoulder_block(bases: list[tuple[Array, Array]], heart: Array) -> trimesh.Trimesh:

    def form(p: Array) -> Array:
        body = smooth_max(
            np.hypot(p[..., 0] - heart[0], p[..., 1]) - 0.056, heart[2] - 0.097 - p[..., 2], 0.03
        )
        body = smooth_max(body, p[..., 2] - heart[2], 0.02)
        for position, R in bases:
            local = (p - position) @ R
            stub = smooth_max(
                np.hypot(local[..., 0], local[..., 1]) - TORSO_STUB,
                np.abs(local[..., 2] + 0.055) - 0.047,
                0.012,
            )
            body = smooth_min(body, stub, 0.05)
        return body

    lift = np.linspace(-np.pi / 2, np.pi / 2, 37)
    return surfaces.skin(form, np.broadcast_to(heart, (37, 3)), lift, 60, 0.3, first=0.0)


@functools.cache
def torso_meshes(coarse: bool) -> dict[str, trimesh.Trimesh]:
    """Material → mesh in the world frame [m]. Shared: do not change them.

    Args:
        coarse: few triangles, see `scenes.lwr.shells`.
    """

    def turned(
        outline: list[tuple[float, float]], radius: float, steps: int, sections: int
    ) -> trimesh.Trimesh:
        return revolve(outline, FEW) if coarse else revolve(rounded(outline, radius, steps), sections)

    rig = RIGS["torso"]
    bases = [(base.translation, base.rotation) for base in reversed(rig.bases)]
    heart = np.array(TORSO_BLOCK)
    column_top = heart[2] - 0.095
    foot = turned([(0, 0.0), (0.235, 0.0), (0.235, 0.012), (0.215, 0.022), (0.0, 0.022)], 0.008, 4, 72)
    taper = [(0.098, 0.020), (0.094, 0.030), (0.066, 0.060), (0.056, 0.20)]
    column = turned([*taper, (0.050, 0.55), (0.050, column_top - 0.03), (0.050, column_top)], 0.05, 4, 44)
    collar = turned([(0.040, -0.010), (0.0585, -0.010), (0.0585, 0.012), (0.040, 0.012)], 0.002, 3, 44)
    flange = turned([(0.06, -0.016), (0.079, -0.016), (0.079, 0.0), (0.0, 0.0)], 0.003, 3, 56)
    groove = turned([(0.060, -0.0195), (0.0745, -0.0195), (0.0745, -0.0155), (0.060, -0.0155)], 0.001, 1, 56)
    standing = (heart[0], 0.0, 0.0)
    block = _shoulder_block(bases, heart)
    bolts = [] if coarse else [moved(_bolts(0.180, 8, 0.022, 0.009), shift=standing)]
    return {
        "light": thinned_mesh(block, COARSE_SHARE) if coarse else block,
        "dark": join(
            [moved(foot, shift=standing), moved(column, shift=standing)]
            + [moved(flange, R, tuple(position)) for position, R in bases]
        ),
        "black": join(moved(groove, R, tuple(position)) for position, R in bases),
        "metal": join([moved(collar, shift=(heart[0], 0.0, column_top)), *bolts]),
    }


@functools.cache
def table_meshes(separation: float, plates: int, coarse: bool) -> dict[str, trimesh.Trimesh]:
    """As `torso_meshes`. `separation`: of the bases [m]."""
    half_x, half_y, corner, top = bench_half_length(separation), BENCH_HALF_DEPTH, 0.045, BENCH_TOP
    board = rounded([(0, top - 0.032), (corner, top - 0.032), (corner, top), (0, top)], 0.006, 4)
    apron = [(0.012, top - 0.095), (0.012, top - 0.030)]
    apron = rounded([(0, top - 0.095), *apron], 0.004, 2)
    leg = rounded([(0.0, 0.018), (0.012, 0.018), (0.012, top - 0.035)], 0.003, 2)
    glide = rounded([(0.0, 0.0), (0.024, 0.0), (0.024, 0.008), (0.012, 0.012), (0.012, 0.020)], 0.003, 2)
    rail = rounded([(0.0, 0.16), (0.008, 0.16), (0.008, 0.20), (0.0, 0.20)], 0.004, 2)
    plate = rounded([(0.105, top - 0.001), (0.105, TABLE_HEIGHT), (0.0, TABLE_HEIGHT)], 0.004, 4)
    leg_x, leg_y = half_x - 0.075, half_y - 0.060
    corners = [(x, y, 0.0) for x in (-leg_x, leg_x) for y in (-leg_y, leg_y)]
    places = [(x, 0.0, 0.0) for x in (-separation / 2, separation / 2)][:plates]
    parts = {
        "light": revolve(board, 40, stretch=(half_x - corner, half_y - corner)),
        "dark": join(
            [revolve(apron, 16, stretch=(leg_x + 0.015, leg_y + 0.015))]
            + [moved(revolve(leg, 16, stretch=(0.016, 0.016)), shift=place) for place in corners]
            + [
                moved(revolve(rail, 16, stretch=(0.008, leg_y - 0.02)), shift=(x, 0.0, 0.0))
                for x in (-leg_x, leg_x)
            ]
            + [revolve(rail, 16, stretch=(leg_x, 0.008))]
        ),
        "black": join([moved(revolve(plate, 72), shift=place) for place in places]),
        "metal": join(
            [moved(_bolts(0.091, 6, TABLE_HEIGHT, 0.006), shift=place) for place in places]
            + [moved(revolve(glide, 24), shift=place) for place in corners]
        ),
    }
    return {
        name: thinned_mesh(part, COARSE_SHARE) if coarse and name not in BOARDS else part
        for name, part in parts.items()
    }


@functools.cache
def torso_glb(coarse: bool) -> bytes:
    return glb.cached(f"torso-{coarse:d}", _key(), lambda: (_packed(torso_meshes(coarse), coarse),))[0]


@functools.cache
def table_glb(separation: float, coarse: bool, plates: int = 2) -> bytes:
    """Bench for bases at x = ± half the separation [m], facing each other; `plates` = 1: only the left."""
    name = f"table-{separation:.3f}-{plates}-{coarse:d}"
    return glb.cached(
        name, _key(separation, plates), lambda: (_packed(table_meshes(separation, plates, coarse), coarse),)
    )[0]


@functools.cache
def stands_glb(feet: tuple[tuple[float, float, float], ...], coarse: bool) -> bytes:
    """A column from the floor to every base at (x, y, z) [m]."""
    columns = []
    for x, y, z in feet:
        if z > 0.05:
            post = [(POST, 0.02), (POST, z - 0.012), (0.10, z - 0.012), (0.10, z)]
            foot = [(0.0, 0.0), (0.16, 0.0), (0.16, 0.015), *post, (0.0, z)]
        else:
            foot = [(0.0, 0.0), (0.16, 0.0), (0.16, max(z, 0.002)), (0.0, max(z, 0.002))]
        columns.append(moved(revolve(foot, FEW if coarse else 56), shift=(x, y, 0.0)))
    return _packed({"dark": join(columns)}, coarse)


@functools.cache
def cart_glb(place: tuple[float, float], coarse: bool) -> bytes:
    """A cart with a plate for a base at `place` (x, y) [m]."""
    half_x, half_y, corner, top = *CART_HALF, 0.04, BENCH_TOP
    body = rounded([(0, 0.09), (corner, 0.09), (corner, 0.40), (0, 0.40)], 0.006, 3)
    column = rounded([(0.13, 0.395), (0.11, top), (0.0, top)], 0.01, 3)
    plate = rounded([(0.105, top - 0.001), (0.105, TABLE_HEIGHT), (0.0, TABLE_HEIGHT)], 0.004, 4)
    wheel = rounded([(0.0, -0.02), (0.06, -0.02), (0.06, 0.02), (0.0, 0.02)], 0.008, 3)
    on_edge = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    corners = [(sx * (half_x - 0.06), sy * (half_y - 0.02), 0.06) for sx in (-1, 1) for sy in (-1, 1)]
    parts = {
        "light": revolve(body, 40, stretch=(half_x - corner, half_y - corner)),
        "dark": revolve(column, FEW),
        "black": join([revolve(plate, 72), *(moved(revolve(wheel, FEW), on_edge, at) for at in corners)]),
    }
    return _packed({name: moved(part, shift=(*place, 0.0)) for name, part in parts.items()}, coarse)


def _packed(parts: dict[str, trimesh.Trimesh], coarse: bool) -> bytes:
    pack = glb.merged_glb if coarse else glb.glb
    return pack(parts, MATERIALS)


def _key(*more: object) -> str:
    return glb.source_key(
        [__file__, furniture.__file__, glb.__file__, rigs.__file__, surfaces.__file__], *more
    )


def furniture_glb(rig: Rig, coarse: bool) -> bytes:
    if rig.name == "torso":
        return torso_glb(coarse)
    if rig.name == "table":
        return table_glb(-2.0 * float(rig.bases[0].translation[0]), coarse, len(rig.bases))
    if rig.name == "cart":
        x, y, _ = rig.bases[0].translation.tolist()
        return cart_glb((x, y), coarse)
    feet = (base.translation.tolist() for base in rig.bases)
    return stands_glb(tuple((x, y, z) for x, y, z in feet), coarse)
