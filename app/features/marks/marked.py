"""The six tests of an untrusted file."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from app.features.custom_law.arena import PIECES, TrialCurve, TrialResult
from app.features.custom_law.examination import examine
from app.features.custom_law.trials import TRIALS
from app.features.marks.fence import FenceLimits, fenced, fenced_input, say
from app.i18n.speaking import set_language, tr
from app.settings import Language


@dataclass
class LawMarks:
    """Result for one file, written by the file's own process.

    Attributes:
        ended: why not all tests were made, or "".
        isolation: "full", "network" or "none"; "" if nothing was run.
    """

    verdicts: dict[str, TrialResult] = field(default_factory=dict)
    ended: str = ""
    isolation: str = ""

    @property
    def as_template(self) -> bool:
        return bool(self.verdicts) and all(verdict.as_template for verdict in self.verdicts.values())


def marked(
    name: str,
    text: bytes,
    limits: FenceLimits = FenceLimits(),  # noqa: B008 (frozen)
    stopped: Callable[[], bool] = lambda: False,
    language: Language = "en",
) -> LawMarks:
    """Marks of a file. `stopped`: polled; True gives up."""
    marks = LawMarks()
    why = fenced("app.features.marks.marked", [name, language], text, partial(take, marks), limits, stopped)
    if len(marks.verdicts) < len(TRIALS):
        marks.ended = why
    return marks


def take(marks: LawMarks, said: dict[str, Any]) -> None:
    if "isolation" in said:
        marks.isolation = str(said["isolation"])
        return
    verdict = msgspec.convert(said | {"curve": None}, TrialResult)
    if verdict.name in TRIALS:
        marks.verdicts[verdict.name] = verdict
        if said["curve"] is not None:
            marks.verdicts[verdict.name] = replace(verdict, curve=_read_curve(said["curve"]))


def _read_curve(said: object) -> TrialCurve:
    """Raises `ValueError` if it is not a curve."""
    curve = msgspec.convert(said, TrialCurve)
    numbers = [value for line in curve.lines.values() for value in line if value is not None]
    small = len(curve.lines) <= 2 and all(
        len(line) == PIECES and len(name) <= 40 for name, line in curve.lines.items()
    )
    if not small or not all(map(math.isfinite, (curve.seconds, curve.limit or 0.0, *numbers))):
        raise ValueError("no curve")
    return curve


def main() -> None:
    limits, (name, language), text = fenced_input()
    set_language(language)  # pyright: ignore[reportArgumentType]
    for verdict in examine(Path(name), limits, text=text):
        say(asdict(verdict) | {"reason": "" if verdict.passed else tr(verdict.reason)})
