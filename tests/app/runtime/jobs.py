"""What the tests of the background have computed: in a module of its own, so that a worker need not load what tests need."""

import os
import signal
import threading
from pathlib import Path

from controllers.errors import BadSetting
from scenes.wanted import check_wanted


def double(number: float) -> float:
    return 2.0 * number


def wait_for(path: Path) -> str:
    """Leave a mark, wait for a file unless it is not wanted any more, and return its content."""
    with (path.parent / "begun").open("a") as out:
        out.write(f"{path.name}\n")
    pause = threading.Event()
    while not path.exists():
        check_wanted()
        pause.wait(0.002)
    return path.read_text(encoding="utf-8")


def note(path: Path, word: str) -> None:
    with path.open("a", encoding="utf-8") as out:
        out.write(f"{word}\n")


def refuse() -> None:
    raise BadSetting("dm = 9 is out of range; give less.")


def stumble() -> None:
    raise ZeroDivisionError("somewhere inside")


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def who() -> tuple[int, int, bool, str]:
    """Which process this is, how it lets others go first, whether it minds Ctrl+C, and its threads for linear algebra."""
    ignores = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    return os.getpid(), os.nice(0), ignores, os.environ.get("OPENBLAS_NUM_THREADS", "")
