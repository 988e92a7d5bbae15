"""A file of which nothing is trusted, put through the six tests."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from app.custom_law.examination import examine
from app.custom_law.fence import FenceLimits, fenced, fenced_input, say
from app.custom_law.trials import TRIALS


@dataclass
class LawMarks:
    """What came out for one file.

    Attributes:
        passed: whether each test was passed, by name; a test that was not made is missing.
        reasons: why a test failed, by name.
        ended: why the tests were not all made; "" if they were.
        isolation: "full", "network" or "none"; "" if nothing was run.
    """

    passed: dict[str, bool] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    ended: str = ""
    isolation: str = ""


def marked(
    name: str,
    text: bytes,
    limits: FenceLimits = FenceLimits(),  # noqa: B008 (frozen)
    stopped: Callable[[], bool] = lambda: False,
) -> LawMarks:
    """Return the marks of a file.

    Args:
        name: of the file, for its messages.
        text: what it holds.
        stopped: asked now and then whether to give up.
    """
    marks = LawMarks()
    why = fenced("app.custom_law.marked", [name], text, partial(_take, marks), limits, stopped)
    if len(marks.passed) < len(TRIALS):
        marks.ended = why
    return marks


def _take(marks: LawMarks, said: dict[str, Any]) -> None:
    if "isolation" in said:
        marks.isolation = str(said["isolation"])
    elif said["name"] in TRIALS:
        marks.passed[said["name"]] = said["passed"] is True
        if said["passed"] is not True:
            marks.reasons[said["name"]] = str(said["reason"])


def main() -> None:
    """Make the tests."""
    limits, (name,), text = fenced_input()
    for verdict in examine(Path(name), limits, text=text):
        say(asdict(verdict) | {"reason": str(verdict.reason)})


if __name__ == "__main__":
    main()
