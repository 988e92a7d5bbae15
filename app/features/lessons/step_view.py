"""Data that a page shows of a walkthrough."""

import re
from dataclasses import dataclass, replace
from typing import Final

from app.features.lessons.bookmark import Phase, is_finished, phases_of
from app.features.lessons.curve_drawing import DrawnCurves, judge_drawing
from app.features.lessons.labels import Contrast, contrast_of
from app.features.lessons.lesson import Lesson, Step
from app.features.lessons.outcomes import AnswerVerdict
from app.features.lessons.progress import StepProgress, Try
from app.features.lessons.runs import Setup, settings_text
from app.features.lessons.texts import fill, tabled, told_in
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_

_SENTENCE_END: Final = re.compile(r"(?<=[.!?])\s+")

PLOTTED_TRIES: Final = 3


@dataclass(frozen=True)
class StepPosition:
    lesson: Lesson
    step: Step
    index: int
    phase: Phase
    done: StepProgress
    beside: Setup | None
    stale: bool = False


@dataclass(frozen=True, kw_only=True)
class StepView(StepPosition):
    """A step in the student's language: Markdown with LaTeX, numbers filled in. `done` is a copy.

    Attributes:
        texts: visible (phase or "goal", text), in order.
        drawing: with the truth once the outcome is known.
        why: a run shows why the answer is wrong; `showing` while it is on.
        why_outcome, contrast: of that run.
        tries: of a search, once enough to plot; pushes of a duel.
    """

    phases: tuple[Phase, ...]
    texts: tuple[tuple[str, str], ...]
    choices: tuple[str, ...]
    drawing: DrawnCurves | None
    locked: bool
    verdict: AnswerVerdict | None
    outcome: tuple[str, ...]
    why_outcome: tuple[str, ...]
    why: bool
    own_curve: bool
    showing: bool
    contrast: Contrast | None
    tries: tuple[Try, ...]
    forecasts: tuple[str, ...]
    hints: tuple[str, ...]
    yours: bool
    lesson_finished: bool
    can_next: bool
    can_back: bool


@dataclass(frozen=True)
class LessonEntry:
    """A line of the list of lessons. `step`: where it opens (0-based)."""

    lesson: Lesson
    finished: tuple[bool, ...]
    here: bool
    step: int

    @property
    def promise(self) -> str:
        return self.lesson.promise or first_sentence(self.lesson.goal)


def make_view(at: StepPosition, yours: bool, can_next: bool, can_back: bool) -> StepView:
    step, done, phases = at.step, at.done, phases_of(at.step)
    question, challenge, language = step.question, step.challenge, at.lesson.language
    by_phase = {
        Phase.PREDICT: question.text if question else "",
        Phase.DO: step.do,
        Phase.OBSERVE: step.observe,
        Phase.EXPLAIN: step.explain,
        Phase.CHALLENGE: challenge.text if challenge else "",
    }
    reached = phases[: phases.index(at.phase) + 1]
    outcome = done.outcome if knows_outcome(at.phase) else None
    drawing, truth = step.drawing, outcome.curve if outcome else ()
    texts = (
        (phase.value, fill(step, by_phase[phase], outcome if knows_outcome(phase) else None, language))
        for phase in reached
        if by_phase[phase]
    )
    return StepView(
        **vars(replace(at, done=replace(done))),
        phases=phases,
        texts=(("goal", fill(step, step.goal, None, language)), *texts),
        choices=tuple(fill(step, choice.text, None, language) for choice in question.choices)
        if question
        else (),
        drawing=DrawnCurves(done.drawing, truth, judge_drawing(drawing, done.drawing, truth, language))
        if drawing
        else None,
        locked=at.phase is Phase.PREDICT and not done.predicted,
        verdict=answer_verdict(at),
        outcome=outcome.lines(step, language) if outcome else (),
        why_outcome=done.why.lines(step, language) if outcome and done.why else (),
        why=why_of(at) is not None,
        own_curve=has_curve(at),
        showing=at.beside is not None,
        contrast=contrast(at),
        tries=done.tries if len(done.tries) >= PLOTTED_TRIES or (challenge and challenge.best_of) else (),
        forecasts=tuple(settings_text(f.changes, language) for f in challenge.forecasts) if challenge else (),
        hints=step.hints[: done.hints],
        yours=yours,
        lesson_finished=step is at.lesson.steps[-1]
        and at.phase is phases[-1]
        and at.beside is None
        and is_finished(step, done),
        can_next=can_next,
        can_back=can_back,
    )


def first_sentence(text: str) -> str:
    line = " ".join(text.split())
    ends = (end.start() for end in _SENTENCE_END.finditer(line))
    # A formula may hold a full stop.
    return line[: next((end for end in ends if line.count("$", 0, end) % 2 == 0), len(line))]


def knows_outcome(phase: Phase) -> bool:
    return phase not in (Phase.PREDICT, Phase.DO)


def why_of(at: StepPosition) -> Setup | None:
    """None if no such run may begin now."""
    question, choice = at.step.question, at.done.choice
    if (
        question is None
        or choice is None
        or choice == question.right
        or at.phase not in (Phase.OBSERVE, Phase.EXPLAIN)
    ):
        return None
    return question.choices[choice].why


def has_curve(at: StepPosition) -> bool:
    """True if the run with the drawn λ(d) may begin now."""
    drawn = at.step.drawing is not None and at.step.drawing.formula and len(at.done.drawing) > 0
    return drawn and at.phase in (Phase.OBSERVE, Phase.EXPLAIN)


def contrast(at: StepPosition) -> Contrast | None:
    question, choice, beside = at.step.question, at.done.choice, at.beside
    if beside is None:
        return None
    answer = None if question is None or choice is None else question.choices[choice]
    return contrast_of(
        at.step.setup,
        beside,
        answer if answer is not None and answer.why == beside else None,
        at.lesson.language,
    )


def answer_verdict(at: StepPosition) -> AnswerVerdict | None:
    question, done, language = at.step.question, at.done, at.lesson.language
    if question is None or done.choice is None or done.outcome is None or not knows_outcome(at.phase):
        return None
    right = done.choice == question.right
    choice = question.choices[done.choice]
    reply, told = fill(at.step, choice.reply, done.outcome, language), told_in(at.step, choice.reply)
    good = N_("That is right.") if at.step.concept else N_("You predicted it.")
    headline = words_of(language)(good if right else N_("Not quite."))
    return AnswerVerdict(
        right, headline, reply, done.outcome.lines(at.step, language, tabled(at.step.observe), told)
    )
