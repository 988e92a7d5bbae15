"""GLB files from meshes, with a cache that ignores failures."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import json
import struct
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import platformdirs
from numpy.typing import NDArray

from scenes.files import replacing
from scenes.surfaces import join

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Material:
    """Surface of a mesh.

    Attributes:
        colour: sRGB, "#rrggbb".
        roughness: 0 mirror … 1 chalk.
        metallic: 0 paint … 1 bare metal.
        opacity: below 1, blended.
    """

    colour: str
    roughness: float
    metallic: float = 0.0
    opacity: float = 1.0

    def linear(self) -> tuple[float, float, float, float]:
        """Linear RGBA in 0 … 1 (IEC 61966-2-1), as glTF needs."""
        s = np.array([int(self.colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
        light = np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)
        return float(light[0]), float(light[1]), float(light[2]), self.opacity

    def gltf(self) -> dict[str, object]:
        return {
            "pbrMetallicRoughness": {
                "baseColorFactor": [round(c, 5) for c in self.linear()],
                "roughnessFactor": self.roughness,
                "metallicFactor": self.metallic,
            },
            "alphaMode": "BLEND" if self.opacity < 1 else "OPAQUE",
        }


GlbPalette = Mapping[str, Material]


def glb(meshes: Mapping[str, trimesh.Trimesh], palette: GlbPalette) -> bytes:
    """GLB (glTF 2.0) with a node, a mesh and a material for every name; positions and normals as float32.

    trimesh's exporter rounds colours to 1/255, visible in dark linear ones, and uses four bytes per index.
    """
    return _pack_glb(meshes, [{"name": name} | palette[name].gltf() for name in meshes])


def _pack_glb(
    meshes: Mapping[str, trimesh.Trimesh],
    materials: list[dict[str, object]],
    colours: NDArray[np.float64] | None = None,
) -> bytes:
    """GLB of meshes with a material each. `colours`: of the vertices (n, 3) of a single mesh, linear."""
    body, views, accessors = bytearray(), [], []

    def put(data: NDArray[np.generic], kind: str, target: int) -> int:
        component = {"float32": 5126, "uint16": 5123, "uint32": 5125}[data.dtype.name]
        accessor = {"bufferView": len(views), "componentType": component, "count": len(data), "type": kind}
        if kind == "VEC3":
            accessor |= {"min": data.min(0).tolist(), "max": data.max(0).tolist()}
        views.append({"buffer": 0, "byteOffset": len(body), "byteLength": data.nbytes, "target": target})
        accessors.append(accessor)
        body.extend(data.tobytes())
        body.extend(bytes(-len(body) % 4))
        return len(accessors) - 1

    shapes = []
    for material, (name, part) in enumerate(meshes.items()):
        index = (
            np.asarray(part.faces)
            .reshape(-1)
            .astype(np.uint16 if len(part.vertices) < 2**16 - 1 else np.uint32)
        )
        attributes = {
            "POSITION": put(np.asarray(part.vertices, np.float32), "VEC3", 34962),
            "NORMAL": put(np.asarray(part.vertex_normals, np.float32), "VEC3", 34962),
        }
        if colours is not None:
            attributes["COLOR_0"] = put(colours.astype(np.float32), "VEC3", 34962)
        indices = put(index, "SCALAR", 34963)
        shapes.append(
            {
                "name": name,
                "primitives": [
                    {"attributes": attributes, "indices": indices, "material": material, "mode": 4}
                ],
            }
        )
    head = {
        "asset": {"version": "2.0", "generator": "lwr-duet"},
        **({"extensionsUsed": [UNLIT]} if any("extensions" in material for material in materials) else {}),
        "scene": 0,
        "scenes": [{"nodes": list(range(len(shapes)))}],
        "nodes": [{"name": shape["name"], "mesh": i} for i, shape in enumerate(shapes)],
        "meshes": shapes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(body)}],
    }
    text = json.dumps(head, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(body), 0x004E4942)
        + bytes(body)
    )
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


UNLIT: Final = "KHR_materials_unlit"

PAINTED_LIGHT: Final = np.array([0.35, -0.45, 0.82])
"""Direction (3,), in the mesh's frame."""


SHEEN: Final = np.array([0.040, 0.044, 0.055])
"""Reflection of a bright room (3,), linear; otherwise dark parts are black."""


def merged_glb(meshes: Mapping[str, trimesh.Trimesh], palette: GlbPalette) -> bytes:
    """One mesh with materials and light painted on its vertices.

    Without a graphics card a drawn mesh costs as much as thousands of triangles, and lighting a pixel more
    than filling it.
    """
    whole = join(meshes.values())
    colours = np.vstack(
        [np.tile(palette[name].linear()[:3], (len(part.vertices), 1)) for name, part in meshes.items()]
    )
    facing = np.clip(np.asarray(whole.vertex_normals) @ PAINTED_LIGHT, -1.0, 1.0)[:, None]
    colours = np.minimum(colours * (1.20 + 0.60 * facing) + SHEEN * (0.5 + 0.5 * facing) ** 3, 1.0)
    paint = Material("#ffffff", 0.45, 0.05).gltf() | {"name": "paint", "extensions": {UNLIT: {}}}
    return _pack_glb({"all": whole}, [paint], colours)


def source_key(files: Iterable[str | Path], *more: object) -> str:
    """Hash of source files, versions of trimesh and numpy, and `more`."""
    digest = hashlib.sha256(f"{importlib.metadata.version('trimesh')} {np.__version__} {more!r}".encode())
    for file in files:
        digest.update(Path(file).read_bytes())
    return digest.hexdigest()


class NotStored(LookupError):
    """The requested bytes would have to be built."""


_STORED_ONLY: Final[ContextVar[bool]] = ContextVar("duet_stored_only", default=False)


@contextlib.contextmanager
def stored_only() -> Iterator[None]:
    """Make `cached` raise `NotStored` in this thread instead of building."""
    token = _STORED_ONLY.set(True)
    try:
        yield
    finally:
        _STORED_ONLY.reset(token)


def cached(name: str, key: str, build: Callable[[], tuple[bytes, ...]]) -> tuple[bytes, ...]:
    """Result of `build`, from the user's cache if possible: a ZIP archive with the key as its comment,
    rebuilt if damaged or stale.

    Raises:
        NotStored: see `stored_only`.
    """
    file = Path(platformdirs.user_cache_dir("lwr-duet")) / f"{name}.bin"
    with contextlib.suppress(Exception), zipfile.ZipFile(file) as archive:
        if archive.comment == key.encode():
            return tuple(archive.read(name) for name in archive.namelist())
    if _STORED_ONLY.get():
        raise NotStored(name)
    blobs = build()
    with contextlib.suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with replacing(file) as new, zipfile.ZipFile(new, "w") as archive:
            archive.comment = key.encode()
            for number, blob in enumerate(blobs):
                archive.writestr(zipfile.ZipInfo(str(number)), blob)
    return blobs
