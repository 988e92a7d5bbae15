"""Options of `lwr-duet serve` for the visitors' store. Imports nothing slow."""

from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Self

import tyro

from app.hosting.serve_options import FeatureOptions
from controllers.errors import BadSetting

MEMORY: Final = "memory"

LONGEST_KEEP: Final = 24.0 * 366.0
"""Largest value of `--keep` [hours]."""

SMALLEST_STORE: Final = 1.0
"""Smallest value of `--store-size` [MB]."""


@dataclass(frozen=True)
class StoreOptions(FeatureOptions):
    """What is kept of visitors who have gone.

    Attributes:
        file: where records outlive the server, chosen when it starts; None for memory alone.
        locked: whether the server that listens holds the lock of the file, so that its processes open it without.
    """

    store: str | None = None
    """File that keeps what visitors do when the server ends, or `memory` to keep it no longer than the server runs; without this
    option a file in your home folder, or one beside it while another server has that."""
    keep: float = 24.0
    """How long a visitor's work is kept after the last visit [hours]."""
    store_size: float = 500.0
    """Largest size of that file [MB]; beyond it the work of those who left first is deleted."""
    file: tyro.conf.Suppress[Path | None] = None
    locked: tyro.conf.Suppress[bool] = False

    @property
    def seconds(self) -> float:
        """`keep` [s]."""
        return 3600.0 * self.keep

    @property
    def most_bytes(self) -> int:
        """`store_size` [bytes]."""
        return round(1e6 * self.store_size)

    def check(self) -> None:
        if not 0.0 < self.keep <= LONGEST_KEEP:
            raise BadSetting(
                f"--keep = {self.keep:g} h is not possible; give hours up to {LONGEST_KEEP:g}, or --store memory."
            )
        if not self.store_size >= SMALLEST_STORE:
            raise BadSetting(f"--store-size must be at least {SMALLEST_STORE:g} MB.")

    def held(self, port: int, until: ExitStack) -> Self:
        """Choose the file, and lock it.

        Raises:
            StoreRefused: another server has the named file, or it is not a store.
        """
        if self.store == MEMORY:
            return self
        from app.features.store.store_choice import chosen_store
        from app.features.store.store_file import StoreLock, usual_path

        file = usual_path() if self.store is None else Path(self.store)
        # Without a lock there is no file, which the processes report.
        with suppress(OSError):
            if self.store is None:
                file, lock = chosen_store(file, port)
            else:
                lock = StoreLock(file)
            until.callback(lock.release)
        return replace(self, file=file, locked=True)

    def said_at_start(self, host: str, port: int, places: int) -> tuple[str, ...]:
        from app.features.store.store_file import usual_path

        if self.store is not None or self.file in (None, usual_path()):
            return ()
        return (f"This Duet keeps its visitors in {self.file}: others have their own files there.",)
