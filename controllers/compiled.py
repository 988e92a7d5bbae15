"""Numerical loops: first in Python, then in machine code with the same bits.

numba keeps IEEE arithmetic and the written order of single float64 numbers, so a run does not depend on the
moment of the switch. Loading would delay the first picture, so a thread does it once the loops have run often
enough. Another process compiles, once on a machine, into a folder for later processes.
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
from typing import Any, Final, Generic, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from controllers.errors import first_line
from controllers.own_packages import own_command

P = ParamSpec("P")
R = TypeVar("R")

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.int64]
IndexPairs = NDArray[np.int64]
"""Arrays of a loop: float64[:], float64[:, :], int64[:] and int64[:, :] in its signature."""

PATIENCE: Final = 8000
"""Calls in Python before loading: about 1,000 steps, which cost as much as loading."""

GAIN: Final = 8.0

READ: Final = "DUET_LOOPS"
"""Environment variable: a second folder with machine code."""

_log = logging.getLogger("duet.compiled")
loops: list["Loop[..., Any]"] = []
_begun = threading.Lock()
_failed = threading.Event()
_calls = 0


class Loop(Generic[P, R]):
    """A function declared by `loop`."""

    def __init__(self, function: Callable[P, R], signature: str, fills: tuple[str, ...]) -> None:
        self.python, self.signature, self.fills = function, signature, fills
        self.__doc__ = function.__doc__
        self._machine: Callable[P, R] | None = None
        self.run: Callable[P, R] = self._counted
        loops.append(self)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        return self.run(*args, **kwargs)

    def compiled(self) -> Callable[P, R]:
        """Machine code; takes seconds unless it is in the folder."""
        import numba
        from numba.core.sigutils import normalize_signature

        if self._machine is None:
            function = self.python
            assert isinstance(function, FunctionType)
            code = function.__code__
            known = function.__globals__
            used = {name: known[name] for name in code.co_names if name in known}
            inner = {name: value.compiled() for name, value in used.items() if isinstance(value, Loop)}
            copy = FunctionType(code, {**known, **inner}, function.__name__)
            copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
            types, result = normalize_signature(self.signature)
            assert result is not None
            arguments = (
                kind.copy(readonly=name not in self.fills) if isinstance(kind, numba.types.Array) else kind
                for name, kind in zip(code.co_varnames, types, strict=False)
            )
            self._machine = numba.njit(result(*arguments), cache=True, error_model="numpy")(copy)
        return self._machine

    @property
    def loaded(self) -> bool:
        return self.run is self._machine

    def load(self) -> None:
        self.run = self.compiled()

    def _counted(self, *args: P.args, **kwargs: P.kwargs) -> R:
        global _calls
        _calls += 1
        if _calls == PATIENCE:
            begin_to_load()
        return self.python(*args, **kwargs)


def loop(signature: str, fills: tuple[str, ...] = ()) -> Callable[[Callable[P, R]], Loop[P, R]]:
    """Declare a loop: `@loop("float64(float64[:, :], float64, float64[:])", fills=("row",))`.

    Args:
        signature: numba's, with the types of the result and all arguments.
        fills: names of the arrays that the loop writes; all others may be read-only.
    """
    return lambda function: Loop(function, signature, fills)


def all_loaded() -> bool:
    return all(made.loaded for made in loops)


def begin_to_load() -> None:
    """Load machine code in a thread; a second call does nothing."""
    if _begun.acquire(blocking=False):
        threading.Thread(target=_attempt, args=(_load_or_compile,), name="duet-compiled").start()


def load_if_compiled() -> None:
    """Load machine code: at once if it exists, else in a thread."""

    def load() -> None:
        if (loops_folder() / "done").exists():
            _load()
        else:
            begin_to_load()

    _attempt(load)


def load_now() -> None:
    """Load machine code, compiling it if necessary."""
    _attempt(_load)


def _attempt(load: Callable[[], None]) -> None:
    """Load; if that fails, log it and continue in Python."""
    if _failed.is_set() or all_loaded():
        return
    try:
        load()
    except Exception as error:
        _failed.set()
        reason = first_line(error)
        _log.warning("A step stays slower than it could be: its loops cannot be compiled (%s).", reason)


def _load() -> None:
    loops_folder()
    for made in loops:
        made.load()


def _load_or_compile() -> None:
    done = loops_folder() / "done"
    if not done.exists():
        _log.info("The loops of a step are compiled, once on this machine; until then a step takes longer.")
        _compile_in_process()
    if done.exists():
        _load()


def _compile_in_process() -> None:
    """Compile in a process that ends with this one.

    Raises:
        RuntimeError: last line of the failed process.
    """
    modules = sorted({made.python.__module__ for made in loops})
    said = ""
    with subprocess.Popen(
        own_command(__name__, *modules),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        # Ctrl+C is for this process; the other one ends with it.
        process_group=0,
    ) as child:
        while child.returncode is None:
            if not threading.main_thread().is_alive():
                child.kill()
            with suppress(subprocess.TimeoutExpired):
                said = child.communicate(timeout=0.2)[1]
    if child.returncode != 0 and threading.main_thread().is_alive():
        raise RuntimeError((said.strip().splitlines() or [f"exit code {child.returncode}"])[-1])


def main() -> None:
    """Entry point of the compiling process; its arguments are modules."""
    try:
        for module in sys.argv[1:]:
            import_module(module)
        _load()
        (loops_folder() / "done").touch()
    except Exception as error:
        sys.exit(f"{type(error).__name__}: {first_line(error)}")


def loops_folder() -> Path:
    """Folder of the machine code for this source, interpreter and processor; sets numba's cache folder.

    Raises:
        ImportError: numba cannot be imported, for example because numpy is too new.
        OSError: the folder cannot be made.
    """
    import numba
    from llvmlite import binding
    from numba.core import config

    digest = hashlib.sha256(f"{numba.__version__} {sys.version} {binding.get_host_cpu_name()}".encode())
    declared = {made.python.__code__.co_filename for made in loops if isinstance(made.python, FunctionType)}
    for file in sorted({__file__, *declared}):
        digest.update(Path(file).read_bytes())
    name = f"loops-{digest.hexdigest()[:16]}"
    beside = Path(__file__).parent / "__pycache__"
    place = beside if os.access(beside, os.W_OK) else Path.home() / ".cache" / "lwr-duet"
    folder = place / name
    for other in (beside, Path(os.environ.get(READ, place))):
        if (other / name / "done").exists() and not (folder / "done").exists():
            # numba does not read a folder that it cannot write.
            shutil.copytree(other / name, folder, dirs_exist_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    config.CACHE_DIR = str(folder)  # pyright: ignore[reportAttributeAccessIssue]
    return folder
