"""How the processes of a lecture speak to each other: the stage's and those with breakout sessions, through the door."""

import pickle
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any

from app.hosting.worker_process import ForAll, ForgetTabs, ForTab, ToStage


class WorkerLink:
    """One process's end. All methods may be called from any thread.

    Args:
        index: of the process; 0 has the stage.
        send: sends a message to the door.

    Attributes:
        wake: called when something has arrived.
    """

    def __init__(self, index: int, send: Callable[[object], None]) -> None:
        self.index, self._send = index, send
        self.wake: Callable[[], None] = lambda: None
        self._arrived: SimpleQueue[Any] = SimpleQueue()

    def to_stage(self, message: object) -> None:
        self._send(ToStage(pickle.dumps(message)))

    def to_tab(self, tab: str, message: object) -> None:
        """Send a message to the process that gets a tab from now on."""
        self._send(ForTab(tab, pickle.dumps(message)))

    def to_all(self, message: object) -> None:
        """Send a message to all processes with breakout sessions, also to those that start later."""
        self._send(ForAll(pickle.dumps(message)))

    def forget_tabs(self) -> None:
        """Send all tabs to the stage again when they connect."""
        self._send(ForgetTabs())

    def put(self, message: object) -> None:
        """Take a message for this process; content that another process has packed is unpacked."""
        self._arrived.put(pickle.loads(message) if isinstance(message, bytes) else message)
        self.wake()

    def received(self) -> list[Any]:
        """Return what has arrived since the last call."""
        messages: list[Any] = []
        while True:
            try:
                messages.append(self._arrived.get_nowait())
            except Empty:
                return messages
