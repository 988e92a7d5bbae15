"""What is kept of a student's way through the lessons."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from app.settings import Settings
from scenes.inputs import Recorded
from scenes.roles import TargetSource


@dataclass(frozen=True)
class SavedLesson:
    """What outlives a connection.

    Attributes:
        progress: the walkthrough's JSON.
        own: the visitor's settings outside the lessons.
        open: whether a lesson was open.
        seen: (lesson, step) → the run in which the visitor saw what came of it.
        now: the settings of the open step's run, which the visitor may have changed; None while no lesson is open.
        kept: what the visitor did in runs that a later step takes up, by name.
        said: (lesson, step) → the forecasts that were typed there.
        measured: whether the present run was measured already.
    """

    progress: str
    own: Settings
    open: bool
    seen: Mapping[tuple[str, str], Recorded] = field(default_factory=dict)
    now: Settings | None = None
    kept: Mapping[str, TargetSource] = field(default_factory=dict)
    said: Mapping[tuple[str, str], tuple[float | None, ...]] = field(default_factory=dict)
    measured: bool = False
