"""Targets of every kind, and runs in which a person wanted some."""

import numpy as np
from hypothesis import strategies as st

from scenes.inputs import InputsLog, Recorded
from scenes.inputs_file import recorded_bytes
from scenes.settings import RunSettings, SceneName, changed
from scenes.simulation import Simulation
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget, Target

SCENES: tuple[SceneName, ...] = ("solo", "ball", "hold", "master_slave", "imitation")
NUMBER = st.floats(allow_nan=False, width=64)


def arrays(count: int) -> st.SearchStrategy[np.ndarray]:
    """`count` numbers, of any size and sign."""
    return st.lists(NUMBER, min_size=count, max_size=count).map(np.array)


def turned(way: np.ndarray) -> np.ndarray:
    """The same numbers, laid out column by column."""
    return way.reshape(3, 3).T


TARGETS: st.SearchStrategy[Target | None] = st.one_of(
    st.none(),
    st.builds(
        HandTarget, arrays(3), st.none() | arrays(9).map(lambda a: a.reshape(3, 3)) | arrays(9).map(turned), st.none() | arrays(3)
    ),
    st.builds(JointTarget, st.integers(1, 14).flatmap(arrays)),
    st.builds(BallTarget, arrays(3)),
    st.builds(AnglesTarget, st.none() | arrays(8).map(lambda a: a.reshape(2, 4))),
)


def same(a: Target | None, b: Target | None) -> bool:
    """Whether two targets are the same to the last bit, layout in memory included."""
    if a is None or b is None:
        return a is b
    if type(a) is not type(b) or len(a) != len(b):
        return False
    for x, y in zip(a, b, strict=True):
        if x is None or y is None:
            if x is not y:
                return False
        elif x.tobytes("A") != y.tobytes("A") or x.shape != y.shape or x.flags.fnc != y.flags.fnc:
            return False
    return True


def scene_settings(scene: SceneName, **changes: object) -> RunSettings:
    """The default settings in a scene."""
    settings = changed(RunSettings(), "scene", scene)
    for key, value in ({"ball": "cross"} if scene == "ball" else {} | changes).items():
        settings = changed(settings, key, value)
    return settings


def logged_run(settings: RunSettings, seconds: float, log: InputsLog | None = None) -> tuple[Simulation, InputsLog]:
    """A run with the experiment's own person, and the log of it."""
    simulation, log = Simulation(settings), log or InputsLog()
    person = simulation.source()
    for _ in range(round(seconds / settings.dt)):
        target = person.target(simulation.time)
        log.record(simulation, target)
        simulation.step(target)
    return simulation, log


def everything(log: InputsLog) -> Recorded:
    """All that is in a log."""
    recorded = log.window(1e9)
    assert recorded is not None
    return recorded


def sample_file(scene: SceneName = "hold", seconds: float = 1.3) -> tuple[Recorded, bytes]:
    """Recorded inputs with a change of settings in their middle, and their file."""
    simulation, log = logged_run(scene_settings(scene), seconds)
    simulation.apply(changed(simulation.settings, "k", 3.0))
    for _ in range(30):
        log.record(simulation, None)
        simulation.step(None)
    return everything(log), recorded_bytes(everything(log))


_samples: dict[str, tuple[Recorded, bytes]] = {}


def sample() -> Recorded:
    """Recorded inputs that are shared by several tests; only to be read."""
    return _samples.setdefault("hold", sample_file())[0]


def sample_data() -> bytes:
    """Their file."""
    return _samples.setdefault("hold", sample_file())[1]
