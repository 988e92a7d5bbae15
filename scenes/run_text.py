"""A short run as text for a link: settings and targets, bit for bit, from the room's own start."""

import base64
import json
import struct
import zlib
from typing import Final

import numpy as np

from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.inputs import Recorded, Stretch
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.packing import WIDTH, PackedTargets, planes_of, rows_of
from scenes.settings import RunSettings, changed, values
from scenes.simulation import Simulation
from scenes.targets import HandTarget, LinkTarget, Target

LONGEST_TEXT: Final = 3000
"""Longest text [characters]; many programs cut off longer links."""

LONGEST: Final = 60.0
"""Longest run in a text [s]."""

GRID: Final = 2.0**-13
"""Grid of positions [m], 0.12 mm, so that most bits of the numbers are 0."""

MOST_BYTES: Final = 200_000

_HEAD: Final = struct.Struct("<BHH")
_VERSION: Final = 1
_MOST: Final = 0xFFFF


def on_grid(target: Target | None) -> Target | None:
    """Target with a hand or link position on the grid."""
    if isinstance(target, HandTarget | LinkTarget):
        return target._replace(position=np.round(target.position / GRID) * GRID)
    return target


def run_text(recorded: Recorded) -> str:
    """Raises BadSetting if the run is too long, has several settings or another start."""
    settings, usual = recorded.settings, values(RunSettings())
    alike = len(recorded.stretches) == 1 and recorded.law is None and recorded.begin == 0.0
    if not alike or recorded_bytes(recorded) != recorded_bytes(
        _begun(settings, recorded.stretches[0].targets)
    ):
        raise BadSetting("Only a run from the beginning, under the same settings, fits into a link.")
    codes, counts, numbers = targets = recorded.stretches[0].targets
    about = json.dumps(
        {key: value for key, value in values(settings).items() if value != usual[key]}
    ).encode()
    parts = [about, codes.tobytes(), counts.astype("<u2").tobytes()]
    for places in _places(codes):
        parts.append(planes_of(numbers[_numbers(targets, places)]).tobytes())
    text = ""
    if recorded.seconds <= LONGEST and recorded.steps <= _MOST:
        body = zlib.compress(_HEAD.pack(_VERSION, len(about), len(codes)) + b"".join(parts), 9)
        text = base64.urlsafe_b64encode(zlib.crc32(body).to_bytes(4, "big") + body).decode().rstrip("=")
    if not 0 < len(text) <= LONGEST_TEXT:
        raise BadSetting("This push is too long for a link. Save it as a file: Keep and replay, Run.")
    return text


def run_of_text(text: str) -> Recorded:
    """Raises BadInputFile if the text is too long, damaged or impossible."""
    if len(text) > LONGEST_TEXT:
        raise BadInputFile(
            "push: is longer than {most} characters, and no link to a push is.", most=LONGEST_TEXT
        )
    try:
        data = base64.b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True)
        if zlib.crc32(data[4:]).to_bytes(4, "big") != data[:4]:
            raise ValueError
        recorded = _unpacked(zlib.decompressobj().decompress(data[4:], MOST_BYTES))
    except DuetError as error:
        raise BadInputFile("push: {reason}", reason=str(error)) from None
    except Exception:
        # A damaged text raises nearly every kind there is.
        raise BadInputFile("push: the link is damaged; copy it again.") from None
    if recorded.seconds > LONGEST:
        raise BadInputFile(
            "push: is a run of {seconds:.0f} s; at most {most:.0f} s.", seconds=recorded.seconds, most=LONGEST
        )
    # Every target is checked like one of a file.
    return recorded_from(recorded_bytes(recorded), "push")


def _unpacked(data: bytes) -> Recorded:
    version, head, count = _HEAD.unpack_from(data)
    if version != _VERSION:
        raise BadInputFile("the link is of another version of Duet.")
    begin = _HEAD.size + head
    settings = RunSettings()
    for key, value in json.loads(data[_HEAD.size : begin]).items():
        settings = changed(settings, key, value)
    codes = np.frombuffer(data, np.uint8, count, begin)
    counts = np.frombuffer(data, "<u2", count, begin + count).astype(np.uint32)
    targets = PackedTargets(codes, counts, np.zeros(int(WIDTH[codes].sum())))
    begin += 3 * count
    for places in _places(codes):
        width = int(WIDTH[codes[places[0]]])
        size = 8 * len(places) * width
        planes = np.frombuffer(data, np.uint8, size, begin).reshape(width, 8, len(places))
        targets.numbers[_numbers(targets, places)] = rows_of(planes)
        begin += size
    if begin != len(data):
        raise ValueError
    return _begun(settings, targets)


def _places(codes: np.ndarray) -> list[np.ndarray]:
    return [np.flatnonzero(codes == code) for code in np.unique(codes).tolist() if WIDTH[code]]


def _numbers(targets: PackedTargets, places: np.ndarray) -> np.ndarray:
    return targets.offsets[places][:, None] + np.arange(int(WIDTH[targets.codes[places[0]]]))


def _begun(settings: RunSettings, targets: PackedTargets) -> Recorded:
    return Recorded(Simulation(settings, 1).snapshot(), (Stretch(settings, targets),))
