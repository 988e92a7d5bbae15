"""`lwr-duet lessons --check`: walks every path through every lesson.

Right paths must pass, wrong ones fail as declared, and no challenge may pass unchanged.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from time import perf_counter
from typing import Final, Literal

from app.features.custom_law import template
from app.features.custom_law.arena import TrialResult
from app.features.custom_law.trials import TRIALS, verdict_on
from app.features.lessons.attempts import StandIn
from app.features.lessons.bookmark import Phase
from app.features.lessons.contrasts import LEAST_SHARE, contrast_size
from app.features.lessons.curve_drawing import ENOUGH, flat_line
from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import AT_ONCE, Challenge, Lesson, LessonBook, Question, Step, Trial
from app.features.lessons.outcomes import reference
from app.features.lessons.reference_runs import measured, simulated
from app.features.lessons.runs import Input, Setup
from app.features.lessons.walkthrough import Walkthrough
from app.plots.curve_chart import COLUMNS
from scenes.settings import LawSettings

WRONG_PATHS: Final = 3

PathKind = Literal["reference", "answer", "drawing", "untouched", "attempt", "lesson"]


@dataclass(frozen=True)
class Walk:
    """One path through a lesson. `wrong`: it should fail; `seconds`: wall time."""

    lesson: str
    step: str
    kind: PathKind
    name: str
    wrong: bool
    ok: bool
    text: str
    seconds: float


def check_lesson(book: LessonBook, lesson: Lesson) -> tuple[Walk, ...]:
    walks = [_timed(at_step(book, lesson, 0), "reference", "the right answers", False, _reference)]
    for number, step in enumerate(lesson.steps):
        walks += [_timed(at_step(book, lesson, number), *path) for path in _paths(step)]
    wrong = sum(walk.wrong and walk.ok for walk in walks if walk.kind in ("answer", "attempt"))
    text = f"{wrong} wrong paths fail as declared; at least {WRONG_PATHS} are asked for"
    walks.append(Walk(lesson.id, "", "lesson", "wrong paths", False, wrong >= WRONG_PATHS, text, 0.0))
    walks += [
        Walk(lesson.id, step, "lesson", name, False, False, text, 0.0)
        for step, name, text in _missing(book, lesson)
    ]
    return tuple(walks)


def at_step(book: LessonBook, lesson: Lesson, number: int) -> Walkthrough:
    """Student who has just come to step `number` (0-based)."""
    walk = Walkthrough(book)
    walk.go(lesson.id, number)
    return walk


def _paths(step: Step) -> Iterator[tuple[PathKind, str, bool, Callable[[Walkthrough], str]]]:
    """Kind, name, true if it should fail, function; without the right answer."""
    wrong = (
        []
        if step.question is None
        else [i for i in range(len(step.question.choices)) if i != step.question.right]
    )
    for i in wrong:
        yield "answer", f"answer {i + 1}", True, partial(_wrong_answer, answer=i)
    if step.drawing is not None:
        yield "drawing", "the truth, drawn", False, partial(_drawn, flat=False)
        yield "drawing", "a flat line", True, partial(_drawn, flat=True)
    if step.challenge is not None:
        yield "untouched", "as the step starts it", True, _untouched
    for trial in step.trials:
        yield "attempt", trial.name, bool(trial.fails), partial(_attempt, trial=trial)


def _missing(book: LessonBook, lesson: Lesson) -> Iterator[tuple[str, str, str]]:
    """Step or "", name, remedy."""
    unsaid = [name for name, text in (("Promise", lesson.promise), ("Learned", lesson.learned)) if not text]
    if unsaid and lesson.steps[0].setup.folder == FOLDER:
        yield "", "list", f"no “### {unsaid[0]}” under the title: the list of lessons shows it"
    walks = [at_step(book, lesson, number) for number in range(len(lesson.steps))]
    early = [f"{walk.step.id}: {what}" for walk in walks for what in shown_early(walk)]
    if early:
        yield "", "questions", f"shown while it is asked: {', '.join(early)}"
    untried = [
        s.id for s in lesson.steps if s.challenge is not None and not any(not t.fails for t in s.trials)
    ]
    if untried:
        yield untried[0], "challenges", f"no declared attempt passes the challenge of {', '.join(untried)}"


class NotAsDeclared(Exception):
    """The message gives the difference."""


def _timed(
    walk: Walkthrough, kind: PathKind, name: str, wrong: bool, path: Callable[[Walkthrough], str]
) -> Walk:
    lesson, step, begin = walk.lesson.id, walk.step.id, perf_counter()
    try:
        ok, text = True, path(walk)
    except NotAsDeclared as error:
        ok, text = False, str(error)
    return Walk(lesson, step, kind, name, wrong, ok, text, round(perf_counter() - begin, 3))


def _ensure(condition: bool, text: str) -> None:
    if not condition:
        raise NotAsDeclared(text)


def _reference(walk: Walkthrough) -> str:
    lesson, found = walk.lesson, list[str]()
    for number, step in enumerate(lesson.steps):
        where = f"step {number + 1}, {step.id}"
        _ensure(walk.step is step, f"{where}: the way leads to {walk.step.id} instead")
        if step.concept and step.question is not None:
            found.append(_asked(walk, step, step.question, step.question.right, where))
            walk.go(lesson.id, min(number + 1, len(lesson.steps) - 1))
            continue
        if step.question is not None:
            _ensure(walk.locked and not walk.next(), f"{where}: Run is not locked before an answer is chosen")
            walk.choose(step.question.right)
        _ensure(walk.phase is Phase.DO, f"{where}: after the answer comes {walk.phase}")
        outcome = walk.observe(simulated(walk.setup))
        if walk.phase is Phase.DO:
            walk.next()
        for m, values in outcome.known(step).items():
            _ensure(all(v is not None for v in values), f"{where}: the run does not tell {m}")
        if step.question is not None:
            decides = outcome.answer(step.question)
            expected = not step.question.expects or step.question.supported(decides) == step.question.right
            _ensure(expected, f"{where}: measured {decides}, which does not speak for the right answer")
            verdict = walk.view().verdict
            _ensure(verdict is not None and verdict.right, f"{where}: the right answer is not called right")
        found += [m.text(values[0]) for m, values in zip(step.measurements, outcome.values, strict=True)]
        while walk.phase is not walk.phases[-1]:
            walk.next()
        if step.challenge is not None:
            trial = next((t for t in step.trials if not t.fails), None)
            if trial is None:
                raise NotAsDeclared(f"{where}: no attempt is declared that passes")
            _ensure(_tried(walk, step, trial) == (), f"{where}: {walk.done.last}")
            _ensure(walk.done.passed, f"{where}: the challenge was passed, but is not noted")
        _ensure("{measured" not in str(walk.view().texts), f"{where}: a number is left open in the text")
        walk.next()
    return ", ".join(found)


def _wrong_answer(walk: Walkthrough, answer: int) -> str:
    question = walk.step.question
    assert question is not None
    if walk.step.concept:
        return _asked(walk, walk.step, question, answer, f"answer {answer + 1}")
    _ensure(walk.choose(answer), "the answer was not taken")
    outcome = walk.observe(simulated(walk.setup))
    if walk.phase is Phase.DO:
        walk.next()
    verdict = walk.view().verdict
    _ensure(verdict is not None and not verdict.right, "the wrong answer is called right")
    decides = outcome.answer(question)
    _ensure(question.supported(decides) != answer, f"measured {decides}, which speaks for the wrong answer")
    m = walk.step.measurements[0]
    text = m.text(outcome.values[0][0])
    if walk.show_why():
        why = walk.observe(simulated(walk.setup))
        decides = why.answer(question)
        _ensure(
            walk.done.why is not None and why.values[0][0] is not None, "the run that shows why does not tell"
        )
        shown, choice = m.text(why.values[0][0]), question.choices[answer]
        _ensure(
            choice.same or shown != text,
            f"the run that shows why gives {shown} as the question's does; say same = true if that is the point",
        )
        size = contrast_size(
            simulated(walk.step.setup), simulated(walk.setup), (outcome.values[0][0], why.values[0][0])
        )
        _ensure(
            not choice.same or size.share < LEAST_SHARE,
            f"the run that shows why gives {shown}, which is not the same",
        )
        _ensure(
            choice.same or size.seen,
            f"the run that shows why cannot be told from the question's: {size.text}",
        )
        _ensure(
            not choice.same or not only_moves_otherwise(walk.step.setup, walk.setup) or size.moves_otherwise,
            f"the run that shows why moves nearly as the question's does: {size.text}",
        )
        speaks = question.supported(decides) == answer
        if choice.otherwise:
            _ensure(
                speaks,
                f"the run in which the answer would be right gives {decides}: it does not speak for it",
            )
        else:
            _ensure(not speaks, f"the run that shows why gives {decides}: it speaks for the wrong answer")
        text += f", and {shown} in the run that shows why"
    return text


def only_moves_otherwise(asked: Setup, beside: Setup) -> bool:
    return asked.input != beside.input and (asked.run, asked.start) == (beside.run, beside.start)


def _asked(walk: Walkthrough, step: Step, question: Question, answer: int, where: str) -> str:
    outcome, right = reference(step, step.setup), answer == question.right
    _ensure(walk.choose(answer), f"{where}: the answer was not taken")
    supported = question.supported(outcome.answer(question))
    _ensure(
        supported == question.right or not question.expects,
        f"{where}: {outcome.answer(question)} speaks for another answer",
    )
    walk.next()
    verdict = walk.view().verdict
    if step.asked == "first":
        _ensure(verdict is None, f"{where}: the first test says what is right")
    else:
        _ensure(
            verdict is not None and verdict.right is right, f"{where}: the answer is judged the wrong way"
        )
    return ", ".join(m.text(found[0]) for m, found in zip(step.measurements, outcome.values, strict=True))


def shown_early(walk: Walkthrough) -> Iterator[str]:
    if walk.step.question is None:
        return
    if not walk.locked:
        yield "λ and what follows from it, on the card of the line of contact"
    yield from (f"the plot {plot}" for plot in walk.plots if plot in AT_ONCE)


def _drawn(walk: Walkthrough, flat: bool) -> str:
    drawing, truth = walk.step.drawing, reference(walk.step, walk.step.setup).curve
    assert drawing is not None
    known = [value for value in truth if value is not None]
    _ensure(
        len(known) >= ENOUGH * COLUMNS,
        f"the run comes to {len(known)} of {COLUMNS} columns; choose another range of x",
    )
    outside = [value for value in known if not drawing.y.low <= value <= drawing.y.high]
    _ensure(not outside, f"the truth leaves the axis, {outside[:1]}; choose another range of y")
    _ensure(walk.draw(flat_line(truth) if flat else truth), "the drawing was not taken")
    _ensure(walk.next() and walk.phase is Phase.DO, "a drawing does not unlock the run")
    walk.observe(simulated(walk.setup))
    if walk.phase is Phase.DO:
        walk.next()
    curves = walk.view().drawing
    assert curves is not None and curves.verdict is not None
    _ensure(
        curves.verdict.right is not flat,
        f"{'a flat line' if flat else 'the truth'} is judged the wrong way: {curves.verdict.text}",
    )
    return curves.verdict.text


def _go_to_challenge(walk: Walkthrough) -> None:
    if walk.step.question is not None:
        walk.choose(walk.step.question.right)
    while walk.phase is not Phase.CHALLENGE and walk.next():
        pass


def _untouched(walk: Walkthrough) -> str:
    _go_to_challenge(walk)
    challenge, texts = walk.step.challenge, list[str]()
    assert challenge is not None
    if challenge.custom_law:
        attempts = [walk.attempt_custom_law(_verdicts(""))]
    else:
        attempts = [walk.attempt(simulated(setup)) for setup in untouched(challenge, walk.step.trials)]
    for attempt in attempts:
        assert attempt is not None
        _ensure(not attempt.passed, f"passes with nothing changed: {attempt.text}")
        texts.append(attempt.text)
    return " / ".join(texts)


def untouched(challenge: Challenge, trials: tuple[Trial, ...]) -> Iterator[Setup]:
    """Runs of a challenge with nothing changed.

    If the student moves: without movement, and with the movements of passing attempts, which must fail
    without their settings or start.
    """
    asked = challenge.setup
    if asked.input.kind != "yours":
        yield asked
        return
    yield replace(asked, input=Input("none"))
    passing = [trial.setup for trial in trials if not trial.fails]
    if all((setup.run, setup.start) != (asked.run, asked.start) for setup in passing):
        yield from (replace(asked, input=setup.input, seconds=setup.seconds) for setup in passing)


def _attempt(walk: Walkthrough, trial: Trial) -> str:
    _go_to_challenge(walk)
    failed = _tried(walk, walk.step, trial)
    attempt = walk.done.last
    assert attempt is not None
    _ensure(
        set(failed) == set(trial.fails),
        f"fails by {failed or 'nothing'} instead of {trial.fails or 'nothing'}: {attempt.text}",
    )
    _ensure(walk.done.passed == (not trial.fails), "the attempt is not noted as it went")
    return attempt.text


def _tried(walk: Walkthrough, step: Step, trial: Trial) -> tuple[str, ...]:
    said = said_by(step, trial)
    attempt = (
        walk.attempt_custom_law(_verdicts(trial.law))
        if trial.law
        else walk.attempt(simulated(trial.setup), said)
    )
    if attempt is None:
        raise NotAsDeclared("the challenge took no attempt")
    return attempt.failed


@cache
def _verdicts(name: str) -> tuple[TrialResult, ...]:
    """ "" is the template."""
    law = LawSettings(law=name).made() if name else template.law
    return tuple(verdict_on(StandIn(law), test) for test in TRIALS)


def said_by(step: Step, trial: Trial) -> tuple[float | None, ...]:
    """Forecasts of a trial; a measurement's name becomes its value under the forecast's settings."""
    assert step.challenge is not None
    said: list[float | None] = []
    for forecast, given in zip(step.challenge.forecasts, trial.forecasts, strict=True):
        if isinstance(given, str):
            m = next(m for m in step.measurements if m.id == given)
            said.append(measured(step.challenge.setup.with_changes(forecast.changes), m.name, m.parameters))
        else:
            said.append(given)
    return tuple(said)


def table_text(walks: list[Walk]) -> str:
    lines = [
        f"{'ok  ' if walk.ok else 'FAIL'} {walk.lesson:20.20s} {walk.step:20.20s} {walk.kind:9s} {walk.name:24.24s} {walk.text:.200s}"
        for walk in walks
    ]
    failed, wrong = sum(not walk.ok for walk in walks), sum(walk.wrong for walk in walks)
    seconds = sum(walk.seconds for walk in walks)
    lines.append(
        f"{len(walks)} paths, {wrong} of them wrong ones; {failed} not as declared; {seconds:.1f} s."
    )
    return "\n".join(lines)
