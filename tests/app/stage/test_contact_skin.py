"""λ in the 3-D view: a skin of d_m on the obstacle, a tint of the avoiding arm, and a key for both."""

from typing import Any

import coal
import numpy as np
import pytest
import viser

from app.session.frame import freeze
from app.session.session import Session
from app.settings import Settings
from app.stage.arms import ArmView
from app.stage.contact_view import FADE, ContactSkin, bodies_of_pair, capsule_mesh
from app.theme import PALETTES, rgb
from app.web.server import DuetServer
from controllers.kinematics import Array
from scenes.lwr.shells import ORANGE
from scenes.simulation import Simulation
from tests.app.conftest import Guest, OpenHouse, ask
from tests.app.page.by_hand import run_on, visit
from tests.app.page.helpers import press
from tests.app.stage.conftest import change, drawn, drawn_pose, pause_when, settle, visible
from tests.browser import PageAt, until
from tests.scenes.helpers import beyond, given_settings

LOOK = """() => { const all = __viserMutable.nodeRefFromName, seen = {};
    for (const [name, node] of Object.entries(all)) node?.traverse?.((mesh) => {
        if (!mesh.isMesh || mesh.children.length) return;
        const { depthTest, customProgramCacheKey, userData, transparent } = mesh.material;
        const color = userData.duetTint ?? mesh.material.color;
        if (/_of_|closest.line$/.test(name)) seen[name] = [depthTest, customProgramCacheKey.call(mesh.material)];
        if (/^.arms.(left|right).base.j1$/.test(name) && !transparent) seen[name] = color.b - color.g;
    });
    return seen; }"""
"""Materials of the skins and the line, and the purple of each arm's first link."""

PAINT = """() => { const seen = {};
    __viserMutable.nodeRefFromName['/arms/right/base']?.traverse(({ isMesh, material }) => {
        if (!isMesh || material.transparent) return;
        const tinted = material.userData.duetTint ?? material.color;
        seen[material.name] = ['#' + material.color.getHexString(), tinted.b - tinted.g];
    });
    return seen; }"""
"""Colours of the orange arm's parts, and their purple."""


def shells(guest: Guest, kind: str) -> list[str]:
    """Visible nodes of `kind`: "skin" or "capsule"."""
    return [name for name in drawn(guest.visitor) if f"/{kind}_of_" in name and visible(guest, name)]


def tint(guest: Guest, arm: str) -> float:
    return float(guest.visitor.mirror.nodes[f"/tint/{arm}"]["position"][0])


@pytest.mark.parametrize("half", [0.0, 0.2])
def test_the_mesh_is_the_body_enlarged_by_d_m(half: float) -> None:
    shape = coal.Capsule(0.07, 2.0 * half) if half else coal.Sphere(0.07)
    vertices, faces = capsule_mesh(shape, 0.15)
    ends = np.array([0.0, 0.0, -half]), np.array([0.0, 0.0, half])
    assert np.abs(beyond(vertices.astype(float), *ends, 0.22)).max() < 1e-6
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normals, middles = np.cross(b - a, c - a), (a + b + c) / 3.0
    outward = middles - np.stack(
        [0.0 * middles[:, 0], 0.0 * middles[:, 0], np.clip(middles[:, 2], -half, half)], axis=1
    )
    # All faces point outwards, as only their front is drawn; at the poles they have no area.
    assert ((normals * outward).sum(axis=1) >= -1e-9).all() and (
        np.linalg.norm(normals, axis=1) > 1e-9
    ).mean() > 0.8


def test_the_skin_is_d_m_thick_and_attached_to_the_obstacle(one: Guest) -> None:
    change(one, rig="table", dm=0.2)
    press(one, "pause")
    one.visitor.wait_for(lambda _: len(shells(one, "skin")) == 1 and len(shells(one, "capsule")) == 2)
    settle(one)

    def near(s: Any) -> tuple[float, Array, str]:
        simulation, pair = s.simulation, s.simulation.sample().pair
        avoider, _ = bodies_of_pair(simulation, pair)
        points = simulation.detector.witness_points(pair)
        pairs = simulation.detector.geometry.collisionPairs[pair]
        first = pairs.first == avoider
        return (
            float(simulation.sample().distance),
            points[0 if first else 1].copy(),
            simulation.detector.pair_names[pair][first],
        )

    distance, point, obstacle = one.ask(near)
    (skin,) = shells(one, "skin")
    # The orange arm is the silver arm's obstacle.
    assert (
        obstacle.startswith("right")
        and skin.startswith("/arms/right")
        and skin.endswith(obstacle.replace(" ", "_"))
    )
    vertices = np.array(one.visitor.mirror.nodes[skin]["vertices"], float).reshape(-1, 3)
    radius = float(np.abs(vertices[:, :2]).max())
    half = float(vertices[:, 2].max()) - radius
    inside = drawn_pose(one, skin).actInv(point)[None]
    ends = np.array([0.0, 0.0, -half]), np.array([0.0, 0.0, half])
    assert beyond(inside, *ends, radius)[0] == pytest.approx(distance - 0.2, abs=2e-3)
    # A larger d_m enlarges the same node.
    change(one, dm=0.25)
    one.visitor.wait_for(
        lambda v: (
            np.abs(np.array(v.mirror.nodes[skin]["vertices"], float)).max() > np.abs(vertices).max() + 0.04
        )
    )


def test_d_m_is_written_once_on_the_rim(one: Guest) -> None:
    change(one, rig="table", dm=0.2)
    press(one, "pause")
    one.visitor.wait_for(lambda _: len(shells(one, "skin")) == 1)
    settle(one)
    nodes = one.visitor.mirror.nodes
    (rim,) = [name for name in drawn(one.visitor) if "/rim_around_" in name and visible(one, name)]
    (skin,) = shells(one, "skin")
    assert rim.split("/rim_around_") == skin.split("/skin_of_"), "not on the skin's link"
    middle = np.asarray(nodes[skin]["position"], float)
    assert np.linalg.norm(np.asarray(nodes[rim]["position"], float) - middle) > 0.2, (
        "within d_m of the body's axis"
    )


def test_the_avoiding_arm_is_tinted_and_a_key_switches_all_off(one: Guest) -> None:
    change(one, rig="table", speed=2.0, autopilot=True)
    pause_when(one, lambda s: s.simulation.sample().activation > 0.5)
    settle(one)
    share = one.ask(lambda s: s.simulation.sample().activation)
    assert tint(one, "left") == pytest.approx(share, abs=0.02) and tint(one, "right") == 0.0
    change(one, avoid="both")
    one.visitor.wait_for(lambda _: tint(one, "right") == tint(one, "left") > 0.0)
    press(one, "contact")
    assert not one.session.settings.page.contact
    one.visitor.wait_for(
        lambda _: tint(one, "left") == tint(one, "right") == 0.0 and not visible(one, "/closest/line")
    )
    one.visitor.wait_for(lambda _: not shells(one, "skin") and not shells(one, "capsule"))
    press(one, "contact")
    one.visitor.wait_for(
        lambda _: shells(one, "skin") and visible(one, "/closest/line") and tint(one, "left") > 0.0
    )
    change(one, scene="solo")
    one.visitor.wait_for(
        lambda _: not any("_of_" in name for name in drawn(one.visitor)) and not visible(one, "/closest/line")
    )


def test_an_overlap_is_red_and_named(one: Guest) -> None:
    change(one, law="unprotected", speed=2.0, autopilot=True)
    pause_when(one, lambda s: s.simulation.sample().distance < -0.002)
    settle(one)
    nodes, depth = one.visitor.mirror.nodes, -1000.0 * one.ask(lambda s: s.simulation.sample().distance)
    assert nodes["/closest/distance"]["text"] == f"{depth:.0f} mm of overlap"
    alarm = rgb(PALETTES["light"].approach)
    assert tuple(np.array(nodes["/closest/line"]["colors"]).reshape(-1, 3)[0]) == alarm
    capsules = shells(one, "capsule")
    assert len(capsules) == 2 and {tuple(nodes[name]["color"]) for name in capsules} == {alarm}
    # Without an overlap, words and colour show d and λ again.
    one.ask(lambda s: s.reset())
    settle(one)
    assert nodes["/closest/distance"]["text"].startswith("d = ")
    assert tuple(np.array(nodes["/closest/line"]["colors"]).reshape(-1, 3)[0]) != alarm


@pytest.mark.parametrize(
    ("changes", "obstacle"),
    [
        ({"scene": "hold"}, "right"),
        ({"scene": "hold", "avoid": "guided"}, "left"),
        # If both avoid, the guided arm is the obstacle for any treatment of pairs.
        ({"scene": "hold", "avoid": "both", "pairs": "soft"}, "right"),
        ({"scene": "hold", "guided": "left"}, "left"),
        ({"scene": "ball", "point": "hand"}, "ball"),
        ({"scene": "ball", "point": "arm"}, "ball"),
    ],
)
def test_the_obstacle_of_each_experiment(changes: dict[str, Any], obstacle: str) -> None:
    simulation = Simulation(given_settings(**changes))
    simulation.step(None)
    found = bodies_of_pair(simulation, simulation.sample().pair)[1]
    assert simulation.room.geometry.geometryObjects[found].name.split(" ")[0] == obstacle


def test_the_page_draws_rims_a_line_on_top_and_a_tint_except_on_orange(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(700, 560)
    session = visit(page, house(), "rig=table&speed=2")
    until(page, lambda: session.simulation.sample().activation > 0.5, "a near hand")
    run_on(page, session, 0.1)

    def as_it_should() -> bool:
        seen = page.evaluate(LOOK)
        if not {"/arms/left/base/j1", "/arms/right/base/j1", "/closest/line"} <= seen.keys():
            # Not loaded yet.
            return False
        skins = [name for name in seen if "/skin_of_" in name]
        rims = all(seen[name][1] == "duet-rim" for name in seen if "_of_" in name)
        purple = seen["/arms/left/base/j1"] > seen["/arms/right/base/j1"] + 0.2
        return bool(skins) and rims and seen["/closest/line"][0] is False and purple

    until(page, as_it_should, "rims, line and tint")
    page.keyboard.press("o")
    until(page, lambda: abs(page.evaluate(LOOK)["/arms/left/base/j1"]) < 0.01, "no tint")
    # An avoiding orange arm stays orange.
    page.keyboard.press("o")
    ask(session, lambda s: [s.change(key, value) for key, value in (("avoid", "both"), ("picture", "fine"))])
    until(
        page,
        lambda: (seen := page.evaluate(PAINT)).get("cover", ("", 0.0))[1] > 0.1 and "body" in seen,
        "purple covers",
    )
    assert page.evaluate(PAINT)["body"][0] == ORANGE
    # The fast picture has vertex colours; only its grey parts take the tint.
    ask(session, lambda s: s.change("picture", "fast"))
    until(page, lambda: page.evaluate(PAINT).get("paint", ("", 0.0))[1] > 0.1, "a tint of the fast picture")
    assert page.evaluate(PAINT)["paint"][0] == "#ffffff"


def test_a_new_nearest_link_fades_in_while_the_old_one_fades_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: dict[str, viser.MeshHandle] = {}
    server = DuetServer("127.0.0.1", 0, max_clients=1)
    try:
        scene, session = server.scene, Session(Settings())
        add = scene.add_mesh_simple

        def note(name: str, *parts: Any, **options: Any) -> viser.MeshHandle:
            made[name] = add(name, *parts, **options)
            return made[name]

        monkeypatch.setattr(scene, "add_mesh_simple", note)
        session.simulation.step(None)
        room = session.simulation.room
        arms = tuple(
            ArmView(scene, f"/{arm.name}", base, "silver", False)
            for arm, base in zip(room.arms, room.rig.bases, strict=True)
        )
        skin = ContactSkin(scene, room, arms)
        skin.dress(session.settings.page)
        skin.show(freeze(session, 0.0))

        def opacities() -> list[float]:
            return [
                float(handle.opacity or 0.0)
                for name, handle in made.items()
                if "/skin_of_" in name and handle.visible
            ]

        (full,) = opacities()
        # Now the guided arm avoids, so that the skin moves to the other arm.
        session.change("avoid", "guided")
        skin.show(freeze(session, 0.25 * FADE))
        assert opacities() == pytest.approx([0.75 * full, 0.25 * full], abs=1e-3)
        skin.show(freeze(session, 1.5 * FADE))
        assert opacities() == [full]
        count = len(made)
        for key, value in (("avoid", "free"), ("avoid", "guided")):
            session.change(key, value)
            skin.show(freeze(session, 9.0))
        assert len(made) == count, "a mesh was made twice"
    finally:
        server.stop()
