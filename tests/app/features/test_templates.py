"""Templates make HTML: a person's text never acts as markup on a page."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from jinja2 import UndefinedError

from app.features.custom_law.arena import TrialCurve
from app.features.custom_law.examination import ExaminationProgress
from app.features.custom_law.law_html import law_html
from app.features.exports.player import assembled
from app.features.exports.scene_film import Filmed
from app.features.handout.handout_html import handout_html
from app.features.lab_report.gain import gains, whole
from app.features.lab_report.lab_report import ReportEntry, report_html
from app.features.league.entrants import Entrant
from app.features.league.league_files import Played
from app.features.league.league_page import league_page, league_tables
from app.features.league.league_runs import QUICK, Outcome, events
from app.features.lessons.bookmark import Phase
from app.features.lessons.curve_drawing import DrawingVerdict, DrawnCurves
from app.features.lessons.labels import Contrast
from app.features.lessons.lesson import Choice, Lesson, Step
from app.features.lessons.loading import read_notes
from app.features.lessons.outcomes import AnswerVerdict, Attempt, Judgement
from app.features.lessons.panel.lesson_html import blocks_html
from app.features.lessons.progress import StepProgress, Try
from app.features.lessons.step_view import LessonEntry, StepPosition, StepView, make_view
from app.features.marks.graded_file import GradedFile, Remark, Student
from app.features.marks.mark_files import StudentMarks, feedback_page
from app.i18n.speaking import tr
from app.page.page_assets import titlebar
from app.page.panels.drawing_board import board_html
from app.page.panels.readout import late_law_html
from app.plots.chart import Chart, ChartAxes
from app.plots.curve_chart import COLUMNS
from app.session.late_law import LateLawStatus
from app.settings import Settings
from app.text.documents import document_html, document_page
from app.text.law_texts import equation_html
from app.text.templates import element, lowered, macros, page_of_template, tr_html
from controllers.errors import LazyText
from scenes.laws import DEFAULT_LAW
from scenes.settings import RunSettings
from tests.app.features.lessons.helpers import our_book
from tests.app.html_reader import HtmlReader
from tests.test_imports import ROOT

NASTY = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&{{7*7}}{% raw %}{#"
PLAIN = NASTY.replace("{", "(").replace("}", ")")
"""The same for parts of a text with names in braces."""

ESCAPED = "&lt;script&gt;alert(1)&lt;/script&gt;&lt;img src=x onerror=alert(2)&gt;&quot;"

BOOK = our_book()
ALL_TEMPLATES = sorted(
    path.relative_to(ROOT / "app").as_posix()
    for kind in ("html", "svg")
    for path in (ROOT / "app").rglob(f"*.{kind}")
    if re.search(r"\{[%{]", path.read_text(encoding="utf-8"))
)
"""Templates, as paths below `app/`."""

ELSEWHERE = tuple(
    f"features/{path.parent.name}/" for path in (ROOT / "tests/app/features").glob("*/test_*_templates.py")
)
"""Folders of features that test their own templates."""

TEMPLATES = [name for name in ALL_TEMPLATES if not name.startswith(ELSEWHERE)]


@cache
def nasty_lesson() -> Lesson:
    """A lesson with a question, a drawing or a challenge and with dangerous text everywhere."""
    lesson = next(one for one in BOOK.lessons if any(step.drawing for step in one.steps))
    return replace(
        lesson,
        title=NASTY,
        goal=NASTY,
        promise=NASTY,
        learned=NASTY,
        steps=tuple(map(nasty_step, lesson.steps)),
    )


def nasty_step(step: Step) -> Step:
    texts: dict[str, Any] = dict.fromkeys(("title", "goal", "do", "observe", "explain"), NASTY) | {
        "hints": (NASTY,) * 2
    }
    if step.question is not None:
        choices = tuple(Choice(NASTY, NASTY, choice.why) for choice in step.question.choices)
        texts["question"] = replace(step.question, text=NASTY, choices=choices)
    if step.challenge is not None:
        texts["challenge"] = replace(step.challenge, text=NASTY)
    # The teacher's handout runs every step.
    return replace(step, setup=replace(step.setup, seconds=0.1), **texts)


def views() -> Iterator[StepView]:
    """Every phase of every step of that lesson, with answers, reasons and attempts."""
    lesson, said = nasty_lesson(), LazyText("{words}", words=PLAIN)
    attempt = Attempt(False, (Judgement("a", False, said, 1.0), Judgement("b", True, said, 1.0)), said)
    for i, step in enumerate(lesson.steps):
        done = StepProgress(
            choice=None if step.question is None else 0,
            because=NASTY,
            hints=2,
            attempts=2,
            last=attempt,
            passed=True,
        )
        if step.challenge is not None:
            done.tries = tuple(Try(0.1 * k, 0.1, k == 1) for k in range(4))
        for phase in Phase:
            verdict = AnswerVerdict(False, NASTY, NASTY, (NASTY,))
            yield replace(
                make_view(StepPosition(lesson, step, i, Phase.DO, done, None), True, True, True),
                phase=phase,
                phases=(*Phase,),
                verdict=verdict,
                outcome=(NASTY,),
                texts=tuple(
                    (name, NASTY) for name in ("goal", "predict", "do", "observe", "explain", "challenge")
                ),
                lesson_finished=True,
            )


def panel() -> Iterator[str]:
    for view in views():
        for computing, operated in ((False, False), (False, True), (True, True)):
            yield from blocks_html(view, ((NASTY, NASTY),), computing, operated).values()
        contrast = Contrast(NASTY, (), PLAIN, PLAIN, ("a", "b"))
        yield from blocks_html(
            replace(view, contrast=contrast, why_outcome=(NASTY,)), (), False, False
        ).values()


def report() -> str:
    curves = DrawnCurves((0.5,) * COLUMNS, (), DrawingVerdict(False, NASTY))
    done = [
        replace(view, done=replace(view.done, words=NASTY), drawing=view.drawing and curves)
        for view in views()
    ]
    entries = [ReportEntry(view, NASTY, "<svg/>") for view in done]
    return report_html(NASTY, entries, Settings(), about=NASTY) + report_html(NASTY, [], None)


def player() -> str:
    own: Any = SimpleNamespace(file=PLAIN, sha256="ab" * 32)
    page = assembled(Filmed(b"", (), (0.0, 0.05)), (), RunSettings(), False, own)
    # viser's page around it has its own scripts.
    return re.sub(
        r"<(script|style).*?</\1>",
        "",
        page[page.index('<section id="duet-plots"') : page.rindex("</body>")],
        flags=re.S,
    )


def charts() -> Iterator[str]:
    chart = Chart(ChartAxes((0.0, 1.0), (0.0, 1.0), ((0.0, NASTY),), ((0.0, NASTY),)))
    chart.line(np.array([0.0, 1.0]), np.array([0.0, 1.0]), NASTY, 1.0, NASTY)
    chart.mark(0.5, 0.5, NASTY, NASTY)
    made = macros("plots/charts.html")
    yield chart.html(100)
    yield made.safety(chart.html(100), [("thick", 1, NASTY, NASTY, [NASTY])], NASTY, 0.5)
    yield made.steps("", NASTY, NASTY, NASTY, NASTY, NASTY, NASTY)
    yield made.pairs([(NASTY, NASTY, True)], 1, NASTY, NASTY)
    yield made.stability(NASTY, NASTY, NASTY, NASTY, NASTY, NASTY, NASTY, NASTY)
    yield made.caption(NASTY, NASTY, [(NASTY, NASTY, NASTY)], True, True)
    yield made.laps("", "", 100, NASTY, [NASTY])


def drawing() -> Iterator[str]:
    step = next(step for step in nasty_lesson().steps if step.drawing is not None)
    assert step.drawing is not None
    yield board_html(
        (NASTY, NASTY), replace(step.drawing, x=replace(step.drawing.x, symbol=NASTY, unit=NASTY)), ()
    )


def laws() -> Iterator[str]:
    for problem, away in (("", False), (NASTY, False), ("", True)):
        yield law_html(ExaminationProgress(NASTY), problem, away, True)
    yield law_html(ExaminationProgress(NASTY, typed=True), NASTY, False)
    yield law_html(ExaminationProgress(NASTY, message=NASTY), "", False, False)


def league() -> str:
    entrants = [Entrant(DEFAULT_LAW), Entrant(NASTY, b"")]
    outcomes = [
        Played(NASTY, entrants[1].sha256, event, Outcome(None, None, (), None, NASTY)) for event in events()
    ]
    tables = league_tables(entrants, outcomes, QUICK)
    return league_page(entrants, outcomes, tables, QUICK, {"Duet": NASTY})


def feedback() -> str:
    curve = TrialCurve("d", 1.0, 0.1, {NASTY: [0.1, None, 0.2]})
    remarks = [Remark(NASTY, None, NASTY), Remark(NASTY, False, NASTY, 0.0, 1.0, NASTY, curve)]
    student = Student(NASTY, NASTY)
    files = (
        GradedFile(NASTY, "law", student, remarks=remarks),
        GradedFile(NASTY, "report", student, reason=NASTY),
    )
    return feedback_page(StudentMarks(student, files))


def before_and_after() -> Iterator[str]:
    asked = [
        replace(step, belief=NASTY, asked="first")
        for step in nasty_lesson().steps
        if step.question is not None
    ]
    lesson = replace(nasty_lesson(), steps=tuple(asked))
    found = gains({(lesson.id, step.id): ((0, 1), (1, 1)) for step in asked}, [lesson])
    for alone in (False, True):
        yield macros("features/lab_report/gain.html").table(found, whole(found), alone)


MACROS: dict[str, list[tuple[str, tuple[Any, ...]]]] = {
    "features/second_person/guest.html": [("waiting", (NASTY,))],
    "features/lessons/panel/duel.html": [
        *(("score", ([(margin, NASTY)] * 2, 2, 0)) for margin in (0.001, -0.001)),
        *(("record", (margin, NASTY)) for margin in (0.001, -0.001)),
    ],
    "features/lessons/panel/lesson_list.html": [
        ("lessons", ([LessonEntry(nasty_lesson(), (True, False), True, 0)], {}))
    ],
    "features/lessons/panel/search_plot.html": [
        ("plot", (NASTY, NASTY, [(NASTY, NASTY)], [(1.0, 1.0, False)], [(NASTY, 1.0, 1.0, NASTY)]))
    ],
    "features/studies/compare.html": [("what_if", (NASTY, [(NASTY, NASTY, NASTY)], NASTY))],
    "page/panels/copy.html": [("link", (NASTY, True, NASTY)), ("snippet", (NASTY,))],
    "page/panels/help.html": [
        (
            "help",
            (
                [SimpleNamespace(shown=NASTY, text=NASTY)],
                (),
                [SimpleNamespace(first=NASTY, last=NASTY, text=NASTY)],
                [(NASTY, NASTY)],
                NASTY,
                NASTY,
            ),
        )
    ],
    "features/second_person/invite.html": [("place", (NASTY, NASTY, ""))],
    "features/custom_law/law_editor.html": [("place", (NASTY,))],
    "features/formula_law/formula.html": [("place", ((NASTY, NASTY), NASTY, NASTY, NASTY))],
    "features/lessons/panel/notes.html": [
        ("notes", (read_notes(f"# {NASTY}\n\n{NASTY}\n\n## 1. {NASTY}\n\n{NASTY}"), 1, None))
    ],
    "page/panels/readout.html": [("error", (NASTY, NASTY))],
    "text/equation.html": [("of_file", (NASTY,))],
}
"""Template → its macros with the most dangerous text of a name, a file or a lesson."""


Macros = dict[str, list[tuple[str, tuple[Any, ...]]]]
Surfaces = dict[str, Callable[[], str | Iterator[str]]]


def filled(given: Macros) -> Surfaces:
    def pieces(name: str) -> Iterator[str]:
        yield from (getattr(macros(name), macro)(*worst) for macro, worst in given[name])

    return {name: partial(pieces, name) for name in given}


SURFACES: Surfaces = {
    **filled(MACROS),
    "features/lab_report/gain.html": before_and_after,
    "features/handout/handout.html": lambda: iter(
        (handout_html(nasty_lesson()), handout_html(nasty_lesson(), f"# {NASTY}\n\n{NASTY}"))
    ),
    **dict.fromkeys(
        (
            "features/lab_report/page.html",
            "features/lab_report/report.html",
            "features/lab_report/report_entry.html",
        ),
        report,
    ),
    "features/exports/player.html": player,
    "features/league/league.html": league,
    "features/marks/feedback.html": feedback,
    "features/custom_law/law_tests.html": laws,
    "features/lessons/panel/lesson.html": panel,
    "page/panels/pills.html": lambda: iter(
        (late_law_html(LateLawStatus(NASTY)), late_law_html(LateLawStatus("a.py", problem=NASTY)))
    ),
    "page/panels/style.html": lambda: re.sub(
        "</?style>", "", macros("page/panels/style.html").sheet(*[NASTY] * 5, [], [])
    ),
    "page/panels/title_bar.svg": lambda: page_of_template(
        "page/panels/title_bar.svg", ink=NASTY, motto=NASTY, brand=NASTY, faint=NASTY
    ),
    "features/lessons/panel/welcome.html": lambda: re.sub(
        "<style>.*?</style>", "", macros("features/lessons/panel/welcome.html").card(NASTY, NASTY)
    ),
    "plots/charts.html": charts,
    **dict.fromkeys(("page/panels/drawing_board.html", "plots/curve_chart.html"), drawing),
    "text/document.html": lambda: document_html(NASTY),
}
"""Template → pages and parts made from it with such text."""


def test_every_template_is_tested() -> None:
    assert sorted(SURFACES) == TEMPLATES


@pytest.mark.parametrize("name", SURFACES)
def test_nothing_that_a_person_wrote_acts_on_a_page(name: str) -> None:
    assert_harmless(SURFACES[name])


def assert_harmless(make: Callable[[], str | Iterator[str]]) -> None:
    """Checks that nothing acts on a page and that the dangerous text appears as plain text."""
    made = make()
    pieces = [made] if isinstance(made, str) else list(made)
    page = re.sub(r"<style>.*?</style>|<!doctype html>", "", "".join(pieces), flags=re.S | re.I)
    read = HtmlReader(re.sub(r"<(meta|input)\b[^>]*>", "", page))
    assert not read.tags & {"script", "img"} and "onerror" not in re.sub(
        r'"[^"]*"', "", "".join(re.findall("<[a-z][^>]*>", page))
    )
    assert "{{7*7}}{% raw %}{#" in page or "((7*7))(% raw %)(#" in page
    # Positive control: the text is there, as plain text.
    shown = page.replace("&#34;", "&quot;").replace("&#39;", "'")
    assert ESCAPED in shown


def test_no_template_disables_escaping_or_computes() -> None:
    for name in ALL_TEMPLATES:
        source = (ROOT / "app" / name).read_text(encoding="utf-8")
        assert not re.search(r"\|\s*safe\b|autoescape|\{%-?\s*(do|include)\b|namespace\(", source), name


def test_a_missing_value_is_an_error() -> None:
    with pytest.raises(UndefinedError):
        page_of_template("text/document.html", name="model")


def test_only_line_breaks_of_a_template_are_removed() -> None:
    assert (
        macros("features/lessons/panel/lesson.html").mark("✓", "a\n b")
        == '<p class="mark"><span>✓</span> <b>a\n b</b></p>'
    )
    assert tr_html("this run: {what}", what="<b>") == "this run: &lt;b&gt;" and tr(
        "this run: {what}", what="<b>"
    ) != tr_html("this run: {what}", what="<b>")
    assert lowered("d_m < d_0") == "d<sub>m</sub> &lt; d<sub>0</sub>"
    assert lowered("beside `J_d < 2`, J_d") == "beside <code>J_d &lt; 2</code>, J<sub>d</sub>"
    assert element("i", "<", class_='"') == '<i class="&#34;">&lt;</i>'


def test_the_pages_are_complete() -> None:
    page = document_page("changes").decode()
    assert page.startswith("<!doctype html><html") and page.endswith("</html>")
    assert "<svg" in equation_html(RunSettings()) and titlebar()["image"]
