"""Runs here or on a cluster."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any

from app.runtime.progress import cores
from controllers.errors import BadSetting

if TYPE_CHECKING:
    from scenes.children import ComputeMany


def computing(workers: int, scheduler: str | None) -> AbstractContextManager[ComputeMany[Any]]:
    """Processes of this computer (0: one per core), or a Dask scheduler's workers.

    Raises:
        BadSetting: both, or a negative number; later as `on_dask`.
    """
    from app.features.sweep.dask_cluster import on_dask
    from scenes.children import computed

    if workers < 0:
        raise BadSetting(f"workers = {workers} cannot be; give a number from 1, or 0 for one a core.")
    if workers and scheduler is not None:
        raise BadSetting(
            "--workers is for this computer, and a cluster has workers of its own; leave out --workers or --scheduler."
        )
    return (
        nullcontext(partial(computed, workers=workers or cores()))
        if scheduler is None
        else on_dask(scheduler)
    )
