"""The headless client for synchronous code."""

from __future__ import annotations

import asyncio
import inspect
import threading
from collections.abc import Callable, Coroutine
from typing import Any

from app.bench.headless_client import HeadlessClient


class BlockingClient:
    """A `HeadlessClient` with its event loop in a thread of its own, for code in a thread that already has a running loop (Playwright).

    Raises, when made:
        websockets.InvalidStatus: the server refuses the connection.
    """

    def __init__(self, url: str, origin: str | None = None, query: str = "", *, camera: bool = True, **options: Any) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True, name="visitor")
        self._thread.start()
        try:
            self.visitor = HeadlessClient(url, origin, query, **options)
            self._run(self.visitor.connect(camera=camera))
        except BaseException:
            self._end()
            raise

    def _run(self, work: Coroutine[Any, Any, Any], timeout: float = 30.0) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(timeout)

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5.0)
        self._loop.close()

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the client; a coroutine function as one that waits for its end."""
        found = getattr(self.visitor, name)
        return (lambda *args, **kwargs: self._run(found(*args, **kwargs))) if inspect.iscoroutinefunction(found) else found

    def wait_for(self, predicate: Callable[[HeadlessClient], object], timeout: float = 60.0) -> None:
        """See `HeadlessClient.wait_for`; the predicate runs in the visitor's thread."""
        self._run(self.visitor.wait_for(predicate, timeout), timeout + 5.0)

    def close(self) -> None:
        """Leave and end the thread. May be called twice."""
        if self._loop.is_closed():
            return
        try:
            self._run(self.visitor.close())
        finally:
            self._end()

    def __enter__(self) -> BlockingClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
