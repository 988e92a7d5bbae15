"""What a command that computes shows on a terminal, and how many processes it may start."""

import os
from typing import Any

from tqdm import tqdm


def progress(total: int | None, unit: str, **more: Any) -> "tqdm[Any]":
    """Return a bar that is drawn on a terminal only, and gone at the end. `more`: for tqdm."""
    return tqdm(total=total, unit=unit, disable=None, leave=False, **more)


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
