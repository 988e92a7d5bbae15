"""The page in worker processes: tabs are spread over them, stay at theirs, and outlive it."""

import os
import selectors
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from time import monotonic

import pytest

from app.hosting.door import MOST_UNREAD, tab_of
from app.hosting.worker_group import LOOK, MOST_SILENT, WorkerGroup
from app.hosting.worker_process import WorkerStart
from app.runtime.terminal import TERMINATED
from app.settings import Settings
from tests.app.runtime.processes import gone, until
from tests.app.served import Serve, Served
from tests.blocking_client import BlockingClient


def come(served: Served, number: int, query: str = "autopilot=0") -> BlockingClient:
    """A tab whose page is whole."""
    visitor = BlockingClient(served.url, query=f"{query}&resume={number:032d}")
    visitor.wait_for(lambda v: len(v.mirror.commands) >= 14 and any(n.endswith("/j7") for n in list(v.mirror.nodes)), 60.0)
    return visitor


def peers_of(pid: int, visitor: BlockingClient) -> bool:
    """Whether a process holds the other end of a visitor's connection."""
    port = visitor.local_port
    inodes = {os.readlink(link) for link in Path(f"/proc/{pid}/fd").iterdir() if link.is_symlink() and link.exists()}
    rows = [row.split() for row in Path("/proc/net/tcp").read_text(encoding="utf-8").splitlines()[1:]]
    return any(row[2].endswith(f":{port:04X}") and f"socket:[{row[9]}]" in inodes for row in rows)


def worker_of(served: Served, visitor: BlockingClient) -> int:
    found = [pid for pid in served.workers if peers_of(pid, visitor)]
    assert len(found) == 1
    return found[0]


@pytest.mark.parametrize(
    ("line", "tab"),
    [
        (b"GET /?resume=0123456789abcdef HTTP/1.1\r", "0123456789abcdef"),
        (b"GET /?scene=ball&resume=0123456789abcdef&window=800x600 HTTP/1.1\r", "0123456789abcdef"),
        (b"GET /?noresume=0123456789abcdef HTTP/1.1\r", ""),
        (b"GET /?resume=short HTTP/1.1\r", ""),
        (b"GET /?resume=0123456789ABCDEF HTTP/1.1\r", ""),
        (b"GET /healthz HTTP/1.1\r", ""),
        (b"\x16\x03\x01 no HTTP at all", ""),
        (b"", ""),
    ],
)
def test_the_tab_is_found_in_the_first_line_of_a_request(line: bytes, tab: str) -> None:
    assert tab_of(line) == tab


def test_tabs_are_spread_over_the_workers_and_stay_at_theirs(serve: Serve) -> None:
    served = serve("--workers", "2", "--sessions", "6")
    assert len(served.workers) == 1, "one worker is enough for the first"
    with ExitStack() as opened:
        visitors = [opened.enter_context(come(served, number)) for number in range(5)]
        until(lambda: len(served.workers) == 2)
        visitors.append(opened.enter_context(come(served, 5)))
        places = [worker_of(served, visitor) for visitor in visitors]
        assert set(places) == set(served.workers), "both have tabs"
        until(lambda: served.health()["clients"] == 6)
        # A request that arrives in pieces delays no other, and is answered; one that never arrives makes room.
        host, port = served.url.removeprefix("http://").split(":")
        with ExitStack() as slow:
            pieces, *silent = [slow.enter_context(socket.create_connection((host, int(port)))) for _ in range(MOST_UNREAD - 1)]
            pieces.sendall(b"GET /heal")
            assert served.health()["clients"] == 6
            pieces.sendall(b"thz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            assert pieces.recv(15) == b"HTTP/1.1 200 OK"
            for _ in range(3):
                slow.enter_context(socket.create_connection((host, int(port))))
            assert silent[0].recv(1) == b"", "the oldest is closed"
        # Every worker knows that all places are taken, in whichever a request arrives.
        until(lambda: not served.health()["room"])
        visitors[0].close()
        until(lambda: served.health()["room"])
        visitors[0] = opened.enter_context(come(served, 0))
        assert worker_of(served, visitors[0]) == places[0]
    ended = [served.process.pid, *served.workers]
    # A test run in the background of a shell hands on that Ctrl+C is ignored.
    served.process.terminate()
    assert served.process.wait(60.0) == TERMINATED
    assert all(gone(pid) for pid in ended) and "Traceback" not in served.said()


def test_a_worker_that_is_killed_is_replaced_and_its_tabs_go_on(serve: Serve) -> None:
    served = serve("--workers", "2")
    assert served.process.stdout is not None
    assert "carries about" in served.process.stdout.readline(), "the places of both, as a worker has measured them"
    with ExitStack() as opened:
        visitors = [opened.enter_context(come(served, number)) for number in range(4)]
        until(lambda: len(served.workers) == 2)
        visitors.append(opened.enter_context(come(served, 4)))
        first = visitors[0]
        places = [worker_of(served, visitor) for visitor in visitors]
        assert places[0] != places[-1]
        frames = first.received.frames
        os.kill(places[-1], signal.SIGKILL)
        until(lambda: places[-1] not in served.workers and len(served.workers) == 2)
        with come(served, 4) as back:
            assert worker_of(served, back) not in places
        first.wait_for(lambda v: v.received.frames > frames, 60.0)
        assert worker_of(served, first) == places[0] and "another one takes its place" in served.said()


def test_a_worker_that_hangs_is_replaced_and_one_that_works_is_not() -> None:
    none = (None,) * 4
    with socket.create_server(("127.0.0.1", 0)) as listener, selectors.DefaultSelector() as selector:
        start = WorkerStart("127.0.0.1", listener.getsockname()[1], {"settings": Settings()}, none)
        group = WorkerGroup(selector, start, 1)

        def hear_until(true: Callable[[], object]) -> None:
            def heard() -> object:
                for key, _ in selector.select(0.0):
                    key.data()
                return true()

            until(heard)

        try:
            (worker,) = group.workers
            looks = (monotonic() + LOOK * look for look in count(1))
            for _ in range(MOST_SILENT + 1):
                group.look_after(next(looks))
            assert not worker.silent, "it only starts"
            hear_until(lambda: worker.ready)
            for _ in range(MOST_SILENT):
                group.look_after(next(looks))
            hear_until(lambda: not worker.silent)
            os.kill(worker.process.pid, signal.SIGSTOP)
            hear_until(lambda: not selector.select(0.0))
            for _ in range(MOST_SILENT):
                group.look_after(next(looks))
            assert worker.process.poll() is None and group.workers == [worker], "the machine may have been asleep"
            group.look_after(next(looks))
            hear_until(lambda: group.workers != [worker] or group.look_after(monotonic()))
            assert gone(worker.process.pid)
            hear_until(lambda: group.workers[0].ready)
            # One that hangs is also renewed.
            (old,) = group.workers
            os.kill(old.process.pid, signal.SIGSTOP)
            group.renew()
            hear_until(lambda: not old.ready)
            for _ in range(MOST_SILENT + 1):
                group.look_after(next(looks))
            hear_until(lambda: group.workers != [old] and group.workers[0].ready)
            assert gone(old.process.pid)
        finally:
            group.close()


def test_workers_are_renewed_and_their_tabs_go_on(serve: Serve) -> None:
    served = serve("--workers", "2")
    with ExitStack() as opened:
        visitors = [opened.enter_context(come(served, number)) for number in range(5)]
        until(lambda: len(served.workers) == 2)
        visitors.append(opened.enter_context(come(served, 5)))
        before = served.workers
        served.process.send_signal(signal.SIGUSR1)
        for number, visitor in enumerate(visitors):
            visitor.wait_for(lambda v: v.closed is not None, 60.0)
            visitors[number] = opened.enter_context(come(served, number))
        until(lambda: len(served.workers) == 2 and not set(served.workers) & set(before))
        assert {worker_of(served, visitor) for visitor in visitors} == set(served.workers)
    assert served.process.poll() is None and "has ended with code" not in served.said()


def test_a_server_that_cannot_start_says_so_in_one_line(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "app", "serve", "--no-open", "--port", "0", "--store", "memory", "--workers", "2"]
    ended = subprocess.run(
        [*command, "--law-file", str(tmp_path / "none.py")], capture_output=True, text=True, timeout=120.0, check=False
    )
    assert ended.returncode == 2 and ended.stdout == ""
    assert ended.stderr.count("\n") == 1 and "there is no such file" in ended.stderr
