"""A real Jupyter server in a folder as a hub would use it."""

import json
import os
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.browser import free_port

TOKEN = "open-sesame-to-the-tests"


@dataclass(frozen=True)
class JupyterServer:
    """`name`: host name of its address, below `localhost`: this computer, but a name unknown to Duet."""

    port: int
    log: Path
    folder: str = "/user/ann/"
    name: str = "hub.localhost"

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}{self.folder}"

    @property
    def origin(self) -> str:
        return f"http://{self.name}:{self.port}"

    def get(self, path: str, token: str = TOKEN) -> tuple[int, str, bytes]:
        """Status, final address and content of an answer."""
        request = urllib.request.Request(
            self.url + path, headers={"Authorization": f"token {token}"} if token else {}
        )
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return answer.status, answer.url, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.url or "", error.read()


@pytest.fixture(scope="package")
def jupyter(tmp_path_factory: pytest.TempPathFactory) -> Iterator[JupyterServer]:
    home = tmp_path_factory.mktemp("home")
    output = home / "log"
    options = {
        "ServerApp.ip": "127.0.0.1",
        # The next free port if another program takes this one meanwhile.
        "ServerApp.port": free_port(),
        "ServerApp.base_url": JupyterServer.folder,
        "ServerApp.allow_remote_access": True,
        "ServerApp.open_browser": False,
        "IdentityProvider.token": TOKEN,
    }
    command = [
        sys.executable,
        "-m",
        "jupyter_server",
        "--allow-root",
        *(f"--{key}={value}" for key, value in options.items()),
    ]
    with (
        output.open("wb") as log,
        subprocess.Popen(command, cwd=home, env=environment(home), stdout=log, stderr=log) as process,
    ):
        try:
            deadline = time.monotonic() + 120.0
            about = home / "runtime" / f"jpserver-{process.pid}.json"
            while not ((port := _port_in(about)) and _answers(JupyterServer(port, output))):
                assert goes_on(process) and time.monotonic() < deadline, output.read_text(encoding="utf-8")
            yield JupyterServer(port, output)
        finally:
            process.terminate()


def environment(home: Path) -> dict[str, str]:
    """Environment for a Jupyter that writes only into `home`."""
    folders = {f"JUPYTER_{kind}_DIR": str(home / kind.lower()) for kind in ("CONFIG", "DATA", "RUNTIME")}
    return {**os.environ, **folders, "HOME": str(home), "IPYTHONDIR": str(home / "ipython")}


def goes_on(process: subprocess.Popen[bytes]) -> bool:
    """True if the process still runs after 0.1 s."""
    with suppress(subprocess.TimeoutExpired):
        process.wait(0.1)
    return process.returncode is None


def _port_in(about: Path) -> int:
    """Port in the server's status file; 0 while the file lacks it."""
    try:
        return json.loads(about.read_text(encoding="utf-8"))["port"]
    except (OSError, ValueError):
        return 0


def _answers(server: JupyterServer) -> bool:
    try:
        return server.get("api/status")[0] == 200
    except OSError:
        return False
