"""Child processes for computations."""

import copyreg
import multiprocessing
import os
import runpy
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from ctypes import c_bool
from itertools import chain, islice
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess
from types import MappingProxyType
from typing import Any, Final, TypeVar

from controllers import own_packages
from controllers.errors import DuetError
from scenes.given_robots import GivenAtStart, given_at_start

T = TypeVar("T")

ComputeMany = Callable[[Callable[..., T], Sequence[tuple[Any, ...]]], Iterator[tuple[int, T]]]
"""Yields (index, result) of calls as they finish, like `computed`."""

AHEAD: Final = 4
"""Calls handed out per worker, one of which runs."""

ONE_THREAD: Final = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "VECLIB_MAXIMUM", "NUMEXPR")
}


SAFE_PATH: Final = {"PYTHONSAFEPATH": "1"}
"""Keeps the current folder off Python's path, where a `random.py` would hide the standard library's."""


class _OwnProcess(SpawnProcess):
    def __reduce__(self) -> Any:
        # Its attributes are read in order, and the first one needs none of our modules.
        return copyreg._reconstructor, (SpawnProcess, object, None), {"_found": _Found(), **self.__dict__}  # type: ignore[attr-defined]


class _Found:
    def __reduce__(self) -> Any:
        return runpy.run_path, (own_packages.__file__,)


class _OwnSpawn(SpawnContext):
    Process = _OwnProcess


SPAWN: Final = _OwnSpawn()
"""`multiprocessing` context for all our processes; start them inside `child_environment` or `inheriting`."""


def inheriting() -> AbstractContextManager[None]:
    """`child_environment` with linear algebra on one thread per process."""
    return child_environment(ONE_THREAD)


@contextmanager
def child_environment(also: Mapping[str, str] = MappingProxyType({})) -> Iterator[None]:
    """Keep Ctrl+C and the current folder from processes started meanwhile. `also`: further variables."""
    environment = {**SAFE_PATH, **also}
    before = {name: os.environ.get(name) for name in environment}
    os.environ.update(environment)
    try:
        with _interrupts_held():
            yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Keep Ctrl+C from processes that this thread starts meanwhile, until they call `leave_with_parent`. Here
    it is delivered at the end.

    May start the resource tracker, a Python process, so only `child_environment` calls it.
    """
    pending: list[int] = []
    main = threading.current_thread() is threading.main_thread()
    # A mask is not enough: another thread may receive the signal, and a half-started process would report
    # an error.
    handler = signal.signal(signal.SIGINT, lambda number, frame: pending.append(number)) if main else None
    mask: set[int] | None = None
    try:
        if hasattr(signal, "pthread_sigmask"):
            # Otherwise the first process would start it, which lifts the mask.
            resource_tracker.ensure_running()
            mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        yield
    finally:
        if mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if main:
            signal.signal(signal.SIGINT, handler)
        if pending:
            signal.raise_signal(signal.SIGINT)


def leave_with_parent() -> None:
    """Leave Ctrl+C to the parent of this worker, and end with it even if it is killed: an idle worker would
    wait for ever. No effect without a parent.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def computed(
    function: Callable[..., T],
    calls: Iterable[tuple[Any, ...]],
    workers: int = 1,
) -> Iterator[tuple[int, T]]:
    """Yield (index, result) of every call as it finishes; in order only with one worker.

    Args:
        function: at a module's top level.
        calls: picklable arguments of each call, read lazily.
        workers: processes; 1 runs everything in this one. Each imports the main program again, which must
            call this below `if __name__ == "__main__":`.

    Raises:
        DuetError: a worker was killed, or could not start.
    """
    numbered = enumerate(calls)
    first = list(islice(numbered, 2))
    waiting = chain(first, numbered)
    if workers <= 1 or len(first) <= 1:
        for index, arguments in waiting:
            yield index, function(*arguments)
        return
    # Not forked: this process may have threads, and a fork would copy their locks.
    begun = SPAWN.RawValue(c_bool, False)
    with inheriting():
        # Its locks start the resource tracker.
        pool = futures.ProcessPoolExecutor(workers, SPAWN, _begin, (given_at_start(), begun))
    others = multiprocessing.active_children()
    under_way: dict[futures.Future[T], int] = {}

    def hand_out(count: int) -> None:
        # A process is started if none is idle.
        with inheriting():
            under_way.update(
                (pool.submit(function, *arguments), index) for index, arguments in islice(waiting, count)
            )

    try:
        hand_out(AHEAD * workers)
        while under_way:
            done = futures.wait(under_way, return_when=futures.FIRST_COMPLETED).done
            hand_out(len(done))
            for task in done:
                yield under_way.pop(task), task.result()
    except (KeyboardInterrupt, GeneratorExit):
        # A call may take minutes.
        for worker in multiprocessing.active_children():
            if worker not in others:
                worker.terminate()
        raise
    except BrokenProcessPool:
        if not begun.value:
            raise DuetError(
                'The workers could not start; in a script, compute below if __name__ == "__main__":, because each worker '
                "reads the script again."
            ) from None
        raise DuetError(
            "A worker was ended from outside (out of memory?); give the same command again, with fewer --workers."
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(given: GivenAtStart, begun: Any) -> None:
    begun.value = True
    # Takes a second, which the parent need not spend.
    from scenes.headless import ready

    leave_with_parent()
    ready(given)
