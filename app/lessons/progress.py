"""What a student has done, as plain data that survives a reload: to JSON and back, whatever the JSON turns out to be."""

import json
import math
from dataclasses import asdict, dataclass, field
from typing import Any, Final, NamedTuple

from app.lessons.measures.quantity import Value
from app.lessons.outcomes import Attempt, Judgement, StepOutcome
from app.lessons.runs import Pairs
from app.plots.curve_chart import COLUMNS, Curve
from app.settings import Settings
from controllers.errors import LazyText
from scenes.settings import specs

VERSION: Final = 1
MOST_WORDS: Final = 4000
"""Characters of a student's own words in a step."""

LONGEST_REASON: Final = 200
"""Characters of the reason that a student gives for a prediction."""


MOST_TRIES: Final = 30
"""Newest tries of a search that are remembered."""


class Try(NamedTuple):
    """One try at a challenge that asks for the value of a setting.

    Attributes:
        setting: its value, SI.
        measured: what the first inequality is about, SI.
        met: whether it held.
    """

    setting: float
    measured: float
    met: bool


@dataclass
class StepProgress:
    """What a student has done in one step.

    Attributes:
        choice: index of the answer; None before the first.
        drawing: the curve that was drawn; () for none.
        guess: the distance that was guessed on the line of contact [m]; None for none.
        why: of the run that shows why the answer is wrong.
        hints: how many are open.
        attempts: how often the challenge was tried.
        last: the newest attempt.
        words: of the student, about the whole step.
        because: the student's reason for the prediction.
        tries: at a challenge that asks for the value of a setting, oldest first.
    """

    choice: int | None = None
    outcome: StepOutcome | None = None
    why: StepOutcome | None = None
    hints: int = 0
    attempts: int = 0
    passed: bool = False
    last: Attempt | None = None
    words: str = ""
    because: str = ""
    tries: tuple[Try, ...] = ()
    drawing: Curve = ()
    guess: float | None = None

    @property
    def predicted(self) -> bool:
        """Return whether the run may be seen: an answer was chosen, or a curve was drawn."""
        return self.choice is not None or bool(self.drawing)

    @property
    def untouched(self) -> bool:
        """Return whether nothing was done here."""
        return self == StepProgress()


@dataclass
class Progress:
    """What a student has done, and where they are.

    Attributes:
        lesson, step, phase: where, by name.
        steps: (lesson, step) → what was done there.
    """

    lesson: str = ""
    step: str = ""
    phase: str = ""
    steps: dict[tuple[str, str], StepProgress] = field(default_factory=dict)

    def at(self, lesson: str, step: str) -> StepProgress:
        """Return the progress in a step, added if there is none."""
        return self.steps.setdefault((lesson, step), StepProgress())


def to_json(progress: Progress) -> str:
    """Return everything as text."""
    steps = [{"lesson": lesson, "step": step, **asdict(p)} for (lesson, step), p in progress.steps.items() if not p.untouched]
    whole = {"lesson": progress.lesson, "step": progress.step, "phase": progress.phase, "steps": steps}
    return json.dumps({"version": VERSION, **_plain(whole)}, allow_nan=False)


def _plain(data: Any) -> Any:
    """Return data with what JSON does not know in other words: infinity, a distance where nothing can be met, and a `LazyText`."""
    if isinstance(data, LazyText):
        return {"template": data.template, "parts": _plain(data.parts)}
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_plain(value) for value in data]
    return str(data) if isinstance(data, float) and math.isinf(data) else data


def from_json(text: str) -> Progress:
    """Return the progress in a JSON text; a part that cannot be read is left out, and nothing is raised."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return Progress()
    if not isinstance(data, dict) or data.get("version") != VERSION:
        return Progress()
    progress = Progress(_word(data.get("lesson")), _word(data.get("step")), _word(data.get("phase")))
    steps = data.get("steps")
    for entry in steps if isinstance(steps, list) else []:
        if isinstance(entry, dict) and _word(entry.get("lesson")) and _word(entry.get("step")):
            progress.steps[_word(entry["lesson"]), _word(entry["step"])] = StepProgress(
                _count(entry.get("choice"), 99),
                _outcome(entry.get("outcome")),
                _outcome(entry.get("why")),
                _count(entry.get("hints"), 99) or 0,
                _count(entry.get("attempts"), 10**9) or 0,
                entry.get("passed") is True,
                _attempt(entry.get("last")),
                str(entry.get("words") or "")[:MOST_WORDS],
                str(entry.get("because") or "")[:LONGEST_REASON],
                _tries(entry.get("tries")),
                _curve(entry.get("drawing")),
                _value(entry.get("guess")),
            )
    return progress


def _word(value: object) -> str:
    return value[:80] if isinstance(value, str) else ""


def _count(value: object, most: int) -> int | None:
    return value if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= most else None


def _outcome(data: object) -> StepOutcome | None:
    if not isinstance(data, dict) or not isinstance(data.get("values"), list):
        return None
    rows = [row for row in data["values"] if isinstance(row, list)]
    values = tuple(tuple(_value(v) for v in row) for row in rows)
    return StepOutcome(
        values, data.get("complete") is True, data.get("reference") is True, _pairs(data.get("unlike")), _curve(data.get("curve"))
    )


def _value(value: object) -> Value:
    if value in ("inf", "-inf"):
        return float(str(value))
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _curve(data: object) -> Curve:
    return tuple(_value(v) for v in data) if isinstance(data, list) and len(data) == COLUMNS else ()


def _pairs(data: object) -> Pairs:
    known = specs(Settings)
    return tuple(
        (str(pair[0]), pair[1])
        for pair in (data if isinstance(data, list) else [])
        if isinstance(pair, list)
        and len(pair) == 2
        and pair[0] in known
        and isinstance(pair[1], (str, int, float))
        and (not known[pair[0]].choices or pair[1] in known[pair[0]].choices)
    )


def _tries(data: object) -> tuple[Try, ...]:
    found = [row for row in data if isinstance(row, list) and len(row) == 3] if isinstance(data, list) else []
    numbers = [(_value(setting), _value(measured), met is True) for setting, measured, met in found[-MOST_TRIES:]]
    return tuple(Try(a, b, met) for a, b, met in numbers if a is not None and b is not None)


def _attempt(data: object) -> Attempt | None:
    if not isinstance(data, dict) or not isinstance(data.get("judgements"), list):
        return None
    judgements = tuple(
        Judgement(_word(j.get("id")), j.get("passed") is True, _text(j.get("text")), _value(j.get("value")))
        for j in data["judgements"]
        if isinstance(j, dict)
    )
    return Attempt(data.get("passed") is True, judgements, _text(data.get("note")))


def _text(data: object) -> str:
    """Return a `LazyText`, or "" for what is none."""
    if not isinstance(data, dict) or not isinstance(data.get("template"), str) or not isinstance(data.get("parts"), dict):
        return ""
    parts = {name: _text(part) if isinstance(part, dict) else part for name, part in data["parts"].items()}
    try:
        return LazyText(data["template"], **parts)
    except (LookupError, ValueError, TypeError, AttributeError):
        return ""
