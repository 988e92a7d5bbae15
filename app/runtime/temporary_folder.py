"""Temporary folders, removed with their process or, if it was killed, at the next start."""

import fcntl
import os
import shutil
import tempfile
import weakref
from pathlib import Path
from types import TracebackType
from typing import Final, Self

PREFIX: Final = "duet-"

LOCK: Final = "owner.lock"
"""Locked (flock) by the owner's living process: a free lock means no owner."""


class TemporaryFolder:
    """A folder for this user only, removed also by `remove` or at the end of a `with`. Its lock is outside of
    `path`.
    """

    def __init__(self, purpose: str) -> None:
        whole = Path(tempfile.mkdtemp(prefix=f"{PREFIX}{purpose}-"))
        draft = whole / "new"
        lock = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        fcntl.flock(lock, fcntl.LOCK_EX)
        # It has its name only once it is locked, so that no other process finds it free.
        draft.rename(whole / LOCK)
        self.path = whole / "in"
        self.path.mkdir(0o700)
        self.remove = weakref.finalize(self, _remove, whole, lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.remove()


def _remove(folder: Path, lock: int) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    os.close(lock)


def remove_abandoned() -> None:
    for lock in Path(tempfile.gettempdir()).glob(f"{PREFIX}*/{LOCK}"):
        try:
            if lock.parent.is_symlink() or lock.parent.stat().st_uid != os.geteuid():
                continue
            number = os.open(lock, os.O_RDWR | os.O_NOFOLLOW)
        except OSError:
            # Another process removes it now.
            continue
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(lock.parent, ignore_errors=True)
        except OSError:
            # Its process lives.
            continue
        finally:
            os.close(number)
