"""A student's progress, to JSON and back."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Annotated, Any, Final, NamedTuple, get_type_hints

import msgspec

from app.features.lessons.outcomes import Attempt, StepOutcome
from app.features.measures.quantities.quantity import Value
from app.plots.curve_chart import COLUMNS, Curve
from app.settings import Settings
from controllers.errors import LazyText
from scenes.inputs import Recorded
from scenes.roles import TargetSource
from scenes.settings import specs

VERSION: Final = 1
MOST_WORDS: Final = 4000
"""Longest own text [characters]."""

LONGEST_REASON: Final = 200
"""Longest reason [characters]."""


def kept_reason(typed: str) -> str:
    return typed[:LONGEST_REASON].strip()


MOST_TRIES: Final = 30


class Try(NamedTuple):
    """A try at a search, or a push of a duel.

    Attributes:
        setting: [SI]; w_max of a push.
        measured: of the first criterion [SI].
    """

    setting: float
    measured: float
    met: bool


@dataclass
class StepProgress:
    """Progress in a step.

    Attributes:
        guess: distance on the line of contact [m].
        why: outcome of the run that shows why the answer is wrong.
        tries: at a search or a duel, oldest first.
    """

    choice: Annotated[int, msgspec.Meta(ge=0, le=99)] | None = None
    outcome: StepOutcome | None = None
    why: StepOutcome | None = None
    hints: Annotated[int, msgspec.Meta(ge=0, le=99)] = 0
    attempts: Annotated[int, msgspec.Meta(ge=0)] = 0
    passed: bool = False
    last: Attempt | None = None
    words: str = ""
    because: str = ""
    tries: tuple[Try, ...] = ()
    drawing: Curve = ()
    guess: Value = None

    @property
    def predicted(self) -> bool:
        """True if the run may be seen."""
        return self.choice is not None or bool(self.drawing)

    @property
    def untouched(self) -> bool:
        return self == StepProgress()

    def note(self, attempt: Attempt, again: bool = False) -> None:
        """Record an attempt. `again`: of the same run, counted once."""
        self.attempts += not again
        self.last, self.passed = attempt, self.passed or attempt.passed


@dataclass
class Progress:
    """Progress by (lesson, step), and the current place, by ids."""

    lesson: str = ""
    step: str = ""
    phase: str = ""
    steps: dict[tuple[str, str], StepProgress] = field(default_factory=dict)

    def at(self, lesson: str, step: str) -> StepProgress:
        return self.steps.setdefault((lesson, step), StepProgress())


def to_json(progress: Progress) -> str:
    steps = [
        {"lesson": lesson, "step": step, **asdict(p)}
        for (lesson, step), p in progress.steps.items()
        if not p.untouched
    ]
    whole = {"lesson": progress.lesson, "step": progress.step, "phase": progress.phase, "steps": steps}
    return json.dumps({"version": VERSION, **_plain(whole)}, allow_nan=False)


def _plain(data: Any) -> Any:
    """Replace infinity and `LazyText`, which JSON does not have."""
    if isinstance(data, LazyText):
        return {"template": data.template, "parts": _plain(data.parts)}
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_plain(value) for value in data]
    return str(data) if isinstance(data, float) and math.isinf(data) else data


def from_json(text: str) -> Progress:
    """Read progress without its unreadable parts. Never raises."""
    try:
        whole = msgspec.json.decode(text, type=dict[str, Any])
    except (msgspec.MsgspecError, RecursionError, UnicodeEncodeError):
        return Progress()
    if _read(whole.get("version"), int, 0) != VERSION:
        return Progress()
    progress = Progress(*(_read(whole.get(name), _Word, "") for name in ("lesson", "step", "phase")))
    for entry in _read(whole.get("steps"), list[dict[str, Any]], []):
        lesson, step = (_read(entry.get(name), _Word, "") for name in ("lesson", "step"))
        if lesson and step:
            progress.steps[lesson, step] = _step(entry)
    return progress


_Word = Annotated[str, msgspec.Meta(max_length=80)]


def _read(value: object, kind: Any, otherwise: Any) -> Any:
    try:
        return msgspec.convert(value if kind in (str, _Word) else _numbers(value), kind, dec_hook=_text)
    except (msgspec.MsgspecError, RecursionError):
        return otherwise


def _numbers(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _numbers(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_numbers(value) for value in data]
    return float(data) if data in ("inf", "-inf") else data


def _step(entry: dict[str, Any]) -> StepProgress:
    fresh = StepProgress()
    done = StepProgress(
        **{name: _read(entry.get(name), kind, getattr(fresh, name)) for name, kind in _KINDS.items()}
    )
    done.words, done.because = done.words[:MOST_WORDS], done.because[:LONGEST_REASON]
    done.tries, done.drawing = done.tries[-MOST_TRIES:], _whole_curve(done.drawing)
    done.outcome, done.why = _possible(done.outcome), _possible(done.why)
    return done


_KINDS: Final = get_type_hints(StepProgress, include_extras=True)


def _whole_curve(curve: Curve) -> Curve:
    return curve if len(curve) == COLUMNS else ()


def _possible(outcome: StepOutcome | None) -> StepOutcome | None:
    if outcome is None:
        return None
    known = specs(Settings)
    unlike = tuple(
        (key, value)
        for key, value in outcome.unlike
        if key in known
        and isinstance(value, (str, int, float))
        and (not known[key].choices or value in known[key].choices)
    )
    return replace(outcome, unlike=unlike, curve=_whole_curve(outcome.curve))


def _text(kind: type, data: object) -> object:
    if kind is not LazyText:
        raise NotImplementedError(f"{kind} is no plain data")
    match data or {"template": "", "parts": {}}:
        case {"template": str(template), "parts": dict(parts)}:
            filled = {
                name: _text(LazyText, part) if isinstance(part, dict) else part
                for name, part in parts.items()
            }
        case _:
            raise ValueError(f"{data!r:.40} is no text")
    try:
        return LazyText(template, **filled)
    except (LookupError, TypeError, AttributeError) as error:
        raise ValueError("the parts of a text do not fit") from error


@dataclass(frozen=True)
class SavedLesson:
    """Lesson state that survives a disconnection.

    Attributes:
        progress: JSON of the walkthrough.
        own: settings outside the lessons.
        seen: (lesson, step) → run in which the visitor saw its outcome.
        now: settings of the step's own run; None if it is not open.
        said: (lesson, step) → typed forecasts.
    """

    progress: str
    own: Settings
    open: bool
    seen: Mapping[tuple[str, str], Recorded] = field(default_factory=dict)
    now: Settings | None = None
    kept: Mapping[str, TargetSource] = field(default_factory=dict)
    said: Mapping[tuple[str, str], tuple[float | None, ...]] = field(default_factory=dict)
    measured: bool = False
