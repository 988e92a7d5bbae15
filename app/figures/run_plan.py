"""How much is to be computed, and the runs that several figures share."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

from scenes.headless import Run, TargetSource, run
from scenes.settings import LawSettings, RunSettings

T = TypeVar("T")


class Plan:
    """What all figures of one call have in common.

    Args:
        seed: of every person who plays a part.
        quick: shorter runs and fewer points, for a first look and for tests.
        on_progress: called with the number of steps made since the last call.
    """

    def __init__(self, seed: int = 1, quick: bool = False, on_progress: Callable[[int], object] | None = None) -> None:
        self.seed, self.quick = seed, quick
        self._on_progress = on_progress
        self._kept: dict[tuple[RunSettings, float], Run] = {}

    def either(self, full: T, quick: T) -> T:
        """Return the first, or the second of a quick plan."""
        return quick if self.quick else full

    def settings(self, law: dict[str, Any] | None = None, **changes: Any) -> RunSettings:
        """Return the defaults with the plan's seed, and with changes to fields of the law and of the rest."""
        return RunSettings(seed=self.seed, law=LawSettings(**(law or {})), **changes)

    def run(self, settings: RunSettings, seconds: float, person: TargetSource | None = None) -> Run:
        """Simulate, and let go of it afterwards."""
        return run(settings, seconds, person, on_progress=self._on_progress)

    def shared(self, settings: RunSettings, seconds: float) -> Run:
        """Simulate with the settings' own person, or return the run of an earlier figure; only to be read."""
        key = replace(settings), seconds
        if key not in self._kept:
            self._kept[key] = self.run(settings, seconds)
        return self._kept[key]
