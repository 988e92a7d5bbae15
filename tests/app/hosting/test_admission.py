"""New pages are built one at a time and in pieces; slow first-time work is done in advance."""

import itertools
from functools import partial
from pathlib import Path
from typing import get_type_hints
from zipfile import ZipFile

import platformdirs
import pytest
import viser
from numpy.testing import assert_array_equal
from viser import _gui_api, _gui_handles, _icons

from app.hosting import admission, preparation
from app.hosting.preparation import Preparation, mesh_makers
from app.hosting.visitor import Visitor
from app.settings import Settings
from scenes import glb
from scenes.robots import robot
from scenes.room_shells import table_glb
from scenes.settings import specs
from tests.app.conftest import FRAME, Arrive, Made, OpenHouse, live_sessions, private_of, visitor_of
from tests.app.inline import Inline
from tests.app.viser_private import type_hints


@pytest.fixture
def pieces(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """Log of ("piece" or "frame", client id); every piece uses up its time slice."""
    monkeypatch.setattr(admission, "SLICE", 0.0)
    done: list[tuple[str, int]] = []
    build, frame = Visitor.build, Visitor.frame

    def building(visitor: Visitor) -> admission.Pieces:
        for _ in build(visitor):
            done.append(("piece", visitor.client.client_id))
            yield

    def drawing(visitor: Visitor, now: float, elapsed: float) -> None:
        done.append(("frame", visitor.client.client_id))
        frame(visitor, now, elapsed)

    monkeypatch.setattr(Visitor, "build", building)
    monkeypatch.setattr(Visitor, "frame", drawing)
    return done


def test_other_visitors_get_a_frame_between_any_two_pieces(
    by_hand: Made, pieces: list[tuple[str, int]]
) -> None:
    opened = by_hand(sessions=8)
    opened.let_in()
    host = private_of(opened)
    (neighbour,) = host.visitors
    pieces.clear()
    newcomers = [opened.come() for _ in range(3)]
    while len(host.visitors) < 4:
        before = len(host.visitors)
        opened.frame()
        assert len(host.visitors) <= before + 1
    built = [number for what, number in pieces if what == "piece"]
    # The pages are built one after the other, each in several pieces.
    assert (
        sorted(built) == built
        and all(built.count(number) >= 3 for number in set(built))
        and len(set(built)) == 3
    )
    places = [place for place, (what, _) in enumerate(pieces) if what == "piece"]
    assert all(("frame", neighbour) in pieces[a:b] for a, b in itertools.pairwise(places))
    for visitor in newcomers:
        # A page is sent complete.
        visitor.wait_for(
            lambda v: (
                v.mirror.replayed and len(v.mirror.commands) >= 14 and "/arms/left/base" in v.mirror.nodes
            )
        )


@pytest.mark.usefixtures("pieces")
def test_a_page_is_built_in_its_language_while_others_are_drawn(by_hand: Made) -> None:
    opened = by_hand(sessions=8)
    opened.let_in("lang=de")
    newcomer = opened.let_in("lang=sl")
    newcomer.wait_for(lambda v: len(v.mirror.commands) >= 14)
    labels = {str(element.get("label")) for element in list(newcomer.mirror.gui.values())}
    assert {"jezik", "prizor", "zakon"} <= labels and not {"Sprache", "Szene", "Gesetz"} & labels


def test_while_there_is_time_one_page_is_built_in_a_frame(
    by_hand: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "SLICE", 1e9)
    opened = by_hand(sessions=8)
    host = private_of(opened)
    for _ in range(3):
        opened.come()
    for count in (1, 2, 3):
        opened.frame()
        assert len(host.visitors) == count and host.admission.busy == (count < 3)


def test_a_page_closed_while_it_is_built_is_dropped_for_the_next_one(
    by_hand: Made, pieces: list[tuple[str, int]]
) -> None:
    opened = by_hand(sessions=8)
    hasty, patient = opened.come(), opened.come()
    while not pieces:
        opened.frame()
    opened.leave(hasty)
    gone = pieces[-1][1]
    opened.frames()
    assert gone != visitor_of(opened).client.client_id
    patient.wait_for(lambda v: len(v.mirror.commands) >= 14)


def test_a_closed_tabs_waiting_actions_are_dropped(by_hand: Made) -> None:
    opened = by_hand()
    visitor = opened.let_in("resume=0123456789abcdef0123456789abcdef")
    (session,) = live_sessions(opened.house).values()
    settings = session.settings
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14)
    visitor.set_value(specs(Settings)["scene"].label, "A ball in the way (Fig. 1)")
    visitor.wait_for(lambda _: len(session.posts))
    opened.leave(visitor)
    opened.frame()
    assert not len(session.posts)
    session.advance(FRAME)
    assert session.settings == settings


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda *_: str(tmp_path))
    robot.cache_clear()
    table_glb.cache_clear()
    return tmp_path


def test_a_stored_robot_is_not_fitted_again_and_is_identical(store: Path) -> None:
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


def test_a_missing_mesh_is_built_by_a_worker(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preparation, "mesh_makers", lambda: [partial(preparation._furnish, "alone", True)])
    workers = Inline()
    Preparation((), workers).thread.join()
    (job,) = workers.waiting()
    assert not list(store.iterdir()) and table_glb.cache_info().currsize == 0
    workers.work()
    assert job.state == "done" and [file.suffix for file in store.iterdir()] == [".bin"]
    # A real worker has its own memory.
    table_glb.cache_clear()
    Preparation((), workers).thread.join()
    assert len(workers.jobs) == 1 and table_glb.cache_info().currsize == 1


@pytest.mark.thorough
def test_every_mesh_of_the_3d_view_is_prepared_under_its_key(house: OpenHouse, arrive: Arrive) -> None:
    for draw in mesh_makers():
        draw()
    guest = arrive(house())
    known = preparation.robot_glbs.cache_info().misses, table_glb.cache_info().misses
    for scene, name in (("solo", "panda"), ("hold", "ur5"), ("imitation", "lwr"), ("ball", "lwr")):
        guest.ask(lambda s, scene=scene, name=name: [s.change("robot", name), s.change("scene", scene)])
        guest.run_on(0.05)
    assert (preparation.robot_glbs.cache_info().misses, table_glb.cache_info().misses) == known


def test_icons_and_types_equal_visers_and_are_read_once(
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
    hints = type_hints(button)
    assert hints == get_type_hints(type(button._impl.props))
    assert hints is type_hints(gui.add_button("another"))
