"""A student's lab report on lessons: what was predicted and what came out, the runs' plots, the settings, and the student's own words."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from app.export.gain import gains, own_pairs
from app.export.report_html import ReportEntry, StepRecord, report_html
from app.i18n.speaking import set_language, tr
from app.lessons.bookmark import phases_of
from app.lessons.curve_drawing import drawing_svg
from app.lessons.labels import sentence
from app.lessons.lesson import LAST, Lesson, Step
from app.lessons.progress import StepProgress
from app.lessons.reference_runs import begin_reference_run, person_of
from app.lessons.runs import Setup, settings_text
from app.lessons.step_view import StepPosition, make_view
from app.settings import Language, Settings
from app.text.lesson_text import inline_html, lesson_html, plain
from app.text.templates import lowered
from scenes.inputs import InputsLog, Recorded
from scenes.rerun import never, while_wanted
from scenes.settings import RunSettings, values
from scenes.simulation import Simulation

LINE: Final = "_" * 24
"""For a name to be written by hand."""


@dataclass(frozen=True)
class Done:
    """One step of a lesson, and what a student did in it. Plain data, so that it can be sent to another process.

    Attributes:
        seen: the run that answered the student's question; None if it was not stored.
    """

    lesson: Lesson
    index: int
    progress: StepProgress
    seen: Recorded | None = None

    @property
    def step(self) -> Step:
        return self.lesson.steps[self.index]


def lesson_title(lesson: Lesson) -> str:
    """Return number and title of a lesson, in the language that is spoken here."""
    return tr("Lesson {number}: {title}", number=lesson.number, title=plain(lesson.title))


def report_title(done: Sequence[Done]) -> str:
    """Return the title of a report on these steps, in the language that is spoken here."""
    lessons = {one.lesson.id: one.lesson for one in done}
    if len(lessons) != 1:
        return tr("Lab report")
    (lesson,) = lessons.values()
    return tr("Lab report: lesson {number}, {title}", number=lesson.number, title=plain(lesson.title))


def lab_bytes(done: Sequence[Done], language: Language, stopped: Callable[[], bool] = never) -> bytes:
    """Return the report as one HTML file.

    Args:
        language: in which the report speaks.
        stopped: asked now and then; when it says True, everything ends with `Stopped`.

    Raises:
        BadSetting: a run cannot be made again here.
    """
    set_language(language)
    entries: list[ReportEntry] = []
    last: RunSettings | None = None
    for i, one in enumerate(while_wanted(done, stopped)):
        recorded = one.seen or _made_again(one)
        entries.append(step_entry(one, recorded, f"p{i}", stopped))
        last = last if recorded is None else recorded.stretches[-1].settings
    about = f"{tr('Name')}: {LINE} · {time.strftime('%Y-%m-%d')}"
    settings = None if last is None else Settings(run=last)
    lessons = {one.lesson.id: one.lesson for one in done}
    progress = {(one.lesson.id, one.step.id): one.progress for one in done}
    pairs = own_pairs(lessons.values(), lambda *step: progress.get(step, StepProgress()))
    questions = gains(pairs, lessons.values())
    return report_html(report_title(done), entries, settings, about=about, rich=rich_html, questions=questions).encode()


def rich_html(text: str) -> Markup:
    """Return a lesson's text as HTML: a line without a paragraph of its own, where it is one."""
    if "\n" in text.strip() or "$$" in text:
        return lesson_html(text)
    made = inline_html(text.strip())
    return made if "<svg" in made else lowered(made)


def step_entry(one: Done, recorded: Recorded | None = None, name: str = "", stopped: Callable[[], bool] = never) -> ReportEntry:
    """Return what is reported on a step.

    Args:
        recorded: the run whose settings and plot are shown; None to leave them out.
        name: of the plot, another one for each on a page.
        stopped: see `lab_bytes`.
    """
    lesson, step, progress = one.lesson, one.step, one.progress
    view = make_view(StepPosition(lesson, step, one.index, phases_of(step)[-1], progress, None), step.yours, False, False)
    texts = dict(view.texts)
    verdict, attempt = view.verdict, progress.last
    curves = view.drawing if view.drawing is not None and view.drawing.drawn else None
    right = verdict.right if verdict is not None else None
    passed = progress.passed if step.challenge is not None else None
    number = progress.choice + 1 if progress.choice is not None else None
    return ReportEntry(
        title=f"{lesson.number}.{one.index + 1}  {plain(step.title)}",
        question=texts.get("predict", "") if view.choices else "",
        prediction=view.choices[progress.choice] if progress.choice is not None else "",
        right=right,
        verdict=verdict.reply if verdict is not None else "",
        outcome=view.outcome,
        judgements=tuple((sentence(tr(j.text)), j.passed) for j in attempt.judgements) if attempt is not None else (),
        attempts=progress.attempts,
        passed=passed,
        words=progress.words,
        chapter=lesson_title(lesson),
        settings=_settings(recorded.stretches[-1].settings) if recorded is not None else "",
        plot=_svg(recorded, step, name, stopped) if recorded is not None else "",
        drawing=drawing_svg(step.drawing, curves.drawn, curves.truth) if step.drawing is not None and curves is not None else "",
        # A test that is asked twice counts for no marks.
        record=None if step.asked else StepRecord(lesson.id, step.id, number, right, passed, progress.attempts),
        drawing_verdict=curves.verdict.text if curves is not None and curves.verdict is not None else "",
        because=progress.because,
    )


def _settings(run: RunSettings) -> str:
    first = values(RunSettings())
    return settings_text(tuple((key, value) for key, value in values(run).items() if value != first[key]))


def _svg(recorded: Recorded, step: Step, name: str, stopped: Callable[[], bool]) -> str:
    # What draws takes seconds to import.
    from app.export.plot_pictures import inline_svg

    return inline_svg(recorded, name, stopped, step.plots)


def _made_again(one: Done) -> Recorded | None:
    """Return a new run of a step without a stored one; None if a visitor's hand was in it."""
    outcome = one.progress.outcome
    if outcome is None or outcome.unlike or one.step.yours or one.step.concept:
        return None
    return recorded_of(one.step.setup)


def recorded_of(setup: Setup) -> Recorded | None:
    """Return the recorded run of a lesson's setup, computed without a page."""
    simulation, log = Simulation(setup.run, 1), InputsLog()
    begin_reference_run(simulation, setup)
    person = person_of(simulation, setup)
    for _ in range(max(1, round(setup.seconds / setup.run.dt))):
        target = person.target(simulation.time)
        log.record(simulation, target)
        simulation.step(target)
    return log.window(setup.seconds)


def done_in(
    lessons: Sequence[Lesson],
    progress: Callable[[str, str], StepProgress],
    seen: Mapping[tuple[str, str], Recorded],
    only: str | None = None,
) -> tuple[Done, ...]:
    """Return every step in which something was done.

    Args:
        lessons: all of them.
        progress: gives what was done in a step, by the names of lesson and step.
        seen: (lesson, step) → the run.
        only: name of the lesson that is meant; None for all.
    """
    return tuple(
        Done(lesson, i, progress(lesson.id, step.id), seen.get((lesson.id, step.id)))
        for lesson in lessons
        if only in (None, lesson.id, lesson.id + LAST)
        for i, step in enumerate(lesson.steps)
        if not progress(lesson.id, step.id).untouched
    )
