"""A student's lab report."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from app.features.lab_report.gain import QuestionGain, gains, own_pairs, whole
from app.features.lab_report.report_html import SHEET, StepRecord, locked_page, plain_svg, records_html
from app.features.lessons.bookmark import phases_of
from app.features.lessons.curve_drawing import drawing_svg
from app.features.lessons.labels import sentence
from app.features.lessons.lesson import LAST, Lesson, Step
from app.features.lessons.progress import StepProgress
from app.features.lessons.reference_runs import begin_reference_run, person_of
from app.features.lessons.runs import Setup, settings_text
from app.features.lessons.step_view import StepPosition, StepView, make_view
from app.i18n.speaking import set_language, tr
from app.recording.run_file import made_here
from app.session.relevant_settings import matters
from app.settings import Language, Settings
from app.text.lesson_text import inline_html, lesson_html, plain
from app.text.setting_values import page_value
from app.text.templates import lowered
from scenes.inputs import InputsLog, Recorded
from scenes.settings import RunSettings, named_values, specs, values
from scenes.simulation import Simulation
from scenes.wanted import while_wanted

LINE: Final = "_" * 24


@dataclass(frozen=True)
class Done:
    """A student's work in one step, as plain data. `seen`: run that answered the question, or None."""

    lesson: Lesson
    index: int
    progress: StepProgress
    seen: Recorded | None = None

    @property
    def step(self) -> Step:
        return self.lesson.steps[self.index]


@dataclass(frozen=True)
class ReportEntry:
    """One step in a report; empty parts are left out. `view`: at the step's end; `plot`: <svg> element."""

    view: StepView
    settings: str = ""
    plot: str = ""

    @property
    def title(self) -> str:
        return f"{self.view.lesson.number}.{self.view.index + 1}  {plain(self.view.step.title)}"

    @property
    def drawing(self) -> str:
        """<svg> element of both curves, or ""."""
        drawing, curves = self.view.step.drawing, self.view.drawing
        return (
            ""
            if drawing is None or curves is None or not curves.drawn
            else drawing_svg(drawing, curves.drawn, curves.truth)
        )

    @property
    def judgements(self) -> list[tuple[str, bool]]:
        """Lines of the newest attempt; True if met."""
        last = self.view.done.last
        return [] if last is None else [(sentence(tr(one.text)), one.passed) for one in last.judgements]

    @property
    def passed(self) -> bool | None:
        """True if ever; None without a challenge."""
        return None if self.view.step.challenge is None else self.view.done.passed

    @property
    def record(self) -> StepRecord | None:
        """None for a test, which counts for no marks."""
        view, done = self.view, self.view.done
        if view.step.asked:
            return None
        number = None if done.choice is None else done.choice + 1
        right = None if view.verdict is None else view.verdict.right
        return StepRecord(view.lesson.id, view.step.id, number, right, self.passed, done.attempts)


def lesson_title(lesson: Lesson) -> str:
    return tr("Lesson {number}: {title}", number=lesson.number, title=plain(lesson.title))


def report_title(done: Sequence[Done]) -> str:
    lessons = {one.lesson.id: one.lesson for one in done}
    if len(lessons) != 1:
        return tr("Lab report")
    (lesson,) = lessons.values()
    return tr("Lab report: lesson {number}, {title}", number=lesson.number, title=plain(lesson.title))


def lab_bytes(done: Sequence[Done], language: Language) -> bytes:
    """HTML file in `language`.

    Raises:
        BadSetting: a run cannot be computed again here.
    """
    set_language(language)
    entries: list[ReportEntry] = []
    last: RunSettings | None = None
    for i, one in enumerate(while_wanted(done)):
        recorded = one.seen or _made_again(one)
        entries.append(step_entry(one, recorded, f"p{i}"))
        last = last if recorded is None else recorded.stretches[-1].settings
    about = f"{tr('Name')}: {LINE} · {time.strftime('%Y-%m-%d')}"
    settings = None if last is None else Settings(run=last)
    lessons = {one.lesson.id: one.lesson for one in done}
    progress = {(one.lesson.id, one.step.id): one.progress for one in done}
    pairs = own_pairs(lessons.values(), lambda *step: progress.get(step, StepProgress()))
    questions = gains(pairs, lessons.values())
    return report_html(report_title(done), entries, settings, about=about, questions=questions).encode()


def report_html(
    title: str,
    entries: Sequence[ReportEntry],
    settings: Settings | None,
    *,
    about: str = "",
    questions: Sequence[QuestionGain] = (),
) -> str:
    """Page that loads and runs nothing, with the student's text escaped.

    Args:
        about: line under the title.
        questions: of a test answered twice.

    Raises:
        ValueError: a plot is not a plain <svg> element.
    """
    made = f"{tr('Made by Duet')} {made_here()['duet']}"
    return locked_page(
        "features/lab_report/report.html",
        title,
        (SHEET,),
        about=f"{about} · {made}" if about else made,
        entries=entries,
        lesson_title=lesson_title,
        rich=rich_html,
        svg=plain_svg,
        questions=questions,
        total=whole(questions),
        settings=None if settings is None else _rows(settings),
        records=records_html([entry.record for entry in entries if entry.record is not None]),
    )


def _rows(settings: Settings) -> list[tuple[str, str, str]]:
    present, known = named_values(settings.run), specs(RunSettings)
    return [
        (known[key].label, page_value(key, value), known[key].help)
        for key, value in present.items()
        if matters(key, settings)
    ]


def rich_html(text: str) -> Markup:
    """A lesson's text as HTML; a single line without <p>."""
    if "\n" in text.strip() or "$$" in text:
        return lesson_html(text)
    made = inline_html(text.strip())
    return made if "<svg" in made else lowered(made)


def step_entry(one: Done, recorded: Recorded | None = None, name: str = "") -> ReportEntry:
    """Report on a step. `recorded`: run to show, or None; `name`: of its plot, unique on a page."""
    step = one.step
    at = StepPosition(one.lesson, step, one.index, phases_of(step)[-1], one.progress, None)
    view = make_view(at, step.yours, False, False)
    if recorded is None:
        return ReportEntry(view)
    return ReportEntry(view, _settings(recorded.stretches[-1].settings), _svg(recorded, step, name))


def _settings(run: RunSettings) -> str:
    first = values(RunSettings())
    return settings_text(tuple((key, value) for key, value in values(run).items() if value != first[key]))


def _svg(recorded: Recorded, step: Step, name: str) -> str:
    # What draws takes seconds to import.
    from app.features.exports.plot_pictures import inline_svg

    return inline_svg(recorded, name, step.plots)


def _made_again(one: Done) -> Recorded | None:
    """None if a visitor moved something in the step."""
    outcome = one.progress.outcome
    if outcome is None or outcome.unlike or one.step.yours or one.step.concept:
        return None
    return recorded_of(one.step.setup)


def recorded_of(setup: Setup) -> Recorded | None:
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
    """Every step with work. `progress`: of lesson and step; `seen`: (lesson, step) → run; `only`: name of a
    lesson.
    """
    return tuple(
        Done(lesson, i, progress(lesson.id, step.id), seen.get((lesson.id, step.id)))
        for lesson in lessons
        if only in (None, lesson.id, lesson.id + LAST)
        for i, step in enumerate(lesson.steps)
        if not progress(lesson.id, step.id).untouched
    )
