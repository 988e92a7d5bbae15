"""Replaced parts of viser: same messages, with a constant time stamp, packed once for all browsers."""

import asyncio
import importlib.util
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType, SimpleNamespace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pytest
import viser
import viser.infra._infra as viser_infra
import websockets
from hypothesis import given
from hypothesis import strategies as st
from viser import _assignable_props_api, _gui_api, _gui_handles, _scene_handles
from viser import _messages as viser_messages
from viser._assignable_props_api import AssignablePropsBase

import app.web.sending
from app.web import viser_internals
from app.web.headless_client import decode_frame
from app.web.sending import STAMP, ClientBuffer, Packed
from app.web.server import DuetServer
from app.web.viser_internals import (
    VISER_VERSION,
    MessageBuffer,
    ServerView,
    adapt_viser,
    nodes_of,
    serving_with,
    shared_messages,
)
from tests.app.viser_private import message_producer
from tests.app.web.conftest import Join, Room, in_a_loop
from tests.blocking_client import BlockingClient


def untouched(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """An unmodified copy of a module of viser."""
    assert module.__file__ is not None
    spec = importlib.util.spec_from_file_location(f"{module.__name__}_untouched", module.__file__)
    assert spec is not None and spec.loader is not None
    copy = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, copy)
    spec.loader.exec_module(copy)
    return copy


@pytest.fixture
def visers_own(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """viser's unmodified networking, with its clock."""
    return untouched(viser_infra, monkeypatch)


def produced(
    produce: Callable[..., Any], batches: list[list[viser_messages.Message]], client_id: int = 1
) -> list[bytes]:
    async def run() -> list[bytes]:
        sent: list[bytes] = []

        async def send(data: bytes) -> None:
            sent.append(data)

        buffer = MessageBuffer(asyncio.get_running_loop(), persistent_messages=True, window_duration_sec=0.0)
        work = asyncio.create_task(produce(SimpleNamespace(send=send), buffer, client_id))
        for number, batch in enumerate(batches, 1):
            buffer.atomic_start()
            for message in batch:
                buffer.push(message)
            buffer.atomic_end()
            while len(sent) < number:
                await asyncio.sleep(0)
        buffer.set_done()
        await work
        return sent

    return in_a_loop(run())


def odd_values() -> list[dict[str, Any]]:
    """Values of all types of a property, each in a separate dictionary, so that all are sent."""
    values = [True, np.True_, 3, np.int64(3), 0.5, np.float32(0.5), np.str_("text"), None]
    mixed = [(1, np.float64(2.0)), [np.uint8(1), "a"], (np.zeros(0), np.ones(2)), {"inside": np.arange(3)}]
    arrays = [np.arange(6, dtype=np.float16).reshape(2, 3).T]
    return [{f"p{i}": value} for i, value in enumerate(values + mixed + arrays)]


def some_batches() -> list[list[viser_messages.Message]]:
    turned, moved = viser_messages.SetOrientationMessage, viser_messages.SetPositionMessage
    updated = viser_messages.GuiUpdateMessage
    curve = {"data": (np.linspace(0.0, 1.0, 7), np.arange(3, dtype=np.float32))}
    return [
        [turned("/a", (1.0, 0.0, 0.0, 0.0)), moved("/a", (0.1, 0.2, 0.3))],
        [updated("u", curve), moved("/a", (0.2, 0.2, 0.3)), updated("v", {"x": "é"})],
        [
            viser_messages.SetSceneNodeVisibilityMessage("/a", False),
            viser_messages.RemoveSceneNodeMessage("/b"),
        ],
        [viser_messages.SceneNodeUpdateMessage("/a", values) for values in odd_values()],
        [
            viser_messages.GuiHtmlMessage(
                "w", "root", viser_messages.GuiHtmlProps(order=1, content="<b>", visible=True)
            )
        ],
    ]


def test_sent_messages_equal_visers(visers_own: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visers_own, "time", SimpleNamespace(perf_counter=lambda: STAMP))
    batches = some_batches()
    send = partial(app.web.sending.send_windows, backlog_done_message=None, seen=lambda: asyncio.sleep(0))
    ours = produced(send, batches)
    assert ours == produced(message_producer(visers_own), batches)
    # A connection of another server gets viser's own loop, with its clock.
    adapt_viser(ClientBuffer)
    assert produced(message_producer(viser_infra), batches) != ours
    messages, _ = decode_frame(ours[1])
    assert [message["type"] for message in messages] == [
        "GuiUpdateMessage",
        "SetPositionMessage",
        "GuiUpdateMessage",
    ]
    np.testing.assert_array_equal(messages[0]["updates"]["data"][1], [0.0, 1.0, 2.0])


def test_the_time_stamp_is_constant_so_that_a_page_delays_no_batch(
    room: Room, join: Join, visers_own: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = (
        decode_frame(frame)[1] for frame in produced(message_producer(visers_own), some_batches()[:2])
    )
    assert second > first > 0.0, "viser's own stamps no longer increase: the constant stamp is not needed"

    stamps: list[float] = []

    def note(frame: bytes) -> tuple[list[dict[str, Any]], float]:
        messages, stamp = decode_frame(frame)
        stamps.append(stamp)
        return messages, stamp

    monkeypatch.setattr("app.web.headless_client.decode_frame", note)
    visitor = join()
    for value in (0.11, 0.12, 0.13):
        room.slider.value = value
        visitor.wait_for(lambda v, value=value: v.mirror.labelled("d_m")["value"] == value)
    assert len(stamps) >= 4 and len(set(stamps)) == 1


def test_a_message_to_all_is_packed_once(room: Room, join: Join, monkeypatch: pytest.MonkeyPatch) -> None:
    visitors = [join() for _ in range(5)]
    packed: list[list[str]] = []
    pack = app.web.sending.pack

    def note(messages: Any) -> bytes:
        packed.append([f"{type(m).__name__} {getattr(m, 'updates', '')}" for m in messages])
        return pack(messages)

    monkeypatch.setattr(app.web.sending, "pack", note)
    for value in (0.11, 0.12, 0.13):
        room.slider.value = value
        room.server.flush()
        for visitor in visitors:
            visitor.wait_for(lambda v, value=value: v.mirror.labelled("d_m")["value"] == value)
    assert packed == [[f"GuiUpdateMessage {{'value': {value}}}"] for value in (0.11, 0.12, 0.13)]

    packed.clear()
    visitors[0].set_value("d_m", 0.2)
    for visitor in visitors[1:]:
        visitor.wait_for(lambda v: v.mirror.labelled("d_m")["value"] == 0.2)
    assert len(packed) == 1 and join().mirror.labelled("d_m")["value"] == 0.2


def test_an_element_is_never_sent_in_an_old_state() -> None:
    packed, moved = Packed(), [viser_messages.SetPositionMessage("/a", (0.0, 0.0, 0.0))]
    assert packed.get(moved) is packed.get(list(moved))
    props = viser_messages.GuiHtmlProps(order=0.0, content="as it was made", visible=True)
    made = [viser_messages.GuiHtmlMessage("u", "root", props)]
    before = packed.get(made)
    props.content = "as it is now"
    assert packed.get(made) != before


def replaced() -> tuple[Any, ...]:
    icons = tuple(vars(module)["svg_from_icon"] for module in (_gui_api, _gui_handles))
    return message_producer(viser_infra), vars(AssignablePropsBase)["_prop_hints"], *icons


def test_viser_has_the_right_version_and_is_adapted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    assert VISER_VERSION.startswith("1.1.")
    adapt_viser(ClientBuffer)
    once = replaced()
    adapt_viser(ClientBuffer)
    assert replaced() == once and len({one.__module__ for one in once if hasattr(one, "__module__")}) == 1
    # Also after another program's change.
    monkeypatch.setattr(viser_infra, "_message_producer", None)
    adapt_viser(ClientBuffer)
    assert replaced() == once


@pytest.mark.parametrize(
    ("hint", "value", "name"),
    [
        (str, "text", "label"),
        (float | None, 1, "width"),
        (bool, True, "visible"),
        (Literal["a", "b"], "b", "kind"),
        (tuple[str, ...], ("one", "two"), "options"),
        (tuple[npt.NDArray[np.float64], ...], ([1, 2], np.array([3.0])), "data"),
        (tuple[int, int, int], (1, 2, 3), "color"),
        (npt.NDArray[np.float16], [[0.5, 1.0]], "points"),
        (npt.NDArray[np.float32], np.arange(3.0), "points"),
        (npt.NDArray[np.float64], (1, 2), "points"),
        (npt.NDArray[np.float32], 2, "points"),
        (npt.NDArray[np.uint8], np.array([0.0, 0.5, 1.0]), "colors"),
        (npt.NDArray[np.uint8], np.array([300, -1]), "color"),
        (npt.NDArray[np.uint8], np.array([1, 2], np.uint8), "bytes"),
    ],
)
def test_a_property_is_cast_as_viser_casts_it(
    hint: Any, value: Any, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    adapt_viser(ClientBuffer)
    original = untouched(_assignable_props_api, monkeypatch).AssignablePropsBase._cast_value_recursive
    handle: Any = SimpleNamespace()
    handle._cast_value_recursive = lambda *args: original(handle, *args)
    ours, theirs = (
        AssignablePropsBase._cast_value_recursive(handle, hint, value, name),
        original(handle, hint, value, name),
    )
    assert type(ours) is type(theirs)
    for one, other in zip(ours, theirs, strict=True) if isinstance(ours, tuple) else [(ours, theirs)]:
        assert getattr(one, "dtype", None) == getattr(other, "dtype", None)
        assert np.array_equal(one, other)


@dataclass
class Props:
    content: str
    visible: bool
    opacity: float | None
    color: tuple[int, int, int]
    points: npt.NDArray[np.float32]
    colors: npt.NDArray[np.uint8]
    faces: npt.NDArray[np.uint32]
    data: tuple[npt.NDArray[np.float64], ...]


class Handle(AssignablePropsBase[Any]):
    """An element that records the updates for its browser."""

    def __init__(self) -> None:
        line, white = np.zeros((2, 3), np.float32), np.full((2, 3), 255, np.uint8)
        props = Props("text", True, None, (1, 2, 3), line, white, np.zeros((1, 3), np.uint32), (np.zeros(2),))
        super().__init__(SimpleNamespace(props=props, removed=False, turned=0))
        self.noted: list[tuple[str, Any]] = []

    @property
    def turned(self) -> int:
        return self._impl.turned

    @turned.setter
    def turned(self, value: int) -> None:
        self._impl.turned = value
        self.noted.append(("turned", value))

    def _queue_update(self, name: str, value: Any) -> None:
        self.noted.append((name, value))


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("content", ["text", "other", "other", ""]),
        ("visible", [True, 1, False, np.False_]),
        ("opacity", [None, 0.5, 0.5, 1, 1.0, math.nan, math.nan]),
        ("color", [(1, 2, 3), [1, 2, 3], (3, 2, 1), (3, 2, 1)]),
        (
            "points",
            [
                np.zeros((2, 3)),
                [[1, 2, 3], [4, 5, 6]],
                np.ones((3, 3)),
                np.full((3, 3), np.nan),
                np.full((3, 3), np.nan),
            ],
        ),
        (
            "colors",
            [np.ones((2, 3)), np.ones((2, 3), np.uint8), np.zeros((2, 3), int), np.zeros(3, np.uint8)],
        ),
        ("faces", [np.ones((1, 3), np.uint32), np.ones((1, 3), np.uint32), np.ones((2, 3), np.uint32)]),
        ("data", [(np.zeros(2),), (np.zeros(2), [1, 2]), (np.empty(0),)]),
        ("turned", [1, 1, 2]),
        ("note", [1, 1]),
    ],
)
def test_a_property_is_set_as_viser_sets_it(
    name: str, values: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    adapt_viser(ClientBuffer)
    original = untouched(_assignable_props_api, monkeypatch).props_setattr
    ours: Any = Handle()
    theirs: Any = Handle()
    for value in values:
        setattr(ours, name, value)
        original(theirs, name, value)
        np.testing.assert_equal(getattr(ours, name), getattr(theirs, name))
    np.testing.assert_equal(ours.noted, theirs.noted)
    for (_, sent), (_, value) in zip(ours.noted, theirs.noted, strict=True):
        assert type(sent) is type(value) and getattr(sent, "dtype", None) == getattr(value, "dtype", None)
        assert not isinstance(sent, np.ndarray) or not np.shares_memory(sent, getattr(ours, name))
    ours._impl.removed = True
    if name != "note":
        with pytest.raises(RuntimeError, match="removed"):
            setattr(ours, name, values[-1])


def test_an_unchanged_property_is_not_processed(monkeypatch: pytest.MonkeyPatch) -> None:
    adapt_viser(ClientBuffer)
    handle: Any = Handle()
    monkeypatch.setattr(viser_internals, "props_setattr", None)
    handle.content, handle.visible, handle.points = "text", True, np.ones((2, 3))
    assert [name for name, _ in handle.noted] == ["points"]


@given(
    st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4),
    st.lists(st.sampled_from([0.0, 1e-9, 9e-6, 1.1e-5, 1.0]), min_size=4, max_size=4),
)
def test_a_pose_is_sent_exactly_if_viser_sends_it(old: list[float], step: list[float]) -> None:
    adapt_viser(ClientBuffer)
    new = tuple(a + b for a, b in zip(old, step, strict=True))
    current, queued = np.array(old), []
    vars(_scene_handles)["_set_pose_vector"](current, new, 4, queued.append, lambda pose: pose)
    moved = not np.allclose(new, old)
    assert queued == [new] * moved
    assert current.tolist() == list(new if moved else old)


def test_a_move_has_visers_redundancy_key() -> None:
    adapt_viser(ClientBuffer)
    for message in (
        viser_messages.SetPositionMessage("/a/b", (0.0, 0.0, 0.0)),
        viser_messages.SetOrientationMessage("/a/b", (1.0, 0.0, 0.0, 0.0)),
        viser_messages.SetSceneNodeVisibilityMessage("/a/b", True),
    ):
        assert message.redundancy_key() == viser_messages.Message.redundancy_key(message)


def test_the_replaced_serve_function_is_restored() -> None:
    def serve(*_: object) -> None: ...

    with pytest.raises(KeyError), serving_with(serve):
        assert vars(viser_infra)["websockets"].asyncio.server.serve is serve
        raise KeyError
    assert vars(viser_infra)["websockets"] is websockets


def test_a_view_has_its_own_messages(room: Any) -> None:
    server: DuetServer = room.server
    before = shared_messages(server)
    view = ServerView(server, before)
    view.scene.add_frame("/only here")
    names = [getattr(message, "name", "") for message in view.buffer.message_from_id.values()]
    assert "/hand" in names and "/only here" in names and shared_messages(server) == before
    with BlockingClient(server.url) as visitor:
        visitor.wait_for(lambda v: v.mirror.replayed)
        assert "/hand" in visitor.mirror.nodes and "/only here" not in visitor.mirror.nodes


def test_a_node_has_the_properties_sent_to_a_browser(room: Any) -> None:
    server: DuetServer = room.server
    line = server.scene.add_line_segments(
        "/over/line", np.zeros((1, 2, 3), np.float32), (0, 0, 0), visible=False
    )
    line.wxyz, line.position, line.thickness = (0.0, 1.0, 0.0, 0.0), (1.0, 2.0, 3.0), 7.0
    line.points = np.ones((1, 2, 3), np.float32)
    with BlockingClient(server.url) as visitor:
        visitor.wait_for(lambda v: v.mirror.replayed and "/over/line" in v.mirror.nodes)
        told, has = visitor.mirror.nodes["/over/line"], nodes_of(server.scene)["/over/line"]
    assert has.keys() <= told.keys() and {"points", "colors", "thickness"} < has.keys()
    for name, value in has.items():
        np.testing.assert_array_equal(np.ravel(value), np.ravel(told[name]), name)
    line.remove()
    assert "/over/line" not in nodes_of(server.scene)


def test_only_the_event_loop_wakes_the_browsers_of_a_view(room: Any) -> None:
    view = ServerView(room.server, [])
    buffer = view.buffer

    async def heard() -> bool:
        """True if a waiting browser is woken before the end of a frame that another thread pushes."""
        # The view's first messages have been announced.
        await asyncio.sleep(0)
        buffer.message_event.clear()
        waiting = asyncio.ensure_future(buffer.message_event.wait())
        await asyncio.sleep(0)
        buffer.atomic_start()
        await asyncio.to_thread(view.scene.set_up_direction, "+y")
        early = buffer.message_event.is_set()
        buffer.atomic_end()
        await asyncio.wait_for(waiting, 60.0)
        return early

    assert not asyncio.run_coroutine_threadsafe(heard(), room.server.get_event_loop()).result(60.0)


def test_a_camera_is_aimed_despite_reports_of_its_browser() -> None:
    """The browser may report its view, even the new one, between any two messages."""
    eye, look_at, fov = np.array([2.0, 0.5, 1.0]), np.array([0.2, 0.0, 0.4]), 0.7
    queued: list[Any] = []
    connection = SimpleNamespace(queue_message=None)
    camera: Any = viser.CameraHandle(SimpleNamespace(_websock_connection=connection))  # type: ignore[arg-type]
    said = replace(
        camera._state,
        position=eye + 0.1,
        look_at=look_at.copy(),
        fov=fov,
        up_direction=np.array([0.0, 0.0, 1.0]),
        update_timestamp=1.0,
    )

    def report() -> None:
        camera._state = replace(said)

    def queue(message: Any) -> None:
        queued.append(message)
        report()

    connection.queue_message = queue
    for _ in range(2):
        queued.clear()
        viser_internals.aim(camera, eye, look_at, fov)
        assert [next(iter(vars(message).values())) for message in queued] == [tuple(eye), tuple(look_at), fov]
    queued.clear()
    report()
    camera.position, camera.look_at = eye, look_at
    sent = [message.look_at for message in queued if hasattr(message, "look_at")]
    assert sent and sent[-1] != tuple(look_at), "viser's own setters work now: aim is not needed"
