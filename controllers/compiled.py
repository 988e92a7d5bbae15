"""Loops over numbers: Python at first, machine code as soon as that is loaded, with the same bits.

Such a loop does arithmetic on float64 numbers one by one. numba keeps to IEEE arithmetic and to the order that is written, so that
Python and machine code give the same bits, and a run does not depend on when one takes the other's place.

To import numba and to load what it has compiled takes longer than a first picture may wait, so this is done in a thread, once the
loops have been used often enough that it pays. What was never compiled on this machine is compiled by a process of its own, which
leaves it in a folder for all later ones.
"""

import hashlib
import logging
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import FunctionType
from typing import Annotated, Any, Final, Generic, NamedTuple, ParamSpec, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from controllers.own_packages import own_command

P = ParamSpec("P")
R = TypeVar("R")


class _Kind(NamedTuple):
    """What numba has to know of an array: type of its entries, dimensions, whether a loop fills it."""

    entries: str
    dimensions: int
    filled: bool = False


Vector = Annotated[NDArray[np.float64], _Kind("float64", 1)]
Matrix = Annotated[NDArray[np.float64], _Kind("float64", 2)]
Indices = Annotated[NDArray[np.int64], _Kind("int64", 1)]
IndexPairs = Annotated[NDArray[np.int64], _Kind("int64", 2)]
"""Arguments of a loop: arrays that it reads, …"""
FilledVector = Annotated[NDArray[np.float64], _Kind("float64", 1, True)]
FilledMatrix = Annotated[NDArray[np.float64], _Kind("float64", 2, True)]
"""… and those that it fills."""

PATIENCE: Final = 8000
"""Calls in Python before machine code is loaded: some 1,000 steps, which by then have cost as much as the loading will."""

GAIN: Final = 8.0
"""How many times as long a step takes in Python as in machine code, at least."""

READ: Final = "DUET_LOOPS"
"""Name in the environment of a folder from which machine code is taken, if the usual one does not have it."""

_log = logging.getLogger("duet.compiled")
_loops: list["Loop[..., Any]"] = []
_begun = threading.Lock()
_calls = 0


class Loop(Generic[P, R]):
    """A loop over numbers, called like the function that it is made of; used as a decorator.

    Args:
        function: with types for all arguments, of those above, float or int. It may call other loops.

    Attributes:
        python: the function.
    """

    def __init__(self, function: Callable[P, R]) -> None:
        self.python = function
        self.__doc__ = function.__doc__
        self._machine: Callable[P, R] | None = None
        self._run: Callable[P, R] = self._counted
        _loops.append(self)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Run it: arrays are arguments, those that it fills too."""
        return self._run(*args, **kwargs)

    def compiled(self) -> Callable[P, R]:
        """Return its machine code, with that of the loops which it calls; takes seconds if the folder does not have it."""
        import numba

        if self._machine is None:
            function = self.python
            assert isinstance(function, FunctionType)
            used = {name: function.__globals__[name] for name in function.__code__.co_names if name in function.__globals__}
            inner = {name: value.compiled() for name, value in used.items() if isinstance(value, Loop)}
            copy = FunctionType(function.__code__, {**function.__globals__, **inner}, function.__name__)
            copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
            self._machine = numba.njit(_signature(function), cache=True, error_model="numpy")(copy)
        return self._machine

    @property
    def loaded(self) -> bool:
        """Whether it is machine code by now."""
        return self._run is self._machine

    def load(self) -> None:
        """Replace Python by machine code."""
        self._run = self.compiled()

    def _counted(self, *args: P.args, **kwargs: P.kwargs) -> R:
        global _calls
        _calls += 1
        if _calls == PATIENCE:
            begin_to_load()
        return self.python(*args, **kwargs)


def _signature(function: Callable[..., Any]) -> Any:
    from numba import types

    def of(hint: Any) -> Any:
        match get_args(hint):
            case (_, _Kind() as kind):
                return types.Array(getattr(types, kind.entries), kind.dimensions, "A", readonly=not kind.filled)
            case (_, *_) as parts:
                return types.Tuple([of(part) for part in parts])
            case _:
                return {float: types.float64, int: types.int64, bool: types.boolean, type(None): types.none}[hint]

    hints = get_type_hints(function, include_extras=True)
    result = of(hints.pop("return"))
    return result(*map(of, hints.values()))


def begin_to_load() -> None:
    """Replace Python by machine code, from a thread; does nothing the second time."""
    if _begun.acquire(blocking=False):
        threading.Thread(target=_load, name="duet-compiled").start()


def all_loaded() -> bool:
    """Return whether all loops are machine code by now."""
    return all(made.loaded for made in _loops)


def load_if_compiled() -> None:
    """Replace Python by machine code: before returning if this machine has compiled it, else from a thread."""
    if all_loaded():
        return
    if (loops_folder() / "done").exists():
        load_now()
    else:
        begin_to_load()


def load_now() -> None:
    """Replace Python by machine code before returning."""
    loops_folder()
    for made in _loops:
        made.load()


def _load() -> None:
    try:
        done = loops_folder() / "done"
        if not done.exists():
            _log.info("The loops of a step are compiled, once on this machine; until then a step takes longer.")
            command = own_command(__name__, *sorted({made.python.__module__ for made in _loops}))
            with subprocess.Popen(command, stdin=subprocess.DEVNULL) as child:
                while child.poll() is None and threading.main_thread().is_alive():
                    with suppress(subprocess.TimeoutExpired):
                        child.wait(0.2)
                if child.returncode != 0:
                    child.kill()
        if done.exists():
            load_now()
    except Exception as error:
        _log.warning("A step stays slower than it could be: its loops cannot be compiled (%s).", error)


def loops_folder() -> Path:
    """Return the folder of the machine code for this text, this interpreter and this processor, and have numba use it."""
    import numba
    from llvmlite import binding
    from numba.core import config

    digest = hashlib.sha256(f"{numba.__version__} {sys.version} {binding.get_host_cpu_name()}".encode())
    for file in sorted({made.python.__code__.co_filename for made in _loops if isinstance(made.python, FunctionType)}):
        digest.update(Path(file).read_bytes())
    name = f"loops-{digest.hexdigest()[:16]}"
    beside = Path(__file__).parent / "__pycache__"
    place = beside if os.access(beside, os.W_OK) else Path.home() / ".cache" / "lwr-duet"
    folder = place / name
    for other in (beside, Path(os.environ.get(READ, place))):
        if (other / name / "done").exists() and not (folder / "done").exists():
            # numba reads nothing where it cannot write.
            shutil.copytree(other / name, folder, dirs_exist_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    config.CACHE_DIR = str(folder)  # pyright: ignore[reportAttributeAccessIssue]
    return folder


def main() -> None:
    """Compile the loops of the modules that are named as arguments, and leave them in the folder for all later processes."""
    for module in sys.argv[1:]:
        import_module(module)
    load_now()
    (loops_folder() / "done").touch()
