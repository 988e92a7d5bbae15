"""Waiting for processes, and checks whether they are alive."""

import os
import select
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

PATIENCE = 120.0
"""Longest wait [s]; a process starts slowly on a busy machine."""


def until(
    true: Callable[[], object], process: subprocess.Popen[bytes] | None = None, patience: float = PATIENCE
) -> None:
    deadline = time.monotonic() + patience
    while not true():
        assert time.monotonic() < deadline and (process is None or process.poll() is None), "not in time"
        select.select([], [], [], 0.004)


def gone(pid: int) -> bool:
    """True if a process has ended; a child of this process must also have been waited for."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    try:
        state, parent = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[:2]
    except OSError:
        return False
    return state == "Z" and int(parent) != os.getpid()
