"""Misbehaving untrusted laws, and a check for processes that they leave."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from app.features.custom_law.law_limits import LawLimits
from app.features.marks.fence import FenceLimits
from app.features.marks.marked import LawMarks, marked
from tests.app.runtime.processes import until

posix = pytest.mark.skipif(os.name != "posix", reason="the files fork and send signals")

LAW = "def law(situation):\n    return situation.nominal\n"
FORKS = "import os, time\nfor _ in range(9):\n    os.fork()\ntime.sleep(60)\n"

TOO_MANY = "more than 48 processes|BlockingIOError"
"""Message seen from outside, or by the file itself."""


@contextmanager
def nothing_left() -> Iterator[None]:
    """Checks that all processes started in a fence meanwhile have ended."""
    # Tests of other files start fences at the same time.
    mine, made = secrets.token_hex(8), secrets.token_hex
    names = SimpleNamespace(token_hex=lambda count: mine + made(count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.features.marks.fence.secrets", names)
        yield
    # On a busy machine a killed process takes a moment to end.
    token = f"DUET_FENCE={mine}".encode()
    until(lambda: not any(name.isdecimal() and token in _environment(name) for name in os.listdir("/proc")))


def _environment(process: str) -> bytes:
    try:
        return Path("/proc", process, "environ").read_bytes()
    except OSError:
        return b""


def quick(text: str, **limits: object) -> LawMarks:
    return marked("law.py", text.encode(), FenceLimits(**({"law": LawLimits(load=0.5)} | limits)))  # pyright: ignore[reportArgumentType]
