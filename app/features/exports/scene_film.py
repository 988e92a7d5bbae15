"""A recorded run as a still 3-D scene in viser's format, and tracks of what moves.

The still scene is the last one, without nodes removed before.
"""

import math
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from app.session.frame import freeze
from app.session.replay import Replay, make_film
from app.session.replay_player import Past
from app.settings import PageSettings, Settings
from app.stage.camera_view import pose_of, view_of
from app.stage.stage import Stage
from app.web.server import DuetServer
from app.web.viser_internals import nodes_of
from scenes.inputs import Recorded
from scenes.wanted import while_wanted

RATE: Final = 20.0
"""Frames per simulated second."""

ASPECT: Final = 1.0
"""Width over height."""

TURN: Final = "wxyz"
PLACE: Final = "position"
SEEN: Final = "visible"


@dataclass
class Track:
    """Changes of one property of one node.

    Attributes:
        what: `TURN`, `PLACE`, `SEEN`, or a property of the node.
        frames: of the changes, ascending from 0.
        values: from each frame on.
    """

    node: str
    what: str
    frames: list[int] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def put(self, frame: int, value: Any) -> None:
        """Arrays are copied, as they may change."""
        if not self.frames or not _same(self.values[-1], value):
            self.frames.append(frame)
            self.values.append(value.flatten() if isinstance(value, np.ndarray) else value)


@dataclass(frozen=True)
class Filmed:
    """A moving scene.

    Attributes:
        scene: in viser's format, with every node that exists at the end.
        times: of the frames [s].
        bodies: nodes that must exist before anything moves.
    """

    scene: bytes
    tracks: tuple[Track, ...]
    times: tuple[float, ...]
    bodies: tuple[str, ...] = ()


def film_scene(recorded: Recorded, seconds: float, page: PageSettings) -> Filmed:
    """Film of the last `seconds` [s]; inf for all.

    Raises:
        BadSetting: the run is not possible here.
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
        tracks: dict[tuple[str, str], Track] = {}
        nodes: dict[str, dict[str, Any]] = {}
        bodies: tuple[str, ...] = ()
        for frame, time in enumerate(while_wanted(times)):
            replay.seek(time)
            stage.show(freeze(Past(replay, live), time), page)
            nodes = nodes_of(server.scene)
            if frame == 0:
                bodies = tuple(node for node, has in nodes.items() if "glb_data" in has)
            _note(nodes, tracks, frame)
        moving = tuple(track for track in tracks.values() if len(track.frames) > 1 and track.node in nodes)
        return Filmed(server.get_scene_serializer().serialize(), moving, times, bodies)
    finally:
        server.stop()


def _note(nodes: dict[str, dict[str, Any]], tracks: dict[tuple[str, str], Track], frame: int) -> None:
    for node, has in nodes.items():
        for what, value in has.items():
            track = tracks.get((node, what))
            if track is None:
                track = tracks[node, what] = Track(node, what)
                # A node that was added later had these values before, but was not visible.
                track.put(0, value if what != SEEN or frame == 0 else False)
            track.put(frame, value)
    for (node, what), track in tracks.items():
        if what == SEEN and node not in nodes:
            track.put(frame, False)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.dtype == b.dtype and a.tobytes() == b.tobytes()
    return type(a) is type(b) and a == b
