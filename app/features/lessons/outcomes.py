"""Measured values, verdicts and judgements: pure functions of evidence."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

from app.features.lessons.curve_drawing import true_curve
from app.features.lessons.labels import compared_text, label_of, label_text
from app.features.lessons.lesson import Challenge, Criterion, Forecast, Measurement, Question, Step
from app.features.lessons.reference_runs import comparisons, drawn, measured
from app.features.lessons.runs import Pairs, Setup, changes_text, deviations, settings_text
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import Value, measure, moment, shown_value
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.plots.curve_chart import Curve
from app.session.replay_player import Mark
from app.settings import Language
from app.text.setting_values import value_text
from controllers.errors import LazyText, NumberText
from scenes.settings import RunSettings, specs, values

BEYOND_CRITICAL: Final = {
    "distance_at": False,
    "smallest_distance": False,
    "distance_margin": True,
    "value_margin": True,
}
"""Measurements of d or another first task → true for d − d_m."""

FARTHEST: Final = 1.0
"""Largest |d| of a guess [m]."""

AT_END: Final = 0.15
"""Moments this close to the end count as the end [s]."""


def asks_for_distance(step: Step) -> bool:
    question = step.question
    if question is None or question.ratio or step.drawing is not None or not question.expects:
        return False
    return step.measurements[0].name in BEYOND_CRITICAL and len(set(question.expects)) == len(
        question.expects
    )


def guessed_answer(step: Step, distance: float) -> int | None:
    """Answer that `distance` [m] supports, or None."""
    if (
        step.question is None
        or not asks_for_distance(step)
        or not math.isfinite(distance)
        or abs(distance) > FARTHEST
    ):
        return None
    from_critical = BEYOND_CRITICAL[step.measurements[0].name]
    critical = float(values(step.setup.run)["dm"])
    return step.question.supported(distance - critical if from_critical else distance)


@dataclass(frozen=True)
class StepOutcome:
    """Outcome of a step's run.

    Attributes:
        values: of each measurement, followed by its comparisons.
        reference: the reference run replaced a run that was too short or had other settings.
        unlike: settings that differ from the question's.
        curve: true curve of a drawing, or ().
    """

    values: tuple[tuple[Value, ...], ...]
    complete: bool
    reference: bool = False
    unlike: Pairs = ()
    curve: Curve = ()

    def answer(self, question: Question) -> Value:
        return question.answer(self.values[0]) if self.values else None

    def known(self, step: Step) -> dict[str, tuple[Value, ...]]:
        return {m.id: v for m, v in zip(step.measurements, self.values, strict=True)}

    def lines(
        self, step: Step, language: Language, tabled: Collection[str] = (), told: Collection[str] = ()
    ) -> tuple[str, ...]:
        """Numbers with labels, and remarks on the run.

        Args:
            told: ids that a text shows, left out if others remain.
        """
        lines, words = list[str](), words_of(language)
        shown = [m for m in step.measurements if not m.text_only]
        left = [m for m in shown if m.id not in told] or shown
        for m, found in zip(step.measurements, self.values, strict=True):
            if m not in left:
                continue
            parts = [f"{label_of(m, language)}: {words(m.text(found[0]))}"]
            for compared, value in zip(m.compare, found[1:], strict=True):
                if value is not None and m.id not in tabled:
                    differs = compared_text(compared, language, step.setup.run.quantity)
                    parts.append(words(N_("with {settings}: {value}"), settings=differs, value=m.text(value)))
            lines.append("; ".join(parts) + ".")
        if self.reference and not self.unlike:
            lines.append(words(N_("Your run did not get that far, so this is the reference run.")))
        if self.unlike:
            text = N_(
                "This run had {settings}, other than the question is about. Reset and run to see what was asked."
            )
            if self.reference:
                text = N_(
                    "Your run had {settings}, other than the question is about, so this is the reference run."
                )
            lines.append(words(text, settings=settings_text(self.unlike, language, step.setup.run.quantity)))
        return tuple(lines)


def observed(step: Step, setup: Setup, evidence: Evidence, time: float) -> StepOutcome:
    """Measure a step's run.

    Args:
        setup: the step's, or that of a run that shows why an answer is wrong.
        time: simulated [s].
    """
    own = setup == step.setup
    found: list[tuple[Value, ...]] = []
    for i, m in enumerate(step.measurements):
        value = measure(evidence, m.name, m.parameters)
        # A run for a wrong answer needs comparisons only if the answer is a ratio, and it is not the other run.
        ratio = (
            i == 0
            and step.question is not None
            and step.question.ratio
            and m.compare[0].setup(step.setup) != setup
        )
        needed = m.compare if own else m.compare[:1] if ratio else ()
        found.append((value, *comparisons(setup, m, needed), *(None for _ in m.compare[len(needed) :])))
    complete = time >= setup.seconds - 0.5 * evidence.settings.dt and evidence.rows > 0
    curve = true_curve(step.drawing, evidence) if own and step.drawing is not None else ()
    return StepOutcome(tuple(found), complete, False, deviations(setup.run, evidence.settings), curve)


def reference(step: Step, setup: Setup) -> StepOutcome:
    if step.concept and not step.measurements:
        return StepOutcome((), True)
    own = [measured(setup, m.name, m.parameters) for m in step.measurements]
    found = tuple(
        (value, *comparisons(setup, m, m.compare)) for value, m in zip(own, step.measurements, strict=True)
    )
    curve = drawn(setup, step.drawing) if setup == step.setup and step.drawing is not None else ()
    return StepOutcome(found, True, not step.concept, curve=curve)


def decisive_moment(measurements: Sequence[Measurement], evidence: Evidence) -> Mark | None:
    """Moment of the first measurement that has one; None at the run's end."""
    for m in measurements:
        time = moment(evidence, m.name, m.parameters)
        if time is not None:
            return Mark(time, label_text(m)) if time < float(evidence.times[-1]) - AT_END else None
    return None


@dataclass(frozen=True)
class AnswerVerdict:
    """`reply`: Markdown with the run's numbers; `lines`: measured values."""

    right: bool
    headline: str
    reply: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Judgement:
    """Judgement of one criterion. `text`: measured value, bound, and difference; `value`: measured [SI]."""

    id: str
    passed: bool
    text: LazyText
    value: Value


_NO_NOTE = LazyText("")


@dataclass(frozen=True)
class Attempt:
    """A try at a challenge; `note`: why a run does not count."""

    passed: bool
    judgements: tuple[Judgement, ...]
    note: LazyText = _NO_NOTE

    @classmethod
    def of(cls, judgements: Sequence[Judgement]) -> "Attempt":
        return cls(bool(judgements) and all(j.passed for j in judgements), tuple(judgements))

    @property
    def failed(self) -> tuple[str, ...]:
        return tuple(j.id for j in self.judgements if not j.passed)

    @property
    def text(self) -> str:
        ordered = sorted(self.judgements, key=lambda j: j.passed)
        return " ".join((self.note, *(j.text for j in ordered))).strip()


def judge(challenge: Challenge, evidence: Evidence, said: Sequence[float | None]) -> Attempt:
    """Judge a run. `said`: forecasts in order; missing ones fail."""
    judgements = [
        judged(c, measure(evidence, c.measurement.name, c.measurement.parameters), challenge.setup.seconds)
        for c in challenge.criteria
    ]
    for i, forecast in enumerate(challenge.forecasts):
        number = said[i] if i < len(said) else None
        judgements.append(_foretold(forecast, number, challenge.setup))
    return Attempt.of(judgements)


def judged(criterion: Criterion, value: Value, seconds: float) -> Judgement:
    """Judge a criterion. `value`: measured [SI]; `seconds`: required length of the run [s]."""
    m, low, high = criterion.measurement, criterion.low, criterion.high
    label = label_text(m)

    def judgement(passed: bool, text: str, digits: int | None = None, **parts: str) -> Judgement:
        return Judgement(
            m.id, passed, LazyText(text, label=label, value=_text(m, value, digits), **parts), value
        )

    if value is None:
        text = N_("{label}: not known yet. Continue the run for {seconds}.")
        return Judgement(m.id, False, LazyText(text, label=label, seconds=NumberText(f"{seconds:g} s")), None)
    if low is not None and high == low:
        if abs(value - low) <= 1e-9 * max(1.0, abs(low)):
            return judgement(True, N_("{label}: {value}, as asked."))
        return judgement(False, N_("{label}: {value}, but it must be {bound}."), bound=_text(m, low))
    if low is not None and value < low:
        digits = _distinct_digits(m, value, low)
        bound, missing = _text(m, low, digits), _text(m, low - value, digits)
        text = N_("{label}: {value}, but it must be at least {bound}. {missing} is missing.")
        return judgement(False, text, digits, bound=bound, missing=missing)
    if high is not None and value > high:
        digits = _distinct_digits(m, value, high)
        bound, missing = _text(m, high, digits), _text(m, value - high, digits)
        text = N_("{label}: {value}, but it must be at most {bound}. That is {missing} too much.")
        return judgement(False, text, digits, bound=bound, missing=missing)
    if low is not None and high is not None:
        return judgement(
            True, N_("{label}: {value}, as asked ({low} to {high})."), low=_text(m, low), high=_text(m, high)
        )
    if low is not None:
        return judgement(True, N_("{label}: {value}, as asked (at least {bound})."), bound=_text(m, low))
    return judgement(True, N_("{label}: {value}, as asked (at most {bound})."), bound=_text(m, high))


def _text(m: Measurement, value: Value, digits: int | None = None) -> str:
    if m.name == "setting" and value is not None:
        key = str(dict(m.parameters)["key"])
        choices = specs()[key].choices
        if choices:
            return value_text(key, choices[min(max(int(value), 0), len(choices) - 1)])
        return value_text(key, bool(value) if isinstance(values(RunSettings())[key], bool) else value)
    return shown_value(value, m.unit, m.digits if digits is None else digits)


def _distinct_digits(m: Measurement, value: float, bound: float) -> int:
    return next((n for n in range(m.digits, 9) if _text(m, value, n) != _text(m, bound, n)), 9)


def _foretold(forecast: Forecast, said: float | None, setup: Setup) -> Judgement:
    m, settings = forecast.measurement, changes_text(forecast.changes)
    value = measured(setup.with_changes(forecast.changes), m.name, m.parameters)
    if said is None or value is None:
        return Judgement(
            m.id, False, LazyText("With {settings}: no number was given.", settings=settings), value
        )
    error = abs(said - value) / abs(value) if value else float("inf")
    passed = error <= forecast.within
    text = (
        N_("With {settings} you said {said}, and it is {value}: {error} off, at most {within} is allowed.")
        if passed
        else N_(
            "With {settings} you said {said}, but it is {value}: {error} off, at most {within} is allowed."
        )
    )
    parts = {
        "error": NumberText(f"{100.0 * error:.1f}%"),
        "within": NumberText(f"{100.0 * forecast.within:g}%"),
    }
    return Judgement(
        m.id,
        passed,
        LazyText(text, settings=settings, said=m.text(said), value=m.text(value), **parts),
        value,
    )
