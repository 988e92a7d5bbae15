"""What is slow the first time is ready before anybody asks; what has to be built is built in another process."""

from functools import partial
from pathlib import Path
from typing import get_type_hints
from zipfile import ZipFile

import platformdirs
import pytest
import viser
from numpy.testing import assert_array_equal
from viser import _gui_api, _gui_handles, _icons

from app.hosting import preparation
from app.hosting.preparation import Preparation, drawn
from app.lessons.lesson import NO_LESSONS
from scenes import glb
from scenes.robots import robot
from scenes.room_shells import table_glb
from tests.app.conftest import Arrive, OpenHouse
from tests.app.inline import Inline


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda *_: str(tmp_path))
    robot.cache_clear()
    table_glb.cache_clear()
    return tmp_path


def test_a_robot_that_is_stored_is_not_fitted_again_and_is_the_same(store: Path) -> None:
    with pytest.raises(glb.NotStored), glb.stored_only():
        robot("ur5")
    first = robot("ur5")
    assert [file.name for file in store.iterdir()] == ["ur5-capsules.bin"]
    robot.cache_clear()
    with glb.stored_only():
        again = robot("ur5")
    assert again is not first and again.model == first.model
    for one, other in zip(first.capsules, again.capsules, strict=True):
        assert (one.name, one.joint, one.radius) == (other.name, other.joint, other.radius)
        assert_array_equal(one.start, other.start)
        assert_array_equal(one.end, other.end)


def test_what_is_not_stored_is_built_by_a_worker(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preparation, "drawn", lambda: [partial(preparation._furnish, "alone", True)])
    workers = Inline()
    Preparation(NO_LESSONS, workers).wait()
    (job,) = workers.waiting()
    assert not list(store.iterdir()) and table_glb.cache_info().currsize == 0
    workers.work()
    assert job.state == "done" and [file.suffix for file in store.iterdir()] == [".bin"]
    # The worker has a memory of its own.
    table_glb.cache_clear()
    Preparation(NO_LESSONS, workers).wait()
    assert len(workers.jobs) == 1 and table_glb.cache_info().currsize == 1


def test_everything_that_the_stage_asks_for_is_made_ready_under_the_very_name(house: OpenHouse, arrive: Arrive) -> None:
    for draw in drawn():
        draw()
    guest = arrive(house())
    known = preparation.robot_glbs.cache_info().misses, table_glb.cache_info().misses
    for scene, name in (("solo", "panda"), ("hold", "ur5"), ("imitation", "lwr"), ("ball", "lwr")):
        guest.ask(lambda s, scene=scene, name=name: [s.change("robot", name), s.change("scene", scene)])
        guest.run_on(0.05)
    assert (preparation.robot_glbs.cache_info().misses, table_glb.cache_info().misses) == known


def test_icons_and_types_are_those_of_viser_and_read_once(
    house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = house()
    guest = arrive(opened)
    read: list[str] = []
    with monkeypatch.context() as patch:
        patch.setattr(ZipFile, "__init__", lambda self, file, *_: read.append(str(file)))
        icons = [vars(module)["svg_from_icon"]("school") for module in (_gui_api, _gui_handles)]
    assert icons == [_icons.svg_from_icon("school")] * 2 and not read
    gui = opened.server.get_clients()[guest.number].gui
    button = gui.add_button("a button", icon=viser.Icon.SCHOOL)
    assert button._prop_hints == get_type_hints(type(button._impl.props))
    assert button._prop_hints is gui.add_button("another")._prop_hints
