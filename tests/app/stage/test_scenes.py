"""Every experiment shows exactly its own objects, in every look, all in the first view."""

from contextlib import suppress
from typing import Any, get_args

import numpy as np
import pytest

from app.page.picture_size import free_picture
from app.stage.camera_view import view_of
from app.stage.person_figure import on_stage
from scenes.ball import PATH
from scenes.settings import RobotName, RunSettings, specs
from scenes.simulation import Simulation
from tests.app.conftest import ELBOW, HAND, Guest, OpenHouse
from tests.app.page.test_camera_follow import Watched
from tests.app.stage.conftest import BALL_ARROWS, SCENES, change, drawn, settle, visible
from tests.blocking_client import BlockingClient

EXPECTED: dict[str, set[str]] = {
    "solo": {HAND, ELBOW, "/trace", "/place/ring"},
    "ball": {BALL_ARROWS, "/trace", "/place/ring", "/ball", "/path/line", "/path/A", "/path/B"},
    "hold": {HAND, ELBOW, "/trace", "/place/ring"},
    "master_slave": {HAND, ELBOW, "/trace"},
    "first_task": {HAND, ELBOW, "/trace", "/place/ring", "/wall"},
    "imitation": {
        "/person/body",
        "/person/body/left_upper_arm",
        "/person/body/right_upper_arm/right_forearm",
    },
}
TELLING = set().union(*EXPECTED.values())


def unlike(one: BlockingClient, other: BlockingClient) -> list[str]:
    """Differences of two pages: missing or displaced nodes. A browser may confuse nodes of the same name."""
    mine, theirs = drawn(one), drawn(other)
    found = [name for name in mine ^ theirs if not name.startswith("/wish")]
    for name in mine & theirs:
        if name.startswith(("/arms", "/gizmo", "/place", "/ball", "/person")) and name != "/person/lost":
            a, b = (v.mirror.nodes.get(name, {}) for v in (one, other))
            stands = (
                np.allclose(a.get(key, np.nan), b.get(key, np.nan), atol=0.02) for key in ("position", "wxyz")
            )
            found += [] if all(stands) else [f"{name} stands elsewhere"]
    return found


def test_every_scene_shows_its_own_objects_and_none_of_the_previous(house: OpenHouse, one: Guest) -> None:
    opened = house()
    way: list[tuple[str, RobotName, str]] = [
        *((scene, "lwr", "torso") for scene in SCENES),
        *((scene, "panda", "table") for scene in ("ball", "hold", "imitation")),
        *(("solo", "ur5", "torso"), ("master_slave", "ur5", "torso"), ("hold", "lwr", "torso")),
    ]
    for scene, robot, rig in way:
        change(one, scene=scene, robot=robot, rig=rig)
        with BlockingClient(
            opened.url, query=f"autopilot=0&gizmo=1&scene={scene}&robot={robot}&rig={rig}"
        ) as fresh:
            fresh.wait_for(
                lambda v: v.mirror.replayed and len(v.mirror.commands) >= 14 and "/room" in v.mirror.nodes
            )
            # New handles get their places in the first frames.
            with suppress(TimeoutError):
                fresh.wait_for(
                    lambda v, fresh=fresh: v.received.frames >= 4 and not unlike(one.visitor, fresh)
                )
            assert unlike(one.visitor, fresh) == [], (scene, robot)
            shown = {name for name in drawn(fresh) if not name.startswith("/wish")}
        assert (shown & TELLING) >= EXPECTED[scene], scene
        # A trace is visible once the hand has moved; all other named objects from the first frame on.
        one.visitor.wait_for(
            lambda _, scene=scene: all(visible(one, name) for name in EXPECTED[scene] - {"/trace"})
        )
        assert {
            name for name in shown & TELLING if name.startswith(("/gizmo", "/ball", "/path", "/person"))
        } <= EXPECTED[scene]
        alone = scene in ("solo", "ball", "first_task")
        assert {name.split("/")[2] for name in shown if name.startswith("/arms/")} == (
            {"arm"} if alone else {"left", "right"}
        )
        joints = 6 if robot == "ur5" else 7
        links = [name for name in shown if name.startswith("/arms/") and name.endswith("/shape")]
        assert len(links) == (1 if alone else 2) * (1 + joints)
        one.run_on(0.05)


def test_the_panel_and_the_camera_follow_the_scene(one: Guest, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    take = one.visitor.mirror.take

    def listen(message: dict[str, Any]) -> None:
        if message["type"] == "SetGuiPanelLabelMessage":
            said.append(message["label"])
        take(message)

    monkeypatch.setattr(one.visitor.mirror, "take", listen)
    spec = specs(RunSettings)["scene"]
    # In this order every scene has another view than the previous one.
    for scene in ("solo", "master_slave", "ball", "imitation", "hold"):
        before = one.visitor.received.messages["SetCameraPositionMessage"]
        change(one, scene=scene)
        one.visitor.wait_for(
            lambda v, before=before: v.received.messages["SetCameraPositionMessage"] > before
        )
        one.visitor.wait_for(lambda _, scene=scene: said[-1:] == [spec.options()[scene]])
    # A setting that moves no arm does not change the visitor's view.
    before = one.visitor.received.messages["SetCameraPositionMessage"]
    change(one, dm=0.1, theme="dark", ghost="frozen")
    assert one.visitor.received.messages["SetCameraPositionMessage"] == before


@pytest.mark.thorough
def test_another_look_reaches_every_part(one: Guest) -> None:
    one.ask(lambda s: s.change("profile", "projector"))
    for scene in SCENES:
        one.ask(lambda s, scene=scene: s.change("scene", scene))
        settle(one)
        looks = {
            name: node for name, node in list(one.visitor.mirror.nodes.items()) if name in drawn(one.visitor)
        }
        for name, node in looks.items():
            if node["type"] == "LabelMessage":
                assert node["font_screen_scale"] == pytest.approx(1.15 * 1.3), name
        before = {name: node["glb_data"] for name, node in looks.items() if node["type"] == "GlbMessage"}
        settle(one)
        # The theme changes twice, but data that do not depend on it are not sent again.
        nodes = list(one.visitor.mirror.nodes.items())
        after = {name: node["glb_data"] for name, node in nodes if node.get("type") == "GlbMessage"}
        assert all(after[name] is data for name, data in before.items())


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("robot", get_args(RobotName))
def test_the_first_view_shows_all_objects(scene: str, robot: RobotName) -> None:
    for rig in ("torso", "table"):
        simulation = Simulation(RunSettings(scene=scene, robot=robot, rig=rig))
        simulation.kinematics.update(simulation.positions)
        kinematics, points = simulation.kinematics, []
        for arm in simulation.room.arms:
            points += [kinematics.joint_point(j) for j in (arm.shoulder, arm.elbow, arm.wrist)]
            points.append(kinematics.hand_pose(arm).translation)
        if scene == "ball":
            points += [points[-1], points[-1] + PATH, simulation.positions[simulation.room.ball]]
        if scene == "imitation":
            points += [
                on_stage(np.array([0.0, side * 0.5, height])) for side in (-1, 1) for height in (0.4, -0.6)
            ]
        for width, height in ((1096.0, 853.0), (680.0, 721.0), (390.0, 797.0)):
            picture = free_picture((width, height), width, "desk")
            watched = Watched(picture, lambda s=simulation: view_of(s), lambda: np.zeros((0, 3)))
            watched.follow.first_view(simulation, 0.0)
            for point, (x, y) in zip(points, watched.seen(np.array(points)), strict=True):
                assert picture.open.contains(x, y), (rig, width, point)
