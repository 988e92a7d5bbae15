"""Jobs of the tests, in a separate module, so that a worker does not load the tests' imports."""

import os
import signal
import threading
from pathlib import Path

from controllers.errors import BadSetting
from scenes.wanted import check_wanted


def double(number: float) -> float:
    return 2.0 * number


def wait_for(path: Path) -> str:
    """Content of a file, after waiting for it while the job is wanted; notes its beginning in `begun`."""
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
    """Process id, niceness, whether SIGINT is ignored, and number of threads for linear algebra."""
    ignores = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    return os.getpid(), os.nice(0), ignores, os.environ.get("OPENBLAS_NUM_THREADS", "")
