"""The system's Firefox, driven by its own WebDriver BiDi: no driver and no browser is downloaded."""

import base64
import itertools
import json
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from websockets.sync.client import connect
from websockets.sync.connection import Connection

from tests.browser import free_port
from tests.fonts import font_environment
from tests.system_packages import install_package

TIMEOUT: Final = 180.0
"""Time limit of every wait [s]."""

# Firefox's messages about a missing graphics card, and one of viser's build.
HARMLESS: Final = (
    "WebGL warning",
    "WEBGL_debug_renderer_info",
    "WebGL context was lost",
    "downloadable font",
)


NO_PREFERENCES: Final[Mapping[str, int]] = {}


def installed(name: str, *names: str) -> str:
    """Path of the first installed program; as root on Debian, `name`'s package is installed if necessary.

    Raises:
        FileNotFoundError: no program is available.
    """
    for attempt in (False, True):
        if attempt:
            install_package(name.lower())
        found = next((path for path in map(shutil.which, (*names, name)) if path), None)
        if found is not None:
            return found
    raise FileNotFoundError(f"{name} is not installed")


class Firefox:
    """One tab.

    Attributes:
        complaints: console errors and uncaught exceptions so far.
    """

    def __init__(self, socket: Connection) -> None:
        self._socket, self._numbers = socket, itertools.count(1)
        self.complaints: list[str] = []
        self._send("session.new", capabilities={})
        self._send("session.subscribe", events=["log.entryAdded"])
        self._tab = self._send("browsingContext.getTree")["contexts"][0]["context"]

    def _send(self, method: str, **params: Any) -> dict[str, Any]:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        end = time.monotonic() + TIMEOUT
        while True:
            message = self._next(max(end - time.monotonic(), 0.0))
            if message.get("id") == number:
                if message["type"] == "error":
                    raise RuntimeError(f"{method}: {message['error']}: {message['message']}")
                return message["result"]

    def _next(self, timeout: float) -> dict[str, Any]:
        """Next message; a complaint is recorded."""
        message = json.loads(self._socket.recv(timeout=timeout))
        if message.get("method") == "log.entryAdded":
            entry = message["params"]
            if entry["level"] == "error" and not any(text in (entry["text"] or "") for text in HARMLESS):
                self.complaints.append(f"{entry['type']}: {entry['text']}")
        return message

    def open(self, url: str, width: int, height: int) -> None:
        self._send(
            "browsingContext.setViewport", context=self._tab, viewport={"width": width, "height": height}
        )
        self._send("browsingContext.navigate", context=self._tab, url=url, wait="complete")

    def enter_frame(self) -> None:
        """Use the first frame of the page from now on."""
        self._tab = self._send("browsingContext.getTree", root=self._tab)["contexts"][0]["children"][0][
            "context"
        ]

    def value(self, script: str) -> Any:
        """Value of an expression: a number, a text or a boolean."""
        answer = self._send(
            "script.evaluate", expression=script, target={"context": self._tab}, awaitPromise=True
        )
        if answer["type"] == "exception":
            raise RuntimeError(answer["exceptionDetails"]["text"])
        return answer["result"].get("value")

    def until(self, script: str, what: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + TIMEOUT
        while not self.value(f"Boolean({script})"):
            assert time.monotonic() < end, f"{what} did not happen"
            with suppress(TimeoutError):
                self._next(0.1)

    def drag(
        self, start: tuple[float, float], by: tuple[float, float], held: Callable[[], None] = lambda: None
    ) -> None:
        """Press at a point of the window, move in steps, release. `held`: called before the release."""
        steps = [
            {
                "type": "pointerMove",
                "x": round(start[0] + by[0] * k / 8),
                "y": round(start[1] + by[1] * k / 8),
                "duration": 60,
            }
            for k in range(9)
        ]
        self._point(
            [*steps[:1], {"type": "pause", "duration": 100}, {"type": "pointerDown", "button": 0}, *steps[1:]]
        )
        held()
        self._point([{"type": "pointerUp", "button": 0}])

    def _point(self, actions: list[dict[str, Any]]) -> None:
        mouse = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}
        self._send("input.performActions", context=self._tab, actions=[mouse])

    def picture(self, path: Path) -> None:
        path.write_bytes(
            base64.b64decode(self._send("browsingContext.captureScreenshot", context=self._tab)["data"])
        )


@contextmanager
def screen() -> Iterator[str]:
    """Virtual screen while open, as Firefox has no WebGL without one. Gives its name."""
    command = [installed("Xvfb"), "-displayfd", "1", "-screen", "0", "1600x1200x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            assert server.stdout is not None
            yield f":{server.stdout.readline().strip()}"
        finally:
            server.terminate()


@contextmanager
def firefox(profile: Path, prefers: Mapping[str, int] = NO_PREFERENCES) -> Iterator[Firefox]:
    """A Firefox with its own profile, an empty folder, while open. `prefers`: settings of `about:config`.

    Raises:
        FileNotFoundError: Firefox or Xvfb is not installed; `DUET_FIREFOX` may name another program.
    """
    path = installed("firefox-esr", os.environ.get("DUET_FIREFOX", "firefox"))
    port = free_port()
    # Without a graphics card Firefox does not choose software rendering by itself.
    preferences = {"webgl.force-enabled": True, **prefers}
    lines = (f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in preferences.items())
    (profile / "user.js").write_text("".join(lines), encoding="utf-8")
    command = [
        path,
        "--no-remote",
        "--profile",
        str(profile),
        "--remote-debugging-port",
        str(port),
        "about:blank",
    ]
    said = profile / "said.txt"
    # An unread pipe would stop Firefox, which prints much about software rendering.
    with screen() as display, said.open("w") as out:
        environment = font_environment("wide") | {"DISPLAY": display}
        with subprocess.Popen(command, stdout=out, stderr=out, env=environment) as process:
            try:
                end = time.monotonic() + TIMEOUT
                while "WebDriver BiDi listening" not in said.read_text(encoding="utf-8", errors="replace"):
                    assert process.poll() is None and time.monotonic() < end, "Firefox does not listen"
                    with suppress(subprocess.TimeoutExpired):
                        process.wait(0.1)
                with connect(
                    f"ws://127.0.0.1:{port}/session", max_size=None, open_timeout=TIMEOUT, ping_interval=None
                ) as socket:
                    yield Firefox(socket)
            finally:
                process.terminate()
