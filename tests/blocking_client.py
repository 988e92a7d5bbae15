"""The headless client for synchronous code."""

from __future__ import annotations

import asyncio
import inspect
import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from app.web.headless_client import HeadlessClient


class OperatingClient(HeadlessClient):
    """A `HeadlessClient` that operates the page like a visitor, and can lose its connection."""

    @property
    def local_port(self) -> int:
        """Port of this end of the connection."""
        assert self._socket is not None
        return self._socket.local_address[1]

    async def set_value(self, label: str, value: object) -> None:
        """Operate the GUI element with this label."""
        await self.send(
            {
                "type": "GuiUpdateMessage",
                "uuid": self.mirror.labelled(label)["uuid"],
                "updates": {"value": value},
            }
        )

    async def click(self, label: str) -> None:
        """Press the button with this label."""
        uuid = self.mirror.labelled(label, "GuiButtonMessage")["uuid"]
        await self.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})

    async def move_gizmo(
        self,
        name: str,
        position: object = (0.0, 0.0, 0.0),
        wxyz: object = (1.0, 0.0, 0.0, 0.0),
        *,
        phase: str = "update",
    ) -> None:
        """One step of dragging a gizmo; `phase` is "start", "update" or "end"."""
        message: dict[str, Any] = {"name": name, "owner": self.mirror.nodes[name].get("owner", "")}
        if phase == "update":
            message |= {"type": "TransformControlsUpdateMessage", "position": position, "wxyz": wxyz}
        else:
            message |= {"type": f"TransformControlsDrag{phase.capitalize()}Message"}
        await self.send(message)

    async def fall_asleep(self) -> None:
        """Stop reading, like a page on a sleeping computer."""
        assert self._reader is not None
        self._reader.cancel()

    async def break_off(self, unfinished: bytes = b"") -> None:
        """End the connection without a closing handshake. `unfinished`: message that is sent only in part."""
        assert self._socket is not None
        if unfinished:
            # A masked binary frame (RFC 6455, section 5.2): the message's length, and half of its content.
            head = b"\x82\xfe" + len(unfinished).to_bytes(2, "big") + b"\0\0\0\0"
            self._socket.transport.write(head + unfinished[: len(unfinished) // 2])
            await asyncio.sleep(0)
        self._socket.transport.abort()


class BlockingClient:
    """An `OperatingClient` with its event loop in its own thread, for threads with a running loop
    (Playwright).

    Args:
        origin: Origin header; None: no header, like a program.

    Raises, when made:
        websockets.InvalidStatus: the server refuses the connection.
    """

    def __init__(
        self, url: str, origin: str | None = None, query: str = "", *, camera: bool = True, **options: Any
    ) -> None:
        if origin is not None:
            options["headers"] = {"Origin": origin, **options.get("headers", {})}
        self.loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self.loop.run_forever, daemon=True, name="visitor")
        self._thread.start()
        try:
            self.visitor = OperatingClient(url, query, **options)
            # A new worker process may start to serve late on a busy machine.
            self.run(self.visitor.connect(60.0, camera=camera), 65.0)
        except BaseException:
            self._end()
            raise

    def run(self, work: Coroutine[Any, Any, Any], timeout: float = 30.0) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(timeout)

    def _end(self) -> None:
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join(60.0)
        self.loop.close()

    def __getattr__(self, name: str) -> Any:
        """Attribute of the client; a coroutine function becomes a blocking one."""
        found = getattr(self.visitor, name)
        return (
            (lambda *args, **kwargs: self.run(found(*args, **kwargs)))
            if inspect.iscoroutinefunction(found)
            else found
        )

    def wait_for(self, predicate: Callable[[HeadlessClient], object], timeout: float = 60.0) -> None:
        """See `HeadlessClient.wait_for`; the predicate runs in the visitor's thread.

        A `LookupError` counts as False, as elements may be missing or rebuilt at the moment; after the
        timeout it is raised.
        """

        def met(visitor: HeadlessClient) -> object:
            with suppress(LookupError):
                return predicate(visitor)
            return False

        try:
            self.run(self.visitor.wait_for(met, timeout), timeout + 5.0)
        except TimeoutError:
            predicate(self.visitor)
            raise

    def close(self) -> None:
        """Leave and end the thread. May be called twice."""
        if self.loop.is_closed():
            return
        try:
            self.run(self.visitor.close())
        finally:
            self._end()

    def __enter__(self) -> BlockingClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
