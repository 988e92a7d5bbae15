"""The 3-D scene of a recorded run: a still scene in viser's format, and tracks of what moves from frame to frame.

The scene is built on a viser server without clients; its serializer records every message. Messages that add a node become the
still scene; later ones become tracks of a node's orientation, position, visibility or property.
"""

import json
import math
import struct
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import msgspec
import numpy as np
import zstandard

from app.session.frame import freeze
from app.session.replay import Replay, make_film
from app.session.replay_player import Past
from app.settings import PageSettings, Settings
from app.stage.camera_view import pose_of, view_of
from app.stage.stage import Stage
from app.web.server import DuetServer
from scenes.inputs import Recorded
from scenes.rerun import never, while_wanted

RATE: Final = 20.0
"""Frames a simulated second."""

ASPECT: Final = 1.0
"""Width over height of the part of the page that the scene takes, on a desk."""

TURN: Final = "wxyz"
PLACE: Final = "position"
SEEN: Final = "visible"

_SIZE: Final = struct.Struct("<Q")
_LEVEL: Final = 12


@dataclass
class Track:
    """How one thing of one node changes.

    Attributes:
        node: its name in the scene.
        what: `TURN`, `PLACE`, `SEEN`, or one of the node's own properties.
        frames: at which it changes, ascending; the first is 0.
        values: from each of them on: a row of numbers, an array, a text, a number, a flag.
    """

    node: str
    what: str
    frames: list[int] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def put(self, frame: int, value: Any) -> None:
        """Note a value from a frame on; a second one in the same frame replaces the first."""
        if self.frames and self.frames[-1] == frame:
            self.values[-1] = value
        elif not self.frames or not _same(self.values[-1], value):
            self.frames.append(frame)
            self.values.append(value)


@dataclass(frozen=True)
class Filmed:
    """A scene that moves.

    Attributes:
        scene: a still recording in viser's own format, of everything that is ever seen.
        tracks: what moves in it.
        times: of the frames [s], on the clock of the run.
        bodies: names of the nodes that must be there before anything moves: furniture, links, a person's limbs.
    """

    scene: bytes
    tracks: tuple[Track, ...]
    times: tuple[float, ...]
    bodies: tuple[str, ...] = ()


def film_scene(recorded: Recorded, seconds: float, page: PageSettings, stopped: Callable[[], bool] = never) -> Filmed:
    """Return the stage of the last `seconds` of a recorded piece, inf for all of it.

    Args:
        seconds: inf for all.
        page: theme, profile and kind of picture.
        stopped: asked now and then; when it says True, everything ends with `Stopped`.

    Raises:
        BadSetting: it cannot be made here.
    """
    replay = Replay(make_film(recorded))
    first = math.ceil(max(replay.begin, replay.end - seconds) * RATE - 1e-6)
    times = tuple(i / RATE for i in range(first, math.floor(replay.end * RATE + 1e-6) + 1)) or (replay.end,)
    server = DuetServer("127.0.0.1", 0, max_clients=1)
    try:
        server.scene.world_axes.visible = False
        replay.seek(times[0])
        stage = Stage(server.scene)
        start, pose = server.initial_camera, pose_of(view_of(replay.simulation), ASPECT)
        start.up = (0.0, 0.0, 1.0)
        start.position, start.look_at, start.fov = pose.eye, pose.look_at, pose.fov
        live = Settings(recorded.settings, page)
        stage.show(freeze(Past(replay, live), times[0]), page)
        serializer = server.get_scene_serializer()
        for time in while_wanted(times[1:], stopped):
            serializer.insert_sleep(1.0)
            replay.seek(time)
            stage.show(freeze(Past(replay, live), time), page)
        return _split(serializer.serialize(), times)
    finally:
        server.stop()


# --- viser's format ------------------------------------------------------------------------------------------------------------
# 8 bytes size, then zstd of: 8 bytes size, msgpack, and the arrays, each at a multiple of 8 bytes. An array stands in the msgpack as
# {"__binary_index": number, "dtype": …}.


def unpack_recording(data: bytes) -> tuple[dict[str, Any], list[bytes]]:
    """Return the content of a recording and its arrays."""
    (size,) = _SIZE.unpack_from(data)
    body = zstandard.ZstdDecompressor().decompress(data[8:], max_output_size=size)
    (length,) = _SIZE.unpack_from(body)
    content = msgspec.msgpack.decode(body[8 : 8 + length])
    arrays, at = [], 8 + length
    for size in content["binaryBufferLengths"]:
        at += -at % 8
        arrays.append(body[at : at + size])
        at += size
    return content, arrays


def pack_recording(content: dict[str, Any], arrays: list[bytes]) -> bytes:
    """Return a recording; the inverse of `unpack_recording`."""
    text = msgspec.msgpack.encode({**content, "binaryBufferLengths": [len(array) for array in arrays]})
    body = bytearray(_SIZE.pack(len(text)) + text)
    for array in arrays:
        body += bytes(-len(body) % 8) + array
    return _SIZE.pack(len(body)) + zstandard.ZstdCompressor(level=_LEVEL).compress(bytes(body))


def _split(data: bytes, times: tuple[float, ...]) -> Filmed:
    """Return the still scene and the tracks of a recording."""
    content, arrays = unpack_recording(data)
    still: list[list[Any]] = []
    tracks: dict[tuple[str, str], Track] = {}
    made: dict[str, dict[str, Any]] = {}
    since: dict[str, int] = {}
    for time, message in content["messages"]:
        frame, node = round(time), message.get("name", "")
        if "props" in message and node not in made:
            made[node], since[node] = message, frame
        changes = dict(_changes(message, node in made and made[node] is not message, arrays))
        if not changes:
            still.append([0.0, message])
            continue
        # What a node is put up with belongs to the scene, whenever that was.
        first = frame == since.get(node, 0)
        if first:
            still.append([0.0, message])
        for what, value in changes.items():
            track = tracks.setdefault((node, what), Track(node, what))
            if not track.frames:
                track.put(0, value if first else _before(made.get(node, {}), what, arrays))
            track.put(0 if first else frame, value)
    for node, frame in since.items():
        if frame > 0:
            # A node that was added later is hidden until then.
            seen = tracks.setdefault((node, SEEN), Track(node, SEEN, [0], [True]))
            later = bisect_right(seen.frames, frame)
            seen.frames, seen.values = [0, frame, *seen.frames[later:]], [False, *seen.values[later - 1 :]]
    places = list(_placeholders(still))
    used = {old: new for new, old in enumerate(sorted({place["__binary_index"] for place in places}))}
    for place in places:
        place["__binary_index"] = used[place["__binary_index"]]
    scene = pack_recording({**content, "durationSeconds": 0.0, "messages": still}, [arrays[i] for i in used])
    bodies = tuple(node for node, frame in since.items() if frame == 0 and made[node]["type"] == "GlbMessage")
    return Filmed(scene, tuple(track for track in tracks.values() if len(track.frames) > 1), times, bodies)


def _changes(message: dict[str, Any], again: bool, arrays: list[bytes]) -> Iterator[tuple[str, Any]]:
    """Yield the properties that a message changes and their values.

    Args:
        again: whether it adds a node that was there before, which is shown again.
    """
    match message["type"]:
        case "SetOrientationMessage":
            yield TURN, _row(message["wxyz"])
        case "SetPositionMessage":
            yield PLACE, _row(message["position"])
        case "SetSceneNodeVisibilityMessage":
            yield SEEN, bool(message["visible"])
        case "SceneNodeUpdateMessage":
            for what, value in message["updates"].items():
                yield what, _array(value, arrays)
        case "RemoveSceneNodeMessage":
            yield SEEN, False
        case _ if again:
            yield SEEN, True


def _before(message: dict[str, Any], what: str, arrays: list[bytes]) -> Any:
    if what == SEEN:
        return bool(message.get("visible", True))
    if what == TURN:
        return _row(message.get("wxyz") or (1.0, 0.0, 0.0, 0.0))
    if what == PLACE:
        return _row(message.get("position") or (0.0, 0.0, 0.0))
    return _array(message["props"][what], arrays)


def _row(values: Any) -> np.ndarray:
    return np.asarray(values, np.float64)


def _array(value: Any, arrays: list[bytes]) -> Any:
    if isinstance(value, dict) and "__binary_index" in value:
        return np.frombuffer(arrays[value["__binary_index"]], value["dtype"])
    return value


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    return type(a) is type(b) and json.dumps(a) == json.dumps(b)


def _placeholders(value: Any) -> Iterator[dict[str, Any]]:
    """Yield what stands for the arrays in messages."""
    if isinstance(value, dict) and "__binary_index" in value:
        yield value
    elif isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from _placeholders(entry)
