"""Calls on a Dask cluster: results as on one machine, while workers join and leave."""

import asyncio
import hashlib
import importlib.metadata
import logging
import platform
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache, partial
from itertools import islice
from pathlib import Path
from typing import Any, Final, TypeVar

import controllers
import scenes
from app.version import duet_version
from controllers.errors import BadSetting, DuetError, first_line
from controllers.system_libraries import naming_missing_library
from scenes.children import ComputeMany
from scenes.given_robots import GivenAtStart, GivenRobot, given_at_start, take_over

T = TypeVar("T")

Environment = dict[str, str]
"""What figures depend on → version or name."""

CONNECTING: Final = 10.0
"""Longest wait for a scheduler [s]."""

JOINING: Final = 10.0
"""Longest wait for its first worker [s]."""

ALONE: Final = 60.0
"""Longest wait without any worker [s]."""

AHEAD: Final = 2
"""Runs per worker thread: the current and the next."""

LIBRARIES: Final = ("numpy", "scipy", "pin", "libpinocchio", "coal", "libcoal", "daqp", "example-robot-data")
"""Distributions that affect the figures."""

_SAME: Final = (
    "install the same Duet there, with the extra `cluster` and requirements.lock, and start it again."
)
_GONE: Final = (
    "The scheduler is gone, or has dropped the runs. The rows so far are kept: give the same command again."
)

# A worker may have several threads; a run belongs to one.
_one_at_a_time: Final = threading.Lock()


@contextmanager
def on_dask(address: str) -> Iterator[ComputeMany[Any]]:
    """Function that computes on a scheduler's workers; at the end all calls are cancelled.

    Raises:
        BadSetting: no Dask, no scheduler, no workers, or a worker's environment would give other figures.
        DuetError: later, the same for a new worker, or the scheduler or all workers are gone.
    """
    client = _connected(address)
    from distributed.comm.core import CommClosedError

    try:
        _check(client, address)
        yield partial(_computed, client)
    except CommClosedError:
        # Regardless of the failed call.
        raise DuetError(_GONE) from None
    finally:
        client.close()


@cache
def environment() -> Environment:
    code = hashlib.sha256()
    for folder in (controllers.__path__[0], scenes.__path__[0]):
        for file in sorted(Path(folder).rglob("*.*")):
            if file.suffix in (".py", ".urdf"):
                code.update(file.read_bytes())
    return {
        "Duet": f"{duet_version()} (code {code.hexdigest()[:8]})",
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "processor": platform.machine(),
        **{name: _version(name) for name in LIBRARIES},
    }


def _version(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "none"


def _connected(address: str) -> Any:
    try:
        with naming_missing_library():
            from distributed import Client
    except ImportError:
        raise BadSetting(
            "--scheduler needs Dask, which is not installed: pip install 'lwr-duet[cluster]'."
        ) from None
    for name in ("distributed", "distributed.client", "tornado.application"):
        # Errors are reported in one line, below the progress bar.
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        # A notebook's own thread has a running event loop.
        with ThreadPoolExecutor(1) as thread:
            thread.submit(asyncio.run, asyncio.wait_for(_greet(address), CONNECTING)).result()
        return Client(address, timeout=CONNECTING)
    except (OSError, ValueError, TypeError) as error:
        raise BadSetting(
            f"scheduler = {address}: no Dask scheduler answers there ({first_line(error)}); start one with `dask scheduler`, and give its "
            "address, as in --scheduler tcp://host:8786."
        ) from None


async def _greet(address: str) -> None:
    """Connect once: `Client` waits for ever for a peer that never answers."""
    from distributed import Security
    from distributed.comm.core import connect

    comm: Any = await connect(address, CONNECTING, **Security().get_connection_args("client"))
    comm.abort()


def _check(client: Any, address: str) -> None:
    try:
        compare(f"scheduler {address}", environment(), client.run_on_scheduler(environment))
    except ImportError as error:
        compare(f"scheduler {address}", environment(), error)
    try:
        client.wait_for_workers(1, timeout=JOINING)
    except TimeoutError:
        raise BadSetting(
            f"scheduler = {address}: it has no workers; start one with `dask worker {address}`."
        ) from None
    for worker, answer in client.run(environment, on_error="return").items():
        # An OSError is that of a worker that is just leaving.
        if not isinstance(answer, OSError):
            compare(f"worker {worker}", environment(), answer)


def compare(place: str, here: Environment, there: Environment | Exception) -> None:
    if isinstance(there, Exception):
        raise BadSetting(f"The {place} has no Duet, or an older one ({first_line(there)}); {_SAME}") from None
    for name, version in here.items():
        if there.get(name) != version:
            raise BadSetting(
                f"The {place} has {name} {there.get(name)}, and this computer {version}: {_SAME}"
            )


def _computed(
    client: Any, function: Callable[..., T], calls: Sequence[tuple[Any, ...]]
) -> Iterator[tuple[int, T]]:
    from distributed import CancelledError, wait

    waiting, sent_along = iter(enumerate(calls)), (environment(), given_at_start())
    under_way: dict[Any, int] = {}
    while True:
        try:
            room = AHEAD * max(1, sum(client.nthreads().values())) - len(under_way)
            for index, arguments in islice(waiting, max(0, room)):
                future = client.submit(called_there, *sent_along, function, arguments, pure=False)
                under_way[future] = index
            if not under_way:
                return
            ended: Any = wait(list(under_way), ALONE, "FIRST_COMPLETED")
        except TimeoutError:
            if client.nthreads():
                continue
            raise DuetError(
                "The cluster has no workers any more. The rows so far are kept: start a worker, and give the same command again."
            ) from None
        except (OSError, CancelledError):
            raise DuetError(_GONE) from None
        for future in ended.done:
            yield under_way.pop(future), _result(future)


def _result(future: Any) -> Any:
    from distributed import CancelledError, KilledWorker

    try:
        return future.result()
    except CancelledError:
        raise DuetError(_GONE) from None
    except KilledWorker:
        raise DuetError(
            "One run has ended several workers (out of memory, or started later without Duet?); their logs say why. Then give the same "
            "command again."
        ) from None


# --- on a worker ---------------------------------------------------------------------------------------------------------------


def called_there(
    wanted: Environment, given: GivenAtStart, function: Callable[..., T], arguments: tuple[Any, ...]
) -> T:
    with _one_at_a_time:
        compare("worker that has joined", wanted, environment())
        for robot in given[0].values():
            _check_files(robot)
        take_over(given)
        return function(*arguments)


checked: Final[set[str]] = set()
"""Keys of robots with the right files on this worker."""


def _check_files(robot: GivenRobot) -> None:
    if robot.key not in checked:
        robot.check_files()
        checked.add(robot.key)
