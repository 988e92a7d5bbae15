"""Loops run as Python or as machine code, with the same bits; machine code never keeps anything waiting."""

import hashlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from controllers import compiled
from scenes.guide import fill_smoothed
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import with_values

RUNS: dict[str, dict[str, str]] = {
    "convex distances": {},
    "soft minimum, a whole pose": {"pairs": "soft", "task": "pose"},
    "closest pair, both arms": {"pairs": "single", "scene": "master_slave"},
    "the person": {"scene": "imitation"},
    "nothing but obstacles": {"scene": "solo"},
}


@pytest.fixture
def both_ways() -> Iterator[None]:
    """Whatever the test chooses, other tests go on with machine code."""
    yield
    compiled.load_now()


def table(changes: dict[str, str]) -> bytes:
    simulation = Simulation(with_values(RunSettings(hand_speed=1.0), **changes))
    person = simulation.source()
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    for k in range(160):
        # Between two far places, so that joints meet their bounds.
        pulled = HandTarget(hand + np.array([0.5, 0.0, -0.8]) * (k % 2))
        simulation.step(pulled if "scene" not in changes else person.target(simulation.time))
    return simulation.history.table().tobytes()


@pytest.mark.parametrize("changes", RUNS.values(), ids=RUNS)
@pytest.mark.usefixtures("both_ways")
def test_python_and_machine_code_give_the_same_bits(changes: dict[str, str]) -> None:
    compiled.load_now()
    fast = table(changes)
    for made in compiled._loops:
        made._run = made.python
    assert table(changes) == fast


@pytest.mark.usefixtures("both_ways")
def test_python_and_machine_code_give_the_same_types() -> None:
    """What a loop returns is drawn and compared: a number of numpy is none of Python's."""
    simulation = Simulation(RunSettings())
    for made in compiled._loops:
        made._run = made.python
    simulation.step(None)
    near = simulation.near
    assert near is not None and {type(near.law_distance), type(near.distance), type(simulation.bound_bites)} == {float, bool}
    assert type(fill_smoothed(np.ones(2), 0.5, np.ones(2), np.ones(2), np.ones(2), np.ones(2))) is float


WATCHED = """
import hashlib, sys, time
from controllers import compiled
from scenes.guide import fill_smoothed
from scenes.settings import RunSettings
from scenes.simulation import Simulation
simulation = Simulation(RunSettings())
person = simulation.source()
def steps(count):
    for _ in range(count):
        simulation.step(person.target(simulation.time))
steps(20)
print("numba" in sys.modules)
deadline = time.monotonic() + 120.0
while time.monotonic() < deadline and (WAITING):
    steps(20)
print("numba" in sys.modules, simulation.steps)
print(hashlib.sha256(simulation.history.table().tobytes()).hexdigest())
"""


def test_a_short_run_loads_nothing_and_a_long_one_does_not_wait_and_another_process_finds_the_same_bits() -> None:
    code = WATCHED.replace("WAITING", "any(made._run != made._machine for made in compiled._loops)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True)
    short, long, bits = done.stdout.splitlines()
    assert short == "False" and long.split()[0] == "True" and int(long.split()[1]) > 100
    # There the loops became machine code in the middle of the run, here they are it from the beginning.
    compiled.load_now()
    simulation = Simulation(RunSettings())
    person = simulation.source()
    for _ in range(int(long.split()[1])):
        simulation.step(person.target(simulation.time))
    assert hashlib.sha256(simulation.history.table().tobytes()).hexdigest() == bits


def test_without_the_compiler_a_run_goes_on_in_python_and_a_line_says_so() -> None:
    code = "import sys; sys.modules['numba'] = None\n" + WATCHED.replace("WAITING", "simulation.steps < 1500")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True)
    assert done.stdout.splitlines()[1].endswith(" 1500") and "cannot be compiled" in done.stderr


def test_the_listening_process_loads_no_compiler_and_every_loop_comes_with_the_simulation() -> None:
    """A loop that came later, with an experiment, would stay Python where the others have been loaded."""
    code = (
        "import sys, app.hosting.dispatcher, app.start; print('numba' in sys.modules); from controllers import compiled; "
        "print(*sorted({made.python.__module__ for made in compiled._loops}))"
    )
    with_compiler, modules = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    root = Path(compiled.__file__).parents[1]
    files = (path for room in ("controllers", "scenes", "app") for path in (root / room).rglob("*.py"))
    loops = [".".join(path.relative_to(root).with_suffix("").parts) for path in files if "\n@Loop\n" in path.read_text("utf-8")]
    assert with_compiler == "False" and modules.split() == sorted(loops) != []
