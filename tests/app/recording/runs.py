"""Recorded runs, computed once, and readers of exported films."""

import gzip
import json
import struct
from functools import cache
from typing import Any

import msgspec
import zstandard

from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS
from scenes.inputs import Recorded
from tests.scenes.helpers import given_settings, recorded_run

SCENES = tuple(EXPERIMENTS)


@cache
def piece(
    scene: str, seconds: float = 3.0, window: float = 99.0, lively: bool = False, law: str = "smooth_priority"
) -> tuple[Recorded, Array]:
    """Part of a run with the experiment's own person, and its table. `lively`: the settings change twice."""
    settings = given_settings(scene=scene, law=law, ball="cross" if scene == "ball" else "still")
    changes: dict[float, dict[str, Any]] = (
        {0.45: {"dm": 0.11}, 0.7: {"k": 3.0, "dt": 0.004, "v": 0.4}} if lively else {}
    )
    simulation, recorded = recorded_run(settings, seconds, window, changes)
    return recorded, simulation.history.table(recorded.steps)


def read_film(data: bytes) -> tuple[dict[str, Any], bytes]:
    plain = gzip.decompress(data)
    (length,) = struct.unpack_from("<I", plain)
    return json.loads(plain[4 : 4 + length]), plain[(4 + length + 7) // 8 * 8 :]


def read_scene(data: bytes) -> dict[str, Any]:
    """Contents of a recording in viser's format, without its arrays."""
    (size,) = struct.unpack_from("<Q", data)
    body = zstandard.ZstdDecompressor().decompress(data[8:], max_output_size=size)
    (length,) = struct.unpack_from("<Q", body)
    return msgspec.msgpack.decode(body[8 : 8 + length])
