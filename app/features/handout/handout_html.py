"""A lesson on paper."""

from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from app.features.lab_report.lab_report import lesson_title
from app.features.lab_report.report_html import locked_page
from app.features.lessons.curve_drawing import drawing_svg
from app.features.lessons.labels import label_of, sentence
from app.features.lessons.lesson import Lesson, Step
from app.features.lessons.loading import read_notes
from app.features.lessons.outcomes import StepOutcome, reference
from app.features.lessons.texts import fill, without_outcome
from app.plots.drawing_axes import axes_text, board_svg
from app.text.lesson_text import lesson_html
from app.text.picture import PICTURE


def handout_html(lesson: Lesson, notes: str | None = None) -> str:
    """Page to print in the current language; it loads and runs nothing.

    `notes`: the teacher's, as Markdown; None for the student's copy, which reveals no outcome.
    """
    read = None if notes is None else read_notes(notes)
    steps = [
        PaperStep(lesson, i, None if read is None else told(step)) for i, step in enumerate(lesson.steps)
    ]
    afterwards = any(one.pictures or (one.step.question and one.step.challenge) for one in steps)
    values = {"lesson": lesson, "steps": steps, "notes": read, "afterwards": afterwards}
    return locked_page(
        "features/handout/handout.html",
        lesson_title(lesson),
        (Path(__file__).with_name("handout.css"),),
        **values,
    )


def told(step: Step) -> StepOutcome:
    """Outcome without the note that it is the reference run."""
    return replace(reference(step, step.setup), reference=False)


@dataclass(frozen=True)
class PaperStep:
    """One printed step. `outcome`: None leaves blanks for what would reveal the answer."""

    lesson: Lesson
    index: int
    outcome: StepOutcome | None

    @property
    def step(self) -> Step:
        return self.lesson.steps[self.index]

    @property
    def number(self) -> str:
        return f"{self.lesson.number}.{self.index + 1}"

    def filled(self, text: str) -> str:
        return fill(self.step, text, self.outcome, self.lesson.language)

    def text(self, source: str) -> Markup:
        shown = without_outcome(source, self.step) if self.outcome is None else source
        return lesson_html(self.filled(shown), self.step.setup.folder)

    @property
    def axes(self) -> str:
        """Description of what to draw."""
        return "" if self.step.drawing is None else sentence(axes_text(self.step.drawing))

    @property
    def chart(self) -> Markup:
        drawing, outcome = self.step.drawing, self.outcome
        if drawing is None:
            return Markup()
        return board_svg(drawing, ()) if outcome is None else drawing_svg(drawing, (), outcome.curve)

    @property
    def choices(self) -> list[str]:
        """Markdown."""
        return (
            []
            if self.step.question is None
            else [self.filled(choice.text) for choice in self.step.question.choices]
        )

    @property
    def measured(self) -> tuple[str, ...]:
        """Measured values, or their names without an outcome."""
        if self.outcome is not None:
            return self.outcome.lines(self.step, self.lesson.language)
        return tuple(label_of(m, self.lesson.language) for m in self.step.measurements if not m.text_only)

    @property
    def pictures(self) -> list[tuple[Markup, str]]:
        step = self.step
        found = PICTURE.finditer("\n".join((step.goal, step.do, step.observe, step.explain)))
        return [(lesson_html(one[0].strip(), step.setup.folder), one[1]) for one in found]
