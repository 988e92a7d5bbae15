"""The phases of a step: which it has, and where a student who has done something in it belongs."""

from dataclasses import replace
from enum import StrEnum

from app.lessons.curve_drawing import checked_curve
from app.lessons.lesson import LessonBook, Step
from app.lessons.outcomes import StepOutcome
from app.lessons.progress import Progress, StepProgress


class Phase(StrEnum):
    """Where in a step the student is."""

    PREDICT = "predict"
    """The question is asked; nothing runs until an answer is chosen."""
    DO = "do"
    """The run."""
    OBSERVE = "observe"
    """What was measured, beside the answer."""
    EXPLAIN = "explain"
    """Why, with the equation."""
    CHALLENGE = "challenge"
    """Now the student."""


def phases_of(step: Step) -> tuple[Phase, ...]:
    return (
        *((Phase.PREDICT,) if step.question is not None else ()),
        Phase.DO,
        *((Phase.OBSERVE,) if step.measurements or step.observe else ()),
        *((Phase.EXPLAIN,) if step.explain else ()),
        *((Phase.CHALLENGE,) if step.challenge is not None else ()),
    )


def first_phase(step: Step, done: StepProgress) -> Phase:
    """Return where a student who comes from the step before begins."""
    phases = phases_of(step)
    return Phase.DO if phases[0] is Phase.PREDICT and done.predicted else phases[0]


def is_finished(step: Step, done: StepProgress) -> bool:
    """Return whether a step is finished: its challenge is passed, or without one its outcome has been seen."""
    if step.challenge is not None:
        return done.passed
    return done.outcome is not None or (not step.measurements and not done.untouched)


def furthest_phase(step: Step, done: StepProgress) -> Phase:
    """Return the last phase that a student has reached."""
    phases = phases_of(step)
    if done.outcome is not None or (not step.measurements and not done.untouched):
        return phases[-1]
    return first_phase(step, done)


def fitting(step: Step, done: StepProgress) -> StepProgress:
    """Return progress that fits a step which may have changed since."""
    question, fitting = step.question, replace(done)
    if question is None or (done.choice is not None and done.choice >= len(question.choices)):
        fitting.choice = None
    widths = [1 + len(m.compare) for m in step.measurements]
    for name in ("outcome", "why"):
        outcome: StepOutcome | None = getattr(done, name)
        if outcome is not None and [len(row) for row in outcome.values] != widths:
            setattr(fitting, name, None)
    fitting.drawing = (checked_curve(step.drawing, done.drawing) or ()) if step.drawing is not None else ()
    if question is not None and not fitting.predicted:
        fitting.outcome = fitting.why = None
    fitting.hints = min(done.hints, len(step.hints))
    return fitting


def fitting_steps(book: LessonBook, progress: Progress) -> dict[tuple[str, str], StepProgress]:
    """Return the progress that fits a book, which may have changed since, by lesson and step."""
    places = ((lesson.id, step) for lesson in book.lessons for step in lesson.steps)
    return {
        (lesson, step.id): fitting(step, progress.steps[lesson, step.id])
        for lesson, step in places
        if (lesson, step.id) in progress.steps
    }
