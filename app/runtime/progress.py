"""Progress bar, and number of processes."""

import os
from typing import Any

from tqdm import tqdm


def progress(total: int | None, unit: str, **more: Any) -> "tqdm[Any]":
    """A bar only on a terminal, removed at the end. `more`: for tqdm."""
    return tqdm(total=total, unit=unit, disable=None, leave=False, **more)


def cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
