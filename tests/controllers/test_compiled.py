"""Loops give the same bits in Python and in machine code, and nothing waits for the compiler."""

import ast
import hashlib
import inspect
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from controllers import compiled
from scenes.guide import fill_smoothed
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.controllers.first_tasks.helpers import ALONE, posed, postures
from tests.scenes.helpers import with_values

RUNS: dict[str, dict[str, str]] = {
    "convex distances": {},
    "soft minimum, a whole pose": {"pairs": "soft", "task": "pose"},
    "closest pair, both arms": {"pairs": "single", "scene": "master_slave"},
    "the person": {"scene": "imitation"},
    "nothing but obstacles": {"scene": "solo"},
    "arms that glide along things": {"rig": "table", "world": "on"},
}


@pytest.fixture
def both_ways() -> Iterator[None]:
    """Restore machine code for the other tests."""
    yield
    compiled.load_now()


def table(changes: dict[str, str]) -> bytes:
    simulation = Simulation(with_values(RunSettings(hand_speed=1.0), **changes))
    person = simulation.source()
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    for k in range(160):
        # Between two distant targets, so that joints reach their bounds.
        pulled = HandTarget(hand + np.array([0.5, 0.0, -0.8]) * (k % 2))
        simulation.step(pulled if "scene" not in changes else person.target(simulation.time))
    return simulation.history.table().tobytes()


def margins() -> bytes:
    """h, J_a and w of every first task of a single arm."""
    found: list[float] = []
    for name in ALONE:
        of = posed(name)
        for q in postures(of, 40, 12):
            of.at(q)
            h, row, w = of.task.margin()
            found += [h, *row.tolist(), w]
    return np.array(found).tobytes()


@pytest.mark.usefixtures("both_ways")
def test_first_tasks_have_the_same_bits_in_python_and_machine_code() -> None:
    compiled.load_now()
    assert compiled.all_loaded()
    fast = margins()
    for made in compiled.loops:
        made.run = made.python
    assert margins() == fast


@pytest.mark.parametrize("changes", RUNS.values(), ids=RUNS)
@pytest.mark.usefixtures("both_ways")
def test_python_and_machine_code_give_the_same_bits(changes: dict[str, str]) -> None:
    compiled.load_now()
    assert compiled.all_loaded()
    fast = table(changes)
    for made in compiled.loops:
        made.run = made.python
    assert table(changes) == fast


@pytest.mark.usefixtures("both_ways")
def test_python_and_machine_code_give_the_same_types() -> None:
    """Results are drawn and compared: numpy's scalar types would make a difference."""
    simulation = Simulation(RunSettings())
    for made in compiled.loops:
        made.run = made.python
    simulation.step(None)
    near = simulation.near
    assert near is not None and {
        type(near.law_distance),
        type(near.distance),
        type(simulation.bound_bites),
    } == {float, bool}
    assert type(fill_smoothed(np.ones(2), 0.5, np.ones(2), np.ones(2), np.ones(2), np.ones(2))) is float


NUMBA = {
    "Vector": "float64[:]",
    "Matrix": "float64[:, :]",
    "Indices": "int64[:]",
    "IndexPairs": "int64[:, :]",
    "float": "float64",
    "int": "int64",
    "bool": "boolean",
    "None": "void",
}
"""Annotation of a loop's argument or result → type in its signature."""


def in_words_of_numba(annotation: ast.expr) -> str:
    match annotation:
        case ast.Subscript(value=ast.Name("tuple"), slice=ast.Tuple(parts)):
            (kind,) = {in_words_of_numba(part) for part in parts}
            return f"UniTuple({kind}, {len(parts)})"
        case _:
            return NUMBA[ast.unparse(annotation)]


def of_annotations(function: ast.FunctionDef) -> str:
    assert function.returns is not None
    arguments = [
        in_words_of_numba(argument.annotation) for argument in function.args.args if argument.annotation
    ]
    return f"{in_words_of_numba(function.returns)}({', '.join(arguments)})"


def written(function: ast.FunctionDef) -> set[str]:
    """Arguments that a loop writes, itself or by a loop that it calls."""
    known = {made.python.__name__: made for made in compiled.loops}
    names = {
        node.value.id
        for node in ast.walk(function)
        if isinstance(node, ast.Subscript)
        and isinstance(node.ctx, ast.Store)
        and isinstance(node.value, ast.Name)
    }
    for call in ast.walk(function):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id in known:
            made = known[call.func.id]
            given = inspect.signature(made.python).bind(*call.args).arguments
            for node in (given[name] for name in made.fills):
                names |= {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
    return names & {argument.arg for argument in function.args.args}


@pytest.mark.parametrize("made", compiled.loops, ids=lambda made: made.python.__name__)
def test_the_signature_matches_the_annotations_and_the_written_arrays(
    made: compiled.Loop[..., object],
) -> None:
    """pyright checks the annotations, numba the signature: it would truncate a float declared as an int."""
    (function,) = ast.parse(inspect.getsource(made.python)).body
    assert isinstance(function, ast.FunctionDef)
    assert made.signature == of_annotations(function)
    assert set(made.fills) == written(function)


def test_the_runs_here_call_every_loop() -> None:
    called: set[str] = set()

    def counted(made: compiled.Loop[..., object]) -> Callable[..., object]:
        def run(*args: object) -> object:
            called.add(made.python.__name__)
            return made.python(*args)

        return run

    before = [made.run for made in compiled.loops]
    for made in compiled.loops:
        made.run = counted(made)
    try:
        for changes in RUNS.values():
            table(changes)
        margins()
    finally:
        for made, run in zip(compiled.loops, before, strict=True):
            made.run = run
    assert called == {made.python.__name__ for made in compiled.loops}


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


def test_a_short_run_loads_no_compiler_and_a_long_run_keeps_the_same_bits() -> None:
    code = WATCHED.replace("WAITING", "any(made.run != made._machine for made in compiled.loops)")
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True
    )
    short, long, bits = done.stdout.splitlines()
    assert short == "False" and long.split()[0] == "True" and int(long.split()[1]) > 100
    # There the loops were compiled during the run; here they are compiled from the start.
    compiled.load_now()
    simulation = Simulation(RunSettings())
    person = simulation.source()
    for _ in range(int(long.split()[1])):
        simulation.step(person.target(simulation.time))
    assert hashlib.sha256(simulation.history.table().tobytes()).hexdigest() == bits


def test_without_a_compiler_a_run_continues_in_python_with_one_log_line() -> None:
    code = "import sys; sys.modules['numba'] = None\n" + WATCHED.replace("WAITING", "simulation.steps < 1500")
    code += "compiled.load_if_compiled(); compiled.load_now(); compiled.load_if_compiled()"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True
    )
    (line,) = done.stderr.splitlines()
    assert (
        done.stdout.splitlines()[1].endswith(" 1500") and "cannot be compiled (import of numba halted" in line
    )


@pytest.fixture
def another_machine(tmp_path: Path) -> Path:
    """Copy of the packages without compiled loops."""
    root = Path(compiled.__file__).parents[1]
    for package in ("controllers", "scenes"):
        shutil.copytree(root / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


FIRST_START = """
import threading
from controllers import compiled
from scenes.settings import RunSettings
from scenes.simulation import Simulation
simulation = Simulation(RunSettings())
compiled.begin_to_load()
for thread in threading.enumerate():
    if thread.name == "duet-compiled":
        thread.join()
simulation.step(None)
print(compiled.__file__, compiled.all_loaded())
"""


def first_start(folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", FIRST_START]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=280, check=True)


@pytest.mark.thorough
@pytest.mark.slow
def test_the_first_start_on_a_machine_compiles_every_loop_silently(another_machine: Path) -> None:
    done = first_start(another_machine)
    assert done.stdout == f"{another_machine / 'controllers' / 'compiled.py'} True\n" and done.stderr == ""


@pytest.mark.slow
def test_a_loop_that_cannot_be_compiled_is_logged_and_the_run_continues(
    another_machine: Path,
) -> None:
    file = another_machine / "controllers" / "kinematics.py"
    text = file.read_text("utf-8")
    assert text.count('"void(float64[:, :], int64,') == 1
    file.write_text(text.replace('"void(float64[:, :], int64,', '"void(float64[:], int64,'), "utf-8")
    done = first_start(another_machine)
    (line,) = done.stderr.splitlines()
    assert "cannot be compiled (TypingError: " in line and done.stdout.endswith("compiled.py False\n")


def test_the_command_imports_every_loop_and_no_compiler() -> None:
    """A loop imported later, with an experiment, would stay in Python after the others are compiled."""
    code = (
        "import sys, app.cli.serve, app.start; print('numba' in sys.modules); from controllers import compiled; "
        "print(*sorted({made.python.__module__ for made in compiled.loops}))"
    )
    with_compiler, modules = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    root = Path(compiled.__file__).parents[1]
    files = (path for room in ("controllers", "scenes", "app") for path in (root / room).rglob("*.py"))
    loops = [
        ".".join(path.relative_to(root).with_suffix("").parts)
        for path in files
        if "\n@loop(" in path.read_text("utf-8")
    ]
    # Plain functions that a loop calls are loops of the file that defines them.
    called = {"controllers.activation", "controllers.laws.situation"}
    assert with_compiler == "False" and sorted(set(modules.split()) - called) == sorted(loops) != []
