"""The page that plays without a server: scene and numbers of the run, nothing loaded from elsewhere."""

import base64
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from playwright.sync_api import Page

from app.cli.options import RunOptions, settings_of_options
from app.features.exports.player import LOCKED, packed_film, player_html
from app.features.exports.scene_film import PLACE, RATE, SEEN, TURN, Filmed, Track, film_scene
from app.session.replay import Replay, make_film
from app.settings import PageSettings
from controllers.kinematics import Array
from scenes.inputs import Recorded
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.app.features.robot_files.arm_urdf import arm_urdf
from tests.app.recording.runs import piece, read_film, read_scene
from tests.browser import PageAt, screenshot, until, world_position
from tests.scenes.helpers import recorded_run

FAST = PageSettings(picture="fast")
WRIST = "/base/j1/j2/j3/j4/j5/j6/j7"


@cache
def filmed(scene: str) -> Filmed:
    return film_scene(piece(scene, 2.0)[0], 1.0, FAST)


def wrists(recorded: Recorded, time: float) -> dict[str, Array]:
    """Positions of each arm's last link at a time [m]."""
    replay = Replay(make_film(recorded))
    replay.seek(time)
    simulation: Simulation = replay.simulation
    data = simulation.room.model.createData()
    pin.forwardKinematics(simulation.room.model, data, simulation.positions)
    arms = zip(simulation.room.arms, simulation.room.robots, strict=True)
    return {arm.name: data.oMi[arm.shoulder - robot.shoulder + 7].translation.copy() for arm, robot in arms}


def test_the_still_scene_is_in_viser_s_format() -> None:
    content = read_scene(filmed("hold").scene)
    assert content["durationSeconds"] == 0.0
    names = {message.get("name") for _, message in content["messages"]}
    assert {"/room", "/floor", f"/arms/left{WRIST}", "/closest/line", "/place/ball"} <= names
    assert (
        {"/room", f"/arms/left{WRIST}/shape", f"/arms/right{WRIST}/shape"}
        <= set(filmed("hold").bodies)
        <= names
    )
    assert any("/skin_of_right" in name for name in names if name)
    assert {time for time, _ in content["messages"]} == {0.0} and not any(
        "Gui" in m["type"] for _, m in content["messages"]
    )


def test_frames_are_50_ms_apart_on_the_clock_of_the_run() -> None:
    film = filmed("hold")
    assert len(film.times) == 21 and film.times[-1] == 2.0
    np.testing.assert_allclose(np.diff(film.times), 1.0 / RATE)
    for track in film.tracks:
        assert track.frames[0] == 0 and len(track.frames) > 1 and (np.diff(track.frames) > 0).all()
        assert track.frames[-1] < len(film.times) == 21 and len(track.values) == len(track.frames)


def test_every_rotation_equals_its_joint_angle() -> None:
    film = filmed("hold")
    recorded, _ = piece("hold", 2.0)
    replay = Replay(make_film(recorded))
    turned = 0
    for joint in range(7):
        node = "/arms/right/base" + "".join(f"/j{i + 1}" for i in range(joint + 1))
        for track in (t for t in film.tracks if (t.node, t.what) == (node, TURN)):
            turns, angles = [], []
            for frame, turn in zip(track.frames, track.values, strict=True):
                replay.seek(film.times[frame])
                angles.append(
                    float(replay.simulation.positions[replay.simulation.room.arms[1].joints][joint])
                )
                turns.append(pin.Quaternion(*turn))
            turned += np.ptp(angles) > 0.02
            for turn, angle in zip(turns[1:], angles[1:], strict=True):
                assert turn.angularDistance(turns[0]) == pytest.approx(abs(angle - angles[0]), abs=1e-6)
    assert turned >= 2


def test_nodes_added_later_are_hidden_before() -> None:
    # The wanted arms are drawn only where the arms differ from them.
    film = film_scene(piece("imitation", 14.0)[0], 1.0, FAST)
    late = {
        m["name"]
        for _, m in read_scene(film.scene)["messages"]
        if m["type"] == "GlbMessage" and m["name"].startswith("/wish/")
    }
    assert f"/wish/left{WRIST}/shape" in late
    tracks = {(t.node, t.what): t for t in film.tracks}
    seen = tracks["/wish/left/base", SEEN]
    assert (seen.frames[0], seen.values[0]) == (0, False) and True in seen.values and seen.frames[1] > 0
    turn = tracks["/wish/left/base/j1/j2/j3", TURN]
    assert turn.frames[1] > seen.frames[1]


def test_a_track_keeps_changed_values_only_and_copies_them() -> None:
    track = Track("/a", "text")
    for frame, value in enumerate(("a", "a", "b", "b", "a")):
        track.put(frame, value)
    assert (track.frames, track.values) == ([0, 2, 4], ["a", "b", "a"])
    track, place = Track("/a", PLACE), np.zeros(3)
    for frame in range(4):
        place[0] = frame // 2
        track.put(frame, place)
    assert track.frames == [0, 2] and np.array(track.values).tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]


def test_a_rebuilt_3d_view_continues_moving() -> None:
    recorded, _ = piece("hold", 3.0)
    (stretch,) = recorded.stretches
    again = stretch._replace(settings=replace(stretch.settings, path="circle"))
    assert "path" not in stretch.settings.experiment.reads, "the 3-D view is rebuilt, the run continues"
    film = film_scene(Recorded(recorded.snapshot, (stretch, again)), 9.0, FAST)
    whole = film_scene(recorded, 9.0, FAST)
    assert len(film.times) == 2 * len(whole.times) and set(film.bodies) == set(whole.bodies)
    tracks = {(track.node, track.what): track for track in film.tracks}
    for track in (track for track in whole.tracks if track.what == TURN):
        turned, count = tracks[track.node, TURN], len(track.frames)
        assert turned.frames[:count] == track.frames and turned.frames[-1] > track.frames[-1]
        np.testing.assert_array_equal(turned.values[:count], track.values)
    # The skin is missing for one frame; if that is the last one, also in the still scene.
    skin = "/arms/right/base/j1/j2/skin_of_right_outer_upper_arm"
    seen = tracks[skin, SEEN]
    assert seen.values == [True, False, True] and seen.frames[2] == seen.frames[1] + 1
    (begun,) = piece("hold", 0.05)[0].stretches
    short = film_scene(
        Recorded(recorded.snapshot, (stretch, begun._replace(settings=again.settings))), 9.0, FAST
    )
    names = {message["name"] for _, message in read_scene(short.scene)["messages"] if "props" in message}
    assert skin not in names and {track.node for track in short.tracks} <= names


def test_packed_numbers_equal_the_tracks() -> None:
    tracks = (
        Track("/a", TURN, [0, 3], [np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.6, 0.0, 0.8, 0.0])]),
        Track("/a", PLACE, [0, 1], [np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 3.0])]),
        Track("/a", "points", [0, 2], [np.arange(6, dtype=np.float32), np.ones(6, np.float32)]),
        Track("/a", "colors", [0, 2], [np.arange(3, dtype=np.uint8), np.ones(3, np.uint8)]),
        Track("/a", "text", [0, 2], ["d = 1 mm", "d = 2 mm"]),
        Track("/a", "odd", [0, 2], [np.arange(3, dtype=np.float32), np.ones(6, np.float32)]),
    )
    about, numbers = read_film(packed_film(Filmed(b"", tracks, (0.0, 0.05, 0.1, 0.15)), ()))
    assert about["frames"] == 4 and [t["frames"] for t in about["tracks"]] == [
        [0, 3],
        [0, 1],
        [0, 2],
        [0, 2],
        [0, 2],
        [0, 2],
    ]
    kinds = {"i2": np.int16, "f4": np.float32, "u1": np.uint8}
    for packed_track, track in zip(about["tracks"][:4], tracks, strict=False):
        where = packed_track["numbers"]
        assert where["at"] % 8 == 0
        found = np.frombuffer(numbers, kinds[where["kind"]], where["count"], where["at"]).reshape(
            2, packed_track["width"]
        )
        wanted = np.array(track.values) * (32767.0 if track.what == TURN else 1.0)
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=0.5 if track.what == TURN else 0.0)
    assert (
        about["tracks"][4]["values"] == ["d = 1 mm", "d = 2 mm"]
        and about["tracks"][5]["values"][1] == [1.0] * 6
    )


def test_the_page_loads_nothing_and_is_small() -> None:
    recorded, _ = piece("hold", 2.0)
    page = player_html(recorded, 1.0, PageSettings(details="speeds")).decode()
    assert page == player_html(recorded, 1.0, PageSettings(details="speeds")).decode()
    assert len(page) < 2_500_000 and LOCKED in page and "<title>Duet: Hold (Fig. 5)</title>" in page
    assert page.index("Content-Security-Policy") < page.index("<script")
    assert 'src="http' not in page and "@import" not in page
    film = page.split('id="duet-film">')[1].split("<")[0]
    about, _ = read_film(base64.b64decode(film))
    assert [panel["title"] for panel in about["panels"]] == [
        "distance d",
        "error e²",
        "speeds along the line",
    ]
    assert about["panels"][0]["strokes"][1]["name"] == [["d", False], ["m", True]]


def open_file(page: Page, path: Path) -> list[str]:
    """Open a file without a network. Returns the addresses that the page requested nevertheless."""
    asked: list[str] = []
    page.context.set_offline(True)
    page.on("request", lambda request: asked.append(request.url))
    # Notifications disappear after some seconds.
    page.add_init_script(
        "addEventListener('duet-built', () => setTimeout(() => { window.noted = document.getElementById('duet-note')?.innerText; }))"
    )
    page.goto(path.as_uri())
    page.wait_for_function("window.duet?.ready")
    return asked


def test_scene_and_plots_play_from_a_file_without_a_network(page_at: PageAt, tmp_path: Path) -> None:
    recorded, table = piece("hold", 6.0)
    path = tmp_path / "run.html"
    path.write_bytes(player_html(recorded, 5.0, PageSettings(picture="fast", details="speeds")))
    page = page_at(1000, 640, fresh=True)
    asked = open_file(page, path)
    # This browser has no graphics card: the page says so for some seconds, viser shows no message.
    page.wait_for_function("window.noted?.includes('without a graphics card')")
    assert page.locator("[class*=Notification-root]").count() == 0
    # Any moment, forwards and backwards.
    for time in (5.0, 2.0, 5.6):
        see_moment(page, recorded, table, time)
    seek_by_slider_and_plot(page)
    play_pause_and_step(page)
    assert all(url.startswith(("file:", "blob:", "data:")) for url in asked)
    assert not page.get_by_role("button", name="scene tree").is_visible()
    page.locator("#duet-note").wait_for(state="detached")
    screenshot(page, "player")


def see_moment(page: Page, recorded: Recorded, table: Array, time: float) -> None:
    """Arms and numbers show the moment of the run."""
    page.evaluate("time => duet.seek(time)", time)
    assert page.evaluate("duet.time") == pytest.approx(time, abs=0.02)
    for name, wrist in wrists(recorded, time).items():
        node, place = f"/arms/{name}{WRIST}", wrist
        there = partial(is_at, page, node, place)
        until(page, there, node)
    shown = float(page.locator("#duet-plots figcaption output").first.inner_text())
    row = int(np.searchsorted(table[:, 0], time))
    assert shown == pytest.approx(float(table[row, 1]), abs=2e-3)


def is_at(page: Page, node: str, place: Array) -> bool:
    return bool(np.allclose(world_position(page, node), place, rtol=0.0, atol=2e-4))


def seek_by_slider_and_plot(page: Page) -> None:
    page.get_by_role("slider", name="Time").fill("30")
    assert page.evaluate("duet.time") == pytest.approx(1.0 + 30 / RATE, abs=0.051)
    box = page.locator("#duet-plots figure div").first.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    assert 3.0 < page.evaluate("duet.time") < 4.6


def play_pause_and_step(page: Page) -> None:
    """By buttons and keys, up to the end of the film."""
    # Early and slow enough that a busy machine presses twice before the end.
    page.evaluate("duet.seek(1.2)")
    page.get_by_label("Speed", exact=True).select_option("0.25")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("duet.time > 1.4")
    page.get_by_role("button", name="Pause").click()
    stopped = page.evaluate("duet.time")
    page.locator("#duet-clock").click()
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(".")
    assert page.evaluate("duet.time") > stopped
    page.keyboard.press("Space")
    page.wait_for_function("duet.playing")
    page.get_by_label("Speed", exact=True).select_option("4")
    page.wait_for_function("!duet.playing")
    assert page.evaluate("duet.time") == pytest.approx(6.0, abs=1e-6)


def test_an_arm_from_a_file_is_in_the_film(tmp_path: Path, registry: None) -> None:
    urdf = tmp_path / "box.urdf"
    urdf.write_text(arm_urdf(), encoding="utf-8")
    options = RunOptions(robot_left=str(urdf), robot_right="panda", rig="table")  # type: ignore[call-arg]
    _, recorded = recorded_run(settings_of_options(options, RunSettings()), 1.0, 99.0, {})
    film = film_scene(recorded, 0.5, PageSettings(picture="fast"))
    assert any("/arms/left/base/arm_joint_1" in track.node for track in film.tracks)
