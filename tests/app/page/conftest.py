"""A foreign page that has one of ours in a frame."""

import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

AROUND = """<!doctype html><title>A course</title><link rel="icon" href="data:,"><body>
<p>The slide before, and the one after.</p>
<script>heard = []; addEventListener("message", ({data}) => { if (typeof data === "string") heard.push(data); });</script>
<iframe src="FRAME" width="900" height="560"></iframe>"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


Around = Callable[[str], str]


@pytest.fixture
def around(tmp_path: Path) -> Iterator[tuple[str, Around]]:
    """The origin of a foreign page, and what writes it with an address in its frame and returns its own."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path))) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        origin = f"http://localhost:{server.server_address[1]}"

        def write(frame: str) -> str:
            (tmp_path / "course.html").write_text(AROUND.replace("FRAME", frame.replace("&", "&amp;")), encoding="utf-8")
            return f"{origin}/course.html"

        yield origin, write
        server.shutdown()
