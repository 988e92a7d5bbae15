"""The page in worker processes: tabs are distributed, keep their worker, and outlive it."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from datetime import datetime, timedelta
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from urllib.request import urlopen

import pytest

from app.features import FEATURES
from app.features.workers import worker_process
from app.features.workers.dispatcher import MOST_OF_ADDRESS, MOST_OF_TAB, tab_of
from app.features.workers.worker_group import FEW, MOST_SILENT, MOST_STARTING, MOST_STOPPING, WorkerGroup
from app.features.workers.worker_messages import WorkerStart
from app.hosting.serve_options import ServeOptions
from app.settings import JOIN
from tests.app.features.store.kept import kept
from tests.app.features.workers.served import Serve, Served
from tests.app.page.helpers import hotkey_uuid
from tests.app.runtime.processes import gone, until
from tests.blocking_client import BlockingClient

pytestmark = pytest.mark.slow

LATE = 10
HOLD = "scene=hold&autopilot=0"


def connected(served: Served) -> socket.socket:
    host, port = served.url.removeprefix("http://").split(":")
    return socket.create_connection((host, int(port)))


def ended(connection: socket.socket) -> bool:
    """True if the server has closed a connection; waits until there is data or an end."""
    try:
        return connection.recv(1) == b""
    except ConnectionResetError:
        return True


def come(served: Served, number: int, query: str = "autopilot=0") -> BlockingClient:
    return served.come(f"{query}&resume={number:032d}")


def pause(visitor: BlockingClient) -> None:
    """Pause a run, which then needs almost no CPU, also after its restoration."""
    visitor.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(visitor, "pause")})


def peers_of(pid: int, visitor: BlockingClient) -> bool:
    """True if a process holds the other end of a visitor's connection."""
    port = visitor.local_port
    inodes: set[str] = set()
    # A file may be closed, and the process may end, between listing and reading.
    with suppress(FileNotFoundError, ProcessLookupError):
        for link in Path(f"/proc/{pid}/fd").iterdir():
            with suppress(FileNotFoundError):
                inodes.add(os.readlink(link))
    rows = [row.split() for row in Path("/proc/net/tcp").read_text(encoding="utf-8").splitlines()[1:]]
    return any(row[2].endswith(f":{port:04X}") and f"socket:[{row[9]}]" in inodes for row in rows)


def worker_of(served: Served, visitor: BlockingClient) -> int:
    found = [pid for pid in served.workers if peers_of(pid, visitor)]
    assert len(found) == 1
    return found[0]


def wait_for_second_worker(served: Served) -> None:
    """Wait until the second worker serves: newcomers without a place start it and finally reach it."""
    for number in count(1000):
        with BlockingClient(served.url, query=f"resume={number:032d}", camera=False) as newcomer:
            if worker_of(served, newcomer) in served.workers[1:]:
                return


@pytest.mark.parametrize(
    ("line", "tab", "word"),
    [
        (b"GET /?resume=0123456789abcdef HTTP/1.1\r", "0123456789abcdef", ""),
        (b"GET /?scene=ball&resume=0123456789abcdef&window=800x600 HTTP/1.1\r", "0123456789abcdef", ""),
        (
            b"GET /?guest=0123456789abcdef&resume=fedcba9876543210 HTTP/1.1\r",
            "fedcba9876543210",
            "0123456789abcdef",
        ),
        (b"GET /?noresume=0123456789abcdef&noguest=0123456789abcdef HTTP/1.1\r", "", ""),
        (b"GET /?resume=short HTTP/1.1\r", "", ""),
        (b"GET /?resume=0123456789ABCDEF HTTP/1.1\r", "", ""),
        (b"GET /healthz HTTP/1.1\r", "", ""),
        (b"\x16\x03\x01 no HTTP at all", "", ""),
        (b"", "", ""),
    ],
)
def test_tab_and_word_are_found_in_the_first_line_of_a_request(line: bytes, tab: str, word: str) -> None:
    assert (tab_of(line), tab_of(line, JOIN)) == (tab, word)


def answer_what_is_no_request(served: Served) -> None:
    for sent, status in (
        (b"GET /\r\n\r\n", 400),
        (b"GET /" + b"x" * 9000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n", 414),
        (b"GET / HTTP/1.1\r\nHost: localhost\r\nA: " + b"x" * 9000 + b"\r\n\r\n", 431),
        (b"GET / HTTP/1.0\r\n\r\n", 505),
    ):
        # A health check that disconnects.
        connected(served).close()
        with connected(served) as line:
            line.sendall(sent)
            assert line.recv(12) == f"HTTP/1.1 {status}".encode()
    until(lambda: "faulty request" in served.said())
    # The others are logged with the next line, once the first is some seconds old.
    when, _, said = served.said().splitlines()[0].partition(" WARNING duet.server: ")
    assert abs(datetime.now() - datetime.strptime(when, "%Y-%m-%d %H:%M:%S,%f")) < timedelta(hours=1)
    assert said.startswith("faulty request: 400")


def keep_lines_without_headers_from_the_workers(served: Served) -> None:
    """A request in pieces delays no other and is answered; one that never arrives is dropped."""
    with ExitStack() as opened:
        lines = [opened.enter_context(connected(served)) for _ in range(60)]
        for line in lines:
            line.sendall(b"GET /?resume=0123456789abcdef HTTP/1.1\r\n")
        *many, last = lines
        newest = many[-MOST_OF_TAB + 1 :]
        assert all(ended(line) for line in many if line not in newest), "the oldest must be closed"
        # The newest continue when the rest arrives.
        last.sendall(b"Host: localhost\r\n\r\n")
        assert last.recv(15) == b"HTTP/1.1 200 OK"
        for line in newest:
            line.setblocking(False)
            with pytest.raises(BlockingIOError):
                line.recv(1)
        assert served.health()["clients"] == 0 and len(served.workers) == 1
    with ExitStack() as opened:
        pieces = opened.enter_context(connected(served))
        pieces.sendall(b"GET /heal")
        assert served.health()["clients"] == 0
        pieces.sendall(b"thz HTTP/1.1\r\nHost: localhost\r\n\r\n")
        assert pieces.recv(15) == b"HTTP/1.1 200 OK"
        silent = [opened.enter_context(connected(served)) for _ in range(MOST_OF_ADDRESS - 2)]
        for _ in range(3):
            opened.enter_context(connected(served))
        assert ended(silent[0]), "the oldest must be closed"


def count_the_tabs_of_both(served: Served, opened: ExitStack, tabs: dict[int, BlockingClient]) -> None:
    """Each process reports the health of all."""
    until(lambda: served.health()["clients"] == len(tabs))
    until(lambda: all(served.health()["sessions"] == len(tabs) for _ in range(3)))
    health = served.health()
    assert 0 < cast(int, health["frames"]) <= 130 and cast(int, health["load"]) > 0
    assert health["store"] == {"lasting": True, "problem": "", "set_aside": ""}

    def metrics() -> bytes:
        with urlopen(f"{served.url}/metrics", timeout=60.0) as answer:
            return answer.read()

    until(lambda: f"\nduet_sessions {len(tabs)}.0\n".encode() in metrics())
    # Every worker knows that all places are taken.
    until(lambda: not served.health()["room"])
    place = worker_of(served, tabs[0])
    tabs[0].close()
    until(lambda: served.health()["room"])
    tabs[0] = opened.enter_context(come(served, 0))
    assert worker_of(served, tabs[0]) == place


@pytest.mark.thorough
def test_tabs_are_distributed_keep_their_worker_and_outlive_it(serve: Serve) -> None:
    served = serve("--workers", "2", "--sessions", "3")
    assert len(served.workers) == 1, "one worker must be enough for the first tab"
    answer_what_is_no_request(served)
    keep_lines_without_headers_from_the_workers(served)
    with ExitStack() as opened:
        tabs = {number: opened.enter_context(come(served, number)) for number in range(2)}
        wait_for_second_worker(served)
        tabs[LATE] = opened.enter_context(come(served, LATE, HOLD))
        places = {number: worker_of(served, visitor) for number, visitor in tabs.items()}
        assert set(places.values()) == set(served.workers), "both must have tabs"
        count_the_tabs_of_both(served, opened, tabs)
        tabs.pop(1).close()
        pause(tabs[LATE])
        assert places[LATE] != places[0]
        tabs[LATE].wait_for(lambda _: kept(served.store, f"{LATE:032d}") is not None)
        # The worker is killed; the other worker's tab is not affected.
        frames = tabs[0].received.frames
        served.replace(places[LATE])
        tabs[LATE] = opened.enter_context(come(served, LATE, HOLD))
        assert worker_of(served, tabs[LATE]) not in places.values()
        tabs[0].wait_for(lambda v: v.received.frames > frames, 60.0)
        assert worker_of(served, tabs[0]) == places[0] and served.said().count("has ended with code") == 1
        assert "takes its place" in served.said()
        # All are replaced, one after another.
        pause(tabs[0])
        before = served.workers
        served.process.send_signal(signal.SIGUSR1)
        for number, visitor in tabs.items():
            visitor.wait_for(lambda v: v.closed is not None, 60.0)
            tabs[number] = opened.enter_context(come(served, number))
        until(lambda: len(served.workers) == 2 and not set(served.workers) & set(before))
        assert {worker_of(served, visitor) for visitor in tabs.values()} == set(served.workers)
    assert served.process.poll() is None and served.said().count("has ended with code") == 1
    processes = [served.process.pid, *served.workers]
    # A test run in the background of a shell passes on that Ctrl+C is ignored.
    assert served.terminate() == ""
    assert all(gone(pid) for pid in processes) and "Traceback" not in served.said()


@pytest.fixture
def real(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """While this is set, real workers are started; otherwise idle ones, in a moment instead of seconds."""
    chosen = threading.Event()
    command = worker_process.subprocess.Popen

    def start(parts: list[str], **options: Any) -> Any:
        descriptors = parts[parts.index("app.features.workers.serve_worker") + 1 :]
        idle = [sys.executable, "-m", "tests.app.features.workers.idle_worker", *descriptors]
        return command(parts if chosen.is_set() else idle, **options)

    monkeypatch.setattr(worker_process, "subprocess", SimpleNamespace(**{**vars(subprocess), "Popen": start}))
    return chosen


class Group:
    """A group of workers without a dispatcher; its messages are received while a test waits."""

    def __init__(self, opened: ExitStack, most: int = 1) -> None:
        listener = opened.enter_context(socket.create_server(("127.0.0.1", 0)))
        # With a browser, this thread already runs an event loop.
        self._thread = opened.enter_context(ThreadPoolExecutor(1))
        self.loop = asyncio.new_event_loop()
        opened.callback(self.loop.close)
        start = WorkerStart(ServeOptions(port=listener.getsockname()[1]), features=FEATURES)
        self.group = WorkerGroup(self.loop, start, most)
        opened.callback(self.group.close)

    def hear_until(self, true: Callable[[], object]) -> None:
        def heard() -> object:
            self._thread.submit(self.loop.run_until_complete, asyncio.sleep(0.0)).result()
            return true()

        until(heard)


@pytest.mark.usefixtures("real")
def test_a_hanging_worker_is_replaced_and_a_working_one_is_not() -> None:
    with ExitStack() as opened:
        dispatcher = Group(opened)
        group, hear_until = dispatcher.group, dispatcher.hear_until
        (worker,) = group.workers
        for _ in range(MOST_SILENT + 1):
            group.look()
        assert not worker.silent, "a starting worker must not count as silent"
        hear_until(lambda: worker.ready)
        for _ in range(MOST_SILENT):
            group.look()
        hear_until(lambda: not worker.silent)
        os.kill(worker.process.pid, signal.SIGSTOP)
        hear_until(lambda: not worker.control.poll())
        for _ in range(MOST_SILENT):
            group.look()
        assert worker.process.poll() is None and group.workers == [worker], "the machine may have been asleep"
        group.look()
        hear_until(lambda: group.workers != [worker])
        assert gone(worker.process.pid)
        hear_until(lambda: group.workers[0].ready)
        # A hanging worker is also renewed, though it has more time to end.
        (old,) = group.workers
        os.kill(old.process.pid, signal.SIGSTOP)
        group.renew()
        hear_until(lambda: not old.ready)
        for _ in range(MOST_STOPPING):
            group.look()
        assert old.process.poll() is None
        group.look()
        hear_until(lambda: group.workers != [old] and group.workers[0].ready)
        assert gone(old.process.pid)
        # A worker that hangs before it is ready is given up.
        (worker,) = group.workers
        group.renew()
        assert group.successor is not None
        new = group.successor[1]
        os.kill(new.process.pid, signal.SIGSTOP)
        for _ in range(MOST_STARTING):
            worker.silent = 0
            group.look()
        assert new.process.poll() is None
        worker.silent = 0
        group.look()
        hear_until(lambda: group.successor is None)
        assert gone(new.process.pid) and group.workers == [worker] and worker.process.poll() is None
        group.renew()
        assert group.successor is not None


@pytest.mark.usefixtures("real")
def test_a_late_look_does_not_count_against_the_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.features.workers.worker_group.LOOK", 0.1)
    monkeypatch.setattr("app.features.workers.worker_group.LATE", 0.5)
    looks: list[float] = []
    with ExitStack() as opened:
        dispatcher = Group(opened)
        monkeypatch.setattr(dispatcher.group, "look", lambda: looks.append(time.monotonic()))
        task = dispatcher.loop.create_task(dispatcher.group.look_after())
        dispatcher.hear_until(lambda: looks)
        # The dispatcher itself gets no processor.
        dispatcher.loop.call_soon(time.sleep, 1.0)
        awake = time.monotonic() + 1.0
        dispatcher.hear_until(lambda: len(looks) > 2)
        assert all(look >= awake + 0.1 for look in looks[1:])
        task.cancel()
        dispatcher.hear_until(task.done)


HANGING = """
import signal, threading
def hang(*_):
    from app.hosting.frame_loop import FrameLoop
    FrameLoop.round = lambda self: threading.Event().wait()
signal.signal(signal.SIGUSR2, hang)
"""


@pytest.mark.thorough
def test_newcomers_go_to_a_ready_worker_and_hanging_frames_are_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, real: threading.Event
) -> None:
    (tmp_path / "sitecustomize.py").write_text(HANGING, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr("app.features.workers.worker_group.LOOK", 1.0)
    with ExitStack() as opened:
        dispatcher = Group(opened, most=2)
        group, hear_until = dispatcher.group, dispatcher.hear_until
        first, *_ = group.workers
        hear_until(lambda: first.ready)
        first.clients = 10 * FEW
        real.set()
        assert [group.worker_of(tab) for tab in ("", "a", "b")] == [first] * 3
        _, second = group.workers
        hear_until(lambda: second.ready)
        assert group.worker_of("") is second and group.worker_of("a") is first
        real.clear()
        second.silent = 1
        hear_until(lambda: not second.silent)
        os.kill(second.process.pid, signal.SIGUSR2)
        looks = dispatcher.loop.create_task(group.look_after())
        hear_until(lambda: group.workers[1] is not second)
        looks.cancel()
        hear_until(looks.done)
        assert gone(second.process.pid) and group.workers[0] is first


def test_a_server_that_cannot_start_reports_it_in_one_line(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "app",
        "serve",
        "--no-open",
        "--port",
        "0",
        "--store",
        "memory",
        "--workers",
        "2",
    ]
    ended = subprocess.run(
        [*command, "--law-file", str(tmp_path / "none.py")],
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert ended.returncode == 2 and ended.stdout == ""
    assert ended.stderr.count("\n") == 1 and "there is no such file" in ended.stderr
