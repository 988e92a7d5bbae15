"""Targets of every kind, and recorded runs with them."""

import io
from functools import cache

import numpy as np
from hypothesis import strategies as st

from scenes.inputs import InputsLog, Recorded
from scenes.inputs_file import recorded_bytes
from scenes.packing import PackedTargets, encoded
from scenes.settings import changed
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget, LinkTarget, PairTarget, Target
from tests.scenes.helpers import logged_run, scene_settings

Arrays = st.SearchStrategy[np.ndarray]


def arrays(count: int, low: float | None = None, high: float | None = None) -> Arrays:
    return st.lists(st.floats(low, high, allow_nan=False), min_size=count, max_size=count).map(np.array)


def targets(
    places: Arrays, rotations: Arrays, joints: Arrays, angles: Arrays
) -> st.SearchStrategy[Target | None]:
    """Targets of all kinds, rotations also in column-major layout."""
    turned = rotations | rotations.map(np.asfortranarray)
    hands = st.builds(HandTarget, places, st.none() | turned, st.none() | places)
    people = st.builds(AnglesTarget, st.none() | angles.map(lambda a: a.reshape(2, 4)))
    links = st.builds(LinkTarget, st.integers(1, 6), places, places)
    return st.none() | hands | st.builds(JointTarget, joints) | st.builds(BallTarget, places) | links | people


ROTATIONS = arrays(9).map(lambda a: a.reshape(3, 3))
TARGETS = targets(arrays(3), ROTATIONS, st.integers(1, 14).flatmap(arrays), arrays(8))
"""Targets of any size."""


def same(a: Target | None, b: Target | None) -> bool:
    """True if two targets are equal to the bit, memory layout included."""
    if a is None or b is None or type(a) is not type(b) or len(a) != len(b):
        return a is b
    if isinstance(a, LinkTarget) and isinstance(b, LinkTarget) and a.joint != b.joint:
        return False
    if isinstance(a, PairTarget) and isinstance(b, PairTarget):
        return same(a.first, b.first) and same(a.second, b.second)
    fields = (
        [(x.tobytes("A"), x.shape, x.flags.fnc) if isinstance(x, np.ndarray) else None for x in target]
        for target in (a, b)
    )
    return next(fields) == next(fields)


def everything(log: InputsLog) -> Recorded:
    recorded = log.window(1e9)
    assert recorded is not None
    return recorded


@cache
def sample_file(scene: str = "hold", seconds: float = 1.3) -> tuple[Recorded, bytes]:
    """Recorded inputs with a change of settings in the middle, and their file; shared, read-only."""
    simulation, log = logged_run(scene_settings(scene), seconds)
    simulation.apply(changed(simulation.settings, "k", 3.0))
    for _ in range(30):
        log.record(simulation, None)
        simulation.step(None)
    return everything(log), recorded_bytes(everything(log))


def run_with(*wanted: tuple[Target | None, int]) -> Recorded:
    """The sample's inputs with these targets, each for a number of steps."""
    codes, numbers = zip(*(encoded(target) for target, _ in wanted), strict=True)
    counts = np.array([count for _, count in wanted], np.uint32)
    packed = PackedTargets(np.array(codes, np.uint8), counts, np.frombuffer(b"".join(numbers)))
    base, _ = sample_file()
    return Recorded(base.snapshot, (base.stretches[0]._replace(targets=packed),))


def rewritten(data: bytes, **parts: np.ndarray | None) -> bytes:
    """A file of recorded inputs with some parts replaced; None removes a part."""
    with np.load(io.BytesIO(data)) as arrays:
        found = {name: arrays[name] for name in arrays.files} | parts
    out = io.BytesIO()
    np.savez(out, **{name: array for name, array in found.items() if array is not None})  # pyright: ignore[reportArgumentType]
    return out.getvalue()


def as_bytes(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), np.uint8)
