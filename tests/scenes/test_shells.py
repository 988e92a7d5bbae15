"""Normals, size and cache of the visual shells; `robots/test_looks.py` compares them with the capsules."""

import io
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

from scenes import glb, rigs, room_shells
from scenes.lwr import facts, shells
from scenes.robots.drawing import robot_glbs
from scenes.surfaces import mesh, revolve, rounded, skin, smooth_max, smooth_min
from tests.scenes.helpers import glb_head, own_cache


@pytest.fixture(autouse=True)
def cache_folder(tmp_path: Path) -> Iterator[Path]:
    with own_cache(tmp_path / "cache", robot_glbs, room_shells.torso_glb, room_shells.table_glb) as folder:
        yield folder


def test_the_tool_ends_inside_the_hand() -> None:
    tip = max(part.vertices[:, 2].max() for part in shells.link_meshes(False)[7].values())
    assert 0.12 < tip + facts.JOINTS[6].origin < 0.17


def test_normals_are_correct_also_in_the_viewer() -> None:
    groups = [
        *shells.link_meshes(False),
        room_shells.torso_meshes(False),
        room_shells.table_meshes(1.1, 2, False),
    ]
    for name, part in (
        (f"{i} {name}", part) for i, group in enumerate(groups) for name, part in group.items()
    ):
        normals = part.vertex_normals
        assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6, err_msg=name)
        a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
        cross = np.cross(b - a, c - a)
        size = np.linalg.norm(cross, axis=1)
        agree = np.einsum("ij,ij->i", cross, normals[part.faces].mean(1)) / np.maximum(size, 1e-15)
        assert (agree[size > 1e-8] > 0).all(), name
        # viser 1.1.1 ignores a GLB's normals and uses the area-weighted mean of the faces around a vertex.
        seen = np.zeros_like(part.vertices)
        for corner in range(3):
            np.add.at(seen, part.faces[:, corner], cross)
        seen /= np.linalg.norm(seen, axis=1, keepdims=True)
        off = np.degrees(np.arccos(np.clip(np.sum(seen * normals, 1), -1, 1)))
        assert np.mean(off) < 8 and np.percentile(off, 99) < 20, (name, np.mean(off), np.percentile(off, 99))
        places = np.round(np.hstack([part.vertices * 1e6, normals * 1e2]))
        # Lids of slabs touch flat faces with hidden copies of their corners; links have no copies.
        assert len(np.unique(places, axis=0)) > 0.95 * len(places), name


def test_furniture_fits_the_arms() -> None:
    # A disc around each base point, facing along the arm's z axis: Ry(35°) Rx(±60°) e_z.
    vertices = room_shells.torso_meshes(False)["dark"].vertices
    for side in (-1, 1):
        base = np.array([0, side * 0.0765, 0.92])
        axis = np.array([0.5 * np.sin(np.radians(35)), side * np.sqrt(3) / 2, 0.5 * np.cos(np.radians(35))])
        near = vertices[np.linalg.norm(vertices - base, axis=1) < 0.082] - base
        assert len(near) > 100 and (near @ axis).max() == pytest.approx(0, abs=1e-9)
    vertices = room_shells.table_meshes(1.3, 2, False)["black"].vertices
    assert vertices[:, 2].max() == pytest.approx(rigs.TABLE_HEIGHT)
    for x in (-0.65, 0.65):
        assert (np.hypot(vertices[:, 0] - x, vertices[:, 1]) < 0.11).sum() == len(vertices) / 2
    for parts in (room_shells.torso_meshes(False), room_shells.table_meshes(1.1, 2, False)):
        assert min(part.vertices[:, 2].min() for part in parts.values()) == pytest.approx(0, abs=1e-9)


def test_surfaces_by_closed_forms() -> None:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 40)
    ball = revolve(np.stack([np.cos(angle), np.sin(angle)], 1), 40)
    assert_allclose(np.linalg.norm(ball.vertices, axis=1), 1, atol=1e-9)
    assert_allclose(np.sum(ball.vertex_normals * ball.vertices, 1), 1, atol=2e-3)
    assert ball.volume == pytest.approx(4 / 3 * np.pi, rel=0.02)
    slab = revolve([(0, 0), (0.1, 0), (0.1, 0.05), (0, 0.05)], 64, stretch=(0.4, 0.2))
    area = 1.0 * 0.6 - (4 - np.pi) * 0.1**2
    assert slab.volume == pytest.approx(area * 0.05, rel=1e-3)
    lift = np.linspace(-np.pi / 2, np.pi / 2, 31)
    ball = skin(lambda p: np.linalg.norm(p, axis=-1) - 0.3, np.tile([0.05, 0.0, 0.0], (31, 1)), lift, 40, 1.0)
    assert_allclose(np.linalg.norm(ball.vertices, axis=1), 0.3, atol=1e-6)
    assert_allclose(ball.vertex_normals, ball.vertices / 0.3, atol=1e-4)
    assert ball.volume == pytest.approx(4 / 3 * np.pi * 0.3**3, rel=0.03)
    # Smooth edges only remove material, smooth corners only add it.
    a, b = np.random.default_rng(3).normal(size=(2, 500))
    assert (smooth_max(a, b, 0.3) >= np.maximum(a, b)).all()
    assert (smooth_min(a, b, 0.3) <= np.minimum(a, b)).all()
    assert_allclose(smooth_max(a, b, 0.3)[np.abs(a - b) > 0.3], np.maximum(a, b)[np.abs(a - b) > 0.3])
    line = rounded([(0, 0), (1, 0), (1, 1)], 0.2, 8)
    arc = line[1:-1]
    assert_allclose(np.linalg.norm(arc - [0.8, 0.2], axis=1), 0.2, atol=1e-12)


def test_sizes_and_colours_of_files() -> None:
    assert (
        max(
            map(
                len,
                (
                    room_shells.torso_glb(False),
                    room_shells.table_glb(1.1, False),
                    room_shells.table_glb(1.4, False),
                ),
            )
        )
        <= 300_000
    )
    n = 70_000
    points = np.random.default_rng(1).normal(size=(n, 3))
    faces = np.array([[0, 1, n - 1]])
    big = mesh(points, faces, points / np.linalg.norm(points, axis=1, keepdims=True))
    loaded = trimesh.load_scene(
        io.BytesIO(glb.glb({"body": big}, shells.PALETTES["orange"])), file_type="glb"
    ).geometry["body"]
    assert_allclose(np.asarray(loaded.vertices)[loaded.faces[0]], points[faces[0]], atol=1e-5)
    assert_allclose(glb.Material("#ff8000", 0.5).linear(), (1, 0.21586, 0, 1), atol=1e-5)
    assert_allclose(glb.Material("#0a0a0a", 0.5).linear()[:3], 10 / 255 / 12.92)
    materials = {m["name"]: m for m in glb_head(robot_glbs("lwr", "orange")[1])["materials"]}
    factor = np.array(materials["body"]["pbrMetallicRoughness"]["baseColorFactor"])
    shown = np.where(factor[:3] <= 0.0031308, 12.92 * factor[:3], 1.055 * factor[:3] ** (1 / 2.4) - 0.055)
    assert_allclose(shown * 255, [int(shells.ORANGE[i : i + 2], 16) for i in (1, 3, 5)], atol=0.1)
    for ghost, solid in zip(robot_glbs("lwr", "ghost"), robot_glbs("lwr", "orange"), strict=True):
        assert glb_head(ghost)["accessors"][0]["max"][0] < glb_head(solid)["accessors"][0]["max"][0]
    names = {name for parts in shells.link_meshes(False) for name in parts}
    assert {"orange", "silver", "ghost"} <= set(shells.PALETTES)
    assert all(names <= set(palette) for palette in shells.PALETTES.values())


@pytest.mark.parametrize("link", range(8))
def test_glbs_can_be_loaded(link: int) -> None:
    scene = trimesh.load_scene(io.BytesIO(robot_glbs("lwr", "orange")[link]), file_type="glb")
    parts = shells.link_meshes(False)[link]
    assert set(scene.geometry) == set(parts)
    for name, loaded in scene.geometry.items():
        assert isinstance(loaded, trimesh.Trimesh)
        assert isinstance(loaded.visual, TextureVisuals)
        assert_allclose(loaded.vertices, parts[name].vertices, atol=1e-6)
        assert_allclose(loaded.vertex_normals, parts[name].vertex_normals, atol=1e-5)
        assert_allclose(loaded.faces, parts[name].faces)
        material = loaded.visual.material
        assert isinstance(material, PBRMaterial)
        assert material.roughnessFactor == pytest.approx(shells.PALETTES["orange"][name].roughness)


@pytest.mark.parametrize("link", range(8))
def test_coarse_links_are_one_mesh_with_painted_light(link: int) -> None:
    (loaded,) = trimesh.load_scene(
        io.BytesIO(robot_glbs("lwr", "orange", coarse=True)[link]), file_type="glb"
    ).geometry.values()
    parts = shells.link_meshes(True)[link]
    assert isinstance(loaded, trimesh.Trimesh)
    assert len(loaded.faces) == sum(len(part.faces) for part in parts.values())
    assert len(loaded.faces) < 0.3 * sum(len(part.faces) for part in shells.link_meshes(False)[link].values())
    head = glb_head(robot_glbs("lwr", "orange", coarse=True)[link])
    (primitive,) = head["meshes"][0]["primitives"]
    assert head["materials"][primitive["material"]]["extensions"] == {glb.UNLIT: {}} and head[
        "extensionsUsed"
    ] == [glb.UNLIT]
    accessor = head["accessors"][primitive["attributes"]["COLOR_0"]]
    paints = np.array([shells.PALETTES["orange"][name].linear()[:3] for name in parts])
    low, high = np.array(accessor["min"]), np.array(accessor["max"])
    assert (low >= 0.5 * paints.min(0)).all() and (low < paints.min(0) + glb.SHEEN).all()
    assert (high <= np.minimum(2.0 * paints.max(0) + glb.SHEEN, 1.0) + 1e-6).all() and (
        high > 0.9 * paints.max(0)
    ).all()


THING = (b"one", b"", b"three\n")


def test_a_cached_thing_is_built_once_and_a_damaged_file_again(
    cache_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built: list[str] = []

    def thing(key: str = "key") -> tuple[bytes, ...]:
        return glb.cached("thing", key, lambda: built.append(key) or THING)

    def refuse(*_: object) -> None:
        raise PermissionError

    assert thing() == thing() == THING and built == ["key"]
    (file,) = cache_folder.iterdir()
    data = file.read_bytes()
    for damaged in (
        b"",
        data[:-1],
        data[: len(data) // 2],
        data[:-2] + b"XY",
        b"[]\n",
        data.replace(b"three", b"THREE"),
    ):
        assert damaged != data
        file.write_bytes(damaged)
        built.clear()
        assert thing() == THING and built == ["key"] and file.read_bytes() == data
    assert thing("other key") == THING and built == ["key", "other key"]
    # An unusable or unwritable folder does no harm.
    shutil.rmtree(cache_folder)
    cache_folder.write_text("a file where the folder should be", encoding="utf-8")
    assert thing() == thing() == THING and len(built) == 4
    cache_folder.unlink()
    monkeypatch.setattr("os.replace", refuse)
    assert thing() == THING and list(cache_folder.iterdir()) == []


def test_shells_come_from_the_cache_until_a_source_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    built = []
    monkeypatch.setattr(glb, "glb", lambda *args, real=glb.glb: built.append(1) or real(*args))
    first = robot_glbs("lwr", "orange")
    assert len(built) == 8
    robot_glbs.cache_clear()
    assert robot_glbs("lwr", "orange") == first
    assert len(built) == 8
    monkeypatch.setattr(glb, "source_key", lambda *_: "the sources have changed")
    robot_glbs.cache_clear()
    assert robot_glbs("lwr", "orange") == first
    assert len(built) == 16


def test_the_key_follows_sources_and_settings(tmp_path: Path) -> None:
    source = tmp_path / "source.py"
    source.write_text("a = 1")
    before = glb.source_key([source], 1.1)
    assert glb.source_key([source], 1.1) == before and glb.source_key([source], 1.2) != before
    source.write_text("a = 2")
    assert glb.source_key([source], 1.1) != before
