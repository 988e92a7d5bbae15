"""Several servers on one computer have separate ports and files; a killed server's files are removed."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

from app.cli import serve
from app.features.store.store_file import StoreLock, StoreTaken
from app.runtime.temporary_folder import LOCK
from tests.app.runtime.processes import gone, until
from tests.approved import Approve

pytestmark = pytest.mark.slow


class Started:
    """`lwr-duet` as a lecturer starts it, with its own home and tmp folders. `options`: of the command."""

    def __init__(self, home: Path, *options: str) -> None:
        (home / "tmp").mkdir(exist_ok=True)
        environment = os.environ | {
            "HOME": str(home),
            "XDG_STATE_HOME": str(home / "state"),
            "TMPDIR": str(home / "tmp"),
        }
        self.process = subprocess.Popen(
            [sys.executable, "-m", "app", "--no-open", *options],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self.said: list[str] = []
        assert self.process.stdout is not None
        # The last line tells how to end it.
        while (line := self.process.stdout.readline()) and not line.startswith("Ctrl+C"):
            self.said.append(line)

    @property
    def port(self) -> int:
        return int(re.findall(r"^Duet is at http://127\.0\.0\.1:(\d+)", self.said[0])[0])

    @property
    def errors(self) -> str:
        assert self.process.stderr is not None
        return self.process.stderr.read()

    def kill(self) -> None:
        children = self.children()
        self.process.kill()
        for child in children:
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
        self.process.wait()
        until(lambda: all(map(gone, children)))

    def children(self) -> list[int]:
        with suppress(OSError):
            listed = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text(
                encoding="ascii"
            )
            return list(map(int, listed.split()))
        return []

    def end(self) -> None:
        self.process.terminate()
        self.process.wait(60.0)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Started]]:
    with ExitStack() as opened:

        def make(*options: str) -> Started:
            started = Started(tmp_path, *options)
            opened.callback(started.kill)
            return started

        yield make


@pytest.mark.thorough
@pytest.mark.parametrize("workers", ["1", "2"])
def test_two_servers_have_their_own_ports_and_files(
    start: Callable[..., Started], tmp_path: Path, workers: str, approve: Approve
) -> None:
    folder = tmp_path / "state" / "lwr-duet"
    first, second = (start("--workers", workers) for _ in range(2))
    assert first.port >= serve.USUAL_PORT and second.port > first.port
    assert [line for line in first.said if "visitors" in line] == []
    said = "".join(line for line in second.said if "Port" in line or "visitors" in line)
    for shown, name in ((serve.USUAL_PORT, "USUAL"), (second.port, "PORT"), (folder, "FOLDER")):
        said = said.replace(str(shown), name)
    approve("second server.txt", said)
    for path, server in ((folder / "visitors.sqlite", first), (folder / "visitors-2.sqlite", second)):
        assert path.is_file() and StoreLock.last_port(path) == server.port
        with pytest.raises(StoreTaken):
            StoreLock(path)
    ports = first.port, second.port
    # The first is killed, the second ended; the second restarts first.
    first.kill()
    second.end()
    again = start("--workers", workers, "--port", str(ports[1]))
    assert any("visitors-2.sqlite" in line for line in again.said) and again.port == ports[1]
    # This start removed the killed server's files in the temporary folder.
    assert len(list((tmp_path / "tmp").glob(f"duet-*/{LOCK}"))) == (0 if workers == "1" else 1)


@pytest.mark.thorough
def test_a_named_port_or_file_that_is_in_use_is_refused(
    start: Callable[..., Started], tmp_path: Path
) -> None:
    store = str(tmp_path / "class.sqlite")
    first = start("--workers", "1", "--store", store)
    taken = start("--workers", "1", "--port", str(first.port))
    assert taken.process.wait(60.0) == 2 and taken.said == []
    assert f"port {first.port} on" in taken.errors
    taken = start("--workers", "1", "--store", store)
    assert taken.process.wait(60.0) == 2 and "Another server" in taken.errors
