"""The lab report: complete, with the student's run, without active content, and printable."""

import pickle
import re
from dataclasses import replace
from pathlib import Path
from unittest.mock import MagicMock

import pytest

from app.features.exports.export_queue import ExportQueue
from app.features.exports.exports_panel import ExportsPanel
from app.features.exports.plot_pictures import inline_svg
from app.features.lab_report.lab_report import (
    Done,
    ReportEntry,
    done_in,
    lab_bytes,
    recorded_of,
    report_html,
    report_title,
    rich_html,
    step_entry,
)
from app.features.lab_report.lab_report_box import LabReportBox, ask_report
from app.features.lab_report.report_html import LOCKED
from app.features.lessons.bookmark import Phase
from app.features.lessons.panel.lesson_panel import LessonPanel
from app.features.lessons.panel.lesson_visit import open_link
from app.features.lessons.progress import LONGEST_REASON, MOST_WORDS, StepProgress
from app.features.lessons.reference_runs import simulated
from app.features.lessons.session.lesson_actions import Choose, Draw, Press
from app.features.lessons.session.lesson_session import LessonSession
from app.features.store.session_store import SessionStore
from app.hosting.visitor_record import VisitorRecord
from app.i18n.speaking import set_language
from app.page.panel_context import PanelContext
from app.page.panels.replay_bar import ReplayBar
from app.plots.curve_chart import COLUMNS
from app.session.action_handlers import ActionHandlers
from app.session.frame import freeze
from app.session.replay_player import ReplayPlayer
from app.session.session import Session
from app.settings import LANGUAGES, Language, Settings
from scenes.rerun import rerun
from tests.app.features.lessons.helpers import lessons_in, much_done, our_book
from tests.app.features.lessons.test_languages import attempts
from tests.app.features.said import without_numbers
from tests.app.html_reader import HtmlReader
from tests.app.inline import Inline
from tests.app.recording.runs import piece
from tests.app.stores import find
from tests.approved import Approve, shown_text
from tests.browser import PageAt, screenshot
from tests.scenes.helpers import given_settings

BOOK = our_book()
NASTY = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&"
SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><path d="M0 0h1"/></svg>'


def entry(own: str = "", right: bool = True) -> ReportEntry:
    return step_entry(Done(*much_done(own, right)))


def full(text: str) -> str:
    return report_html(text, [replace(entry(text), settings="n = 2", plot=SVG)], Settings(), about=text)


def test_a_hostile_text_is_shown_as_written() -> None:
    assert HtmlReader(full(NASTY)).text.count(NASTY) == 5
    assert LOCKED in full(NASTY)


def body_text(page: str) -> str:
    """Visible text of a report, without date and release number."""
    text = re.sub(r"\d{4}-\d\d-\d\d", "DATE", shown_text(page.partition("</style>")[2]))
    return re.sub(r"Duet \d+[\w.+]*", "Duet VERSION", text)


@pytest.mark.parametrize("language", LANGUAGES)
def test_all_work_is_in_the_report(language: Language, approve: Approve) -> None:
    set_language(language)
    run = Settings(run=given_settings(dm=0.2))
    done = [replace(entry("I thought so."), settings="n = 2"), entry(right=False)]
    approve(f"report {language}.txt", body_text(report_html("My report", done, run)))
    assert "<table" not in report_html("r", [entry()], None)


def test_empty_parts_and_settings_without_effect_are_left_out() -> None:
    lesson = BOOK.lessons[BOOK.index("limits")]
    index = next(i for i, step in enumerate(lesson.steps) if step.question is None and step.challenge is None)
    page = report_html("r", [step_entry(Done(lesson, index, StepProgress()))], None)
    assert "<dt>" not in page and "<table" not in page and "<figure" not in page
    text = report_html("r", [], Settings(run=given_settings(law="potential_field")))
    assert "<td>η</td>" in text and "<td>d<sub>m</sub></td>" not in text
    assert "<td>d<sub>m</sub></td><td>150\N{NO-BREAK SPACE}mm</td>" in report_html("r", [], Settings())


def test_only_the_lessons_formulas_are_drawn_not_a_students() -> None:
    one = entry("me $x$")
    page = report_html(
        "r $x$",
        [replace(one, view=replace(one.view, texts=(("predict", "why $x$"),)))],
        None,
        about="who $x$",
    )
    assert "why <svg" in page and "why $x$" not in page and page.count("me $x$") == 2 and "who $x$" in page


HEAD = '<svg xmlns="http://www.w3.org/2000/svg"'


def test_pictures_with_active_content_are_refused() -> None:
    active = (f"{HEAD}><script>1</script></svg>", f'{HEAD} onload="1"/>', f"{HEAD}><foreignObject/></svg>")
    for svg in ("no picture", "<p>x</p>", *active, f"{SVG}<b>x</b>"):
        with pytest.raises(ValueError, match="a plot is no"):
            report_html("r", [replace(entry(), plot=svg)], None)


def test_the_report_prints_with_reason_and_outcome_side_by_side(page_at: PageAt, tmp_path: Path) -> None:
    recorded, _ = piece("hold", 3.0)
    plots = [
        inline_svg(recorded, "p1", only=("lambda",)),
        inline_svg(recorded, "p2", only=("speeds",)),
        *[""] * 4,
    ]
    entries = [replace(entry("word " * 40, i % 2 == 0), plot=plot) for i, plot in enumerate(plots)]
    path = tmp_path / "report.html"
    path.write_text(report_html("Lab report", entries, Settings(), about=NASTY), encoding="utf-8")
    page = page_at(820, 1000)
    page.goto(path.as_uri())
    overflows = page.evaluate("document.documentElement.scrollWidth > innerWidth")
    assert not overflows
    assert page.locator("figure:not(.drawing) svg").count() == 2 and page.locator("article").count() == 6
    reason, outcome = (page.locator(".beside > div").nth(i).bounding_box() for i in (0, 1))
    assert reason is not None and outcome is not None
    assert reason["x"] + reason["width"] <= outcome["x"] and reason["y"] == outcome["y"]
    screenshot(page, "report")
    printed = page.pdf(prefer_css_page_size=True)
    assert 2 <= len(re.findall(rb"/Type /Page\b", printed)) <= 7


@pytest.fixture(scope="module")
def run() -> LessonSession:
    """Lesson 1 after a complete first step with a wrong answer. Tests must not change it."""
    run = LessonSession(Session(Settings()), BOOK)
    run.enter(0)
    run.act(Choose(3))
    run.runner.further.result(60.0)
    run.act(Press("run"))
    while run.walk.phase is Phase.DO:
        run.session.advance(0.05)
        run.decide()
    run.walk.write(f"I did not expect that.\n{NASTY}")
    run.walk.give_reason(f"no joint is locked {NASTY}", "redundancy", "freedom")
    return run


def steps_of(run: LessonSession, only: str | None = None) -> tuple[Done, ...]:
    return done_in(run.book.lessons, run.walk.done_in, run.seen, only)


def made(done: tuple[Done, ...]) -> str:
    return lab_bytes(done, "en").decode()


def test_prediction_outcome_plots_settings_and_own_words(run: LessonSession, approve: Approve) -> None:
    (done,) = steps_of(run)
    page = made((done,))
    question = done.step.question
    assert question is not None and done.progress.outcome is not None and not done.progress.outcome.reference
    assert [
        line for line in done.progress.outcome.lines(done.step, "en") if line not in HtmlReader(page).text
    ] == []
    drawn = re.compile("<figure.*?</figure>", re.DOTALL)
    approve("report of a run.txt", without_numbers(body_text(drawn.sub("", page))))
    assert page.count("<figure>") == 1 and "hand error" in page and "elbow angle" in page
    assert "because" not in made((replace(done, progress=replace(done.progress, because="")),)).casefold()
    reason, _, measured = page.partition('<div class="beside"><div><b>')[2].partition("<b>")
    assert "<script" not in reason and measured, "reason and outcome are side by side"
    assert LOCKED in page and NASTY not in page and not re.search(r"""(src|href)=["']?(https?:)?//""", page)


def test_the_report_has_the_students_run_or_an_identical_new_one(run: LessonSession) -> None:
    (done,) = steps_of(run)
    assert done.seen is not None
    again = recorded_of(done.step.setup)
    assert again is not None
    table = rerun(again).table
    assert table.tobytes() == simulated(done.step.setup).history.table(len(table)).tobytes()
    assert rerun(done.seen).table[: len(table)].tobytes() == table.tobytes()
    assert made((replace(done, seen=None),)).count("<figure>") == 1
    # A run with the student's hand cannot be repeated; without a seen run there is no figure.
    yours = next(i for i, step in enumerate(done.lesson.steps) if step.yours)
    progress = replace(done.progress, choice=None, outcome=None)
    assert made((Done(done.lesson, yours, progress),)).count("<figure>") == 0


def test_a_drawn_curve_is_shown_with_the_true_one() -> None:
    run = LessonSession(Session(Settings()), BOOK)
    run.enter("lambda", 1)
    run.act(Draw("lambda", "tail", (1.0,) * COLUMNS))
    assert run.walk.done.untouched, "the curve is for another step"
    run.act(Draw("lambda", "curve", (1.0,) * COLUMNS))
    page = made(steps_of(run))
    assert "<dt>Drawn</dt>" in page and "your curve" not in page and "by the formula" not in page
    run.walk.next()
    run.walk.next()
    page = made(steps_of(run))
    assert "your curve" in page and "by the formula" in page and "0.76" in page


def test_only_worked_steps_are_in_the_report(run: LessonSession) -> None:
    assert [(one.lesson.number, one.index) for one in steps_of(run)] == [(1, 0)]
    assert steps_of(run, BOOK.lessons[1].id) == () and len(steps_of(run, BOOK.lessons[0].id)) == 1
    assert not LessonSession(Session(Settings()), BOOK).begun and run.begun
    both = (*steps_of(run), Done(BOOK.lessons[1], 0, steps_of(run)[0].progress))
    assert report_title(both) == "Lab report"


def test_formulas_are_drawn_and_paragraphs_kept() -> None:
    assert "<svg" in rich_html(r"speed $\lambda v$") and "<p>" not in rich_html("one line")
    html = "2 d<sub>m</sub> &lt; J<sub>d</sub>"
    assert rich_html("2 d_m < J_d") == html and rich_html("my_law.py") == "my_law.py"
    assert rich_html("a\n\nb").split() == ["<p>a</p>", "<p>b</p>"] and "<svg" in rich_html("$$x$$")


def test_the_report_file_is_made_in_the_background(run: LessonSession) -> None:
    background = Inline()
    queue = ExportQueue(run.session, ReplayPlayer(run.session, background, run.session.wake))
    ask_report(queue, run.session, ())
    assert len(run.session.notices) == 1 and not background.waiting()
    ask_report(queue, run.session, steps_of(run))
    assert queue.busy == "the lab report"
    (job,) = background.waiting()
    # The job goes to another process, with the text written so far.
    pickle.loads(pickle.dumps(job.arguments))
    before = run.walk.done.words
    run.walk.write("later")
    background.work()
    run.walk.write(before)
    queue.player.advance(0.0)
    ((name, content),) = queue.take_files()
    assert (
        name == "duet-lab-report-lesson-1.html" and b"I did not expect" in content and b"later" not in content
    )


def test_words_survive_a_reload_and_a_reset(run: LessonSession) -> None:
    store, query = SessionStore(), {"resume": "0123456789abcdef"}
    store.save(VisitorRecord(query, Settings(), None, {run.name: run.saved()}, run.recordings()))
    record, other = find(store, query), Session(Settings())
    assert record is not None
    other.parts.restore(record.parts, record.recordings)
    back = lessons_in(other, BOOK)
    assert open_link(back, query, record) == ()
    assert back.walk.done.words == run.walk.done.words and back.seen == run.seen
    assert back.walk.done.because == run.walk.done.because != ""
    back.act(Press("reset"))
    assert (
        back.walk.done.words == run.walk.done.words
        and back.walk.done.choice is None
        and not back.walk.done.because
    )
    back.walk.give_reason("y" * (LONGEST_REASON + 1), BOOK.lessons[2].id, BOOK.lessons[2].steps[0].id)
    assert len(back.walk.done_in(BOOK.lessons[2].id, BOOK.lessons[2].steps[0].id).because) == LONGEST_REASON
    back.walk.write("x" * (MOST_WORDS + 1), BOOK.lessons[2].id, BOOK.lessons[2].steps[0].id)
    assert len(back.walk.done_in(BOOK.lessons[2].id, BOOK.lessons[2].steps[0].id).words) == MOST_WORDS


def test_the_box_for_words_is_hidden_while_the_list_of_lessons_is_shown() -> None:
    session, client = Session(Settings()), MagicMock()
    run = LessonSession(session, BOOK)
    run.enter(0)
    while run.walk.phase is not run.walk.phases[-1]:
        if run.walk.locked:
            run.walk.choose(0)
        assert run.walk.next()
    panel, frame = LessonPanel(MagicMock(), run, 340.0, True), freeze(session, 0.0)
    panel.show(frame)
    page = PanelContext(
        client,
        session,
        MagicMock(part=lambda _: MagicMock(lessons=run, panel=panel)),
        ActionHandlers(),
        MagicMock(),
        MagicMock(),
        MagicMock(),
        True,
    )
    page.made.append(ReplayBar(MagicMock(), session, page.handlers))
    page.made.append(ExportsPanel(page))
    report = LabReportBox(page)
    report.show(frame)
    box = client.gui.add_text.return_value
    assert box.visible is True
    run.act(Press("list"))
    report.show(frame)
    assert box.visible is False


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_report_has_the_results_of_the_tests_of_a_law(language: Language, approve: Approve) -> None:
    book = our_book(language)
    lesson = book.lessons[book.index("limits")]
    step = next(place for place, one in enumerate(lesson.steps) if one.id == "own_law")
    (attempt,) = [made for made in attempts(lesson.steps[step]) if made.judgements]
    page = lab_bytes([Done(lesson, step, StepProgress(attempts=1, last=attempt))], language).decode()
    approve(f"report of tests {language}.txt", without_numbers(body_text(page)))
