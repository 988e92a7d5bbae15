"""A teacher and two students (one on a phone) in a real browser: answers, reveal, exploring and return."""

import csv
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page

from app.features.lecture.lecture import LectureHost
from app.features.lecture.teacher_panel import TeacherPanel
from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import GoTo
from app.settings import Settings
from app.start import App
from scenes.settings import changed
from tests.accessibility import accessible
from tests.app.conftest import HAND, OpenHouse, ask
from tests.app.features.lecture.lecture_room import lecture_of, sessions_of
from tests.app.page.by_hand import WRIST, control
from tests.browser import PageAt, close_software_note, until, wait_frames, wait_ready, world_position

WAIT = 60.0


def come(page: Page, address: str) -> None:
    page.set_default_timeout(WAIT * 1000.0)
    page.goto(address)
    page.locator(".duet-l-head").wait_for()
    close_software_note(page)


def on_stage(page: Page, key: str) -> None:
    """Press a key while no widget has the focus."""
    page.locator("body").click(position={"x": 400, "y": 60})
    page.keyboard.press(key)


def edge(page: Page, selector: str, side: str) -> float:
    """Position of this side of an element [CSS px]."""
    return float(page.locator(selector).last.evaluate(f"element => element.getBoundingClientRect().{side}"))


def in_view(page: Page, selector: str) -> bool:
    """True if the whole element is in the window."""
    return (
        edge(page, selector, "top") >= 0.0
        and edge(page, selector, "bottom") <= page.evaluate("innerHeight") + 1.0
    )


def taken(page: Page, kind: str) -> bytes:
    """Downloaded file of the teacher's page."""
    with page.expect_download() as download:
        page.get_by_role("button", name=kind, exact=True).click()
    return Path(download.value.path()).read_bytes()


@pytest.mark.thorough
def test_a_teacher_and_two_students(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(changed(Settings(), "picture", "fast"), lecture=True, key="chalk")
    host = lecture_of(opened)
    # Ann has a desktop window, Bo a phone.
    teacher, ann, bo = page_at(1440, 900), page_at(640, 420), page_at(390, 844)
    come(teacher, f"{opened.url}/?key=chalk&lesson=1")
    # The key disappears from the address but is still known after a reload.
    assert "chalk" not in teacher.url and "lesson=1" in teacher.url
    before = host.controls.operator
    teacher.reload()
    until(teacher, lambda: host.controls.operator not in (None, before), "the teacher again", WAIT)
    teacher.locator(".duet-l-head").wait_for()
    close_software_note(teacher)
    come(ann, opened.url)
    come(bo, opened.url)
    see_the_stage(host, teacher, ann)
    ann = answer(opened, teacher, ann, bo)
    answer_again(teacher, ann, bo)
    hand_in(teacher, ann)
    invite(host, teacher, ann, bo)
    draw(host, teacher, ann, bo)
    open_a_second_tab(opened, teacher, ann)
    bo.close()
    explore(host, teacher, ann)
    look_at_the_plots(host, teacher)


def see_the_stage(host: LectureHost, teacher: Page, ann: Page) -> None:
    """The 3-D view is the same for all pages, and only the teacher operates it."""
    session = host.session
    arm, place = ask(
        session, lambda s: (s.simulation.room.arms[0].name, s.simulation.kinematics.joint_point(7).copy())
    )
    wrist = f"/arms/{arm}{WRIST}"
    for page in (teacher, ann):
        wait_ready(page, wrist)
        until(
            page, lambda p=page: np.allclose(world_position(p, wrist), place, atol=1e-3), "the same arm", WAIT
        )
    operated = (
        control(ann, "dm"),
        ann.get_by_role("tab", name="Arms"),
        ann.get_by_role("button", name="Pause"),
    )
    assert [one.count() for one in operated] == [0, 0, 0]
    assert not ann.evaluate(f"!!__viserMutable.nodeRefFromName['{HAND}']")
    before = ask(session, lambda s: (s.settings, s.paused, s.simulation.steps))
    for key in (" ", "r", ".", "l", "["):
        on_stage(ann, key)
        wait_frames(ann, 3)
    assert ask(session, lambda s: (s.settings, s.paused, s.simulation.steps)) == before


def answer(opened: App, teacher: Page, ann: Page, bo: Page) -> Page:
    """Answers by key and by click; only the teacher sees their number. Ann's new tab is returned."""
    teacher.get_by_text("0 answered · 2 not yet").wait_for()
    until(
        bo,
        lambda: in_view(bo, ".duet-l-text") and in_view(bo, "button:has-text('4 In 7')"),
        "question and answers",
        WAIT,
    )
    assert edge(bo, ".duet-banner", "top") > 150.0
    ann.get_by_role("button", name="3 In 4.").click()
    teacher.get_by_text("1 answered · 1 not yet").wait_for()
    # Ann closes the tab and opens the address again: she is the same student.
    context = ann.context
    ann.close()
    teacher.get_by_text("students here: 1").wait_for()
    ann = context.new_page()
    ann.set_viewport_size({"width": 640, "height": 420})
    come(ann, opened.url)
    ann.get_by_text("Your prediction: In 4.").first.wait_for()
    on_stage(ann, "1")
    ann.get_by_text("Your prediction: In none").first.wait_for()
    teacher.get_by_text("1 answered · 1 not yet").wait_for()
    # Another browser is another student.
    bo.get_by_role("button", name="3 In 4.").click()
    teacher.get_by_text("2 answered · 0 not yet").wait_for()
    teacher.get_by_text("addresses: 1").wait_for()
    assert not teacher.get_by_text("votes without a page").count(), "both show the page"
    until(
        bo,
        lambda: "Your prediction: In 4." in (bo.locator("#duet-say").text_content() or ""),
        "announced",
        WAIT,
    )
    assert ann.locator(".duet-poll").count() == bo.locator(".duet-poll").count() == 0
    teacher.get_by_role("button", name="Reveal to everybody").click()
    for page in (ann, bo):
        page.locator(".duet-poll").get_by_text("2 answered").wait_for()
    for page in (teacher, ann):
        accessible(page)
    until(
        bo, lambda: "Answers are closed" in (bo.locator("#duet-say").text_content() or ""), "announced", WAIT
    )
    return ann


def answer_again(teacher: Page, ann: Page, bo: Page) -> None:
    """The first round stays visible, pale, beside the second."""
    teacher.get_by_role("button", name="Ask again").click()
    for page in (ann, bo):
        page.get_by_text("Asked again: talk it over with your neighbours").first.wait_for()
    on_stage(ann, "3")
    bo.get_by_role("button", name="3 In 4.").click()
    teacher.get_by_text("Answered both times: 2, another answer the second time: 1.").wait_for()
    assert ann.locator(".duet-poll").count() == 0
    teacher.get_by_role("button", name="Reveal to everybody").click()
    third = ann.locator(".duet-poll li").nth(2)
    third.wait_for()
    bars = third.locator(".round > div > div")
    assert third.locator(".round > b").all_inner_texts() == ["1 50 %", "2 100 %"]
    width = "bar => bar.offsetWidth / bar.parentElement.clientWidth"
    until(
        ann,
        lambda: [round(bars.nth(i).evaluate(width), 1) for i in (0, 1)] == [0.5, 1.0],
        "the bars are grown",
        WAIT,
    )
    assert bars.nth(0).evaluate("bar => getComputedStyle(bar).opacity") == "0.4"
    edges = [third.locator(".round").nth(i).bounding_box() for i in (0, 1)]
    assert (
        edges[0]
        and edges[1]
        and edges[0]["x"] == edges[1]["x"]
        and edges[0]["y"] + edges[0]["height"] <= edges[1]["y"]
    )


def hand_in(teacher: Page, ann: Page) -> None:
    """Ann hands in a report, and the teacher downloads the class files."""
    ann.get_by_text("Hand in my report", exact=True).click()
    ann.get_by_label("Name", exact=True).fill("=Ann <b>")
    ann.get_by_role("button", name="Hand in", exact=True).click()
    ann.get_by_text("Handed in as =Ann <b>.", exact=True).wait_for()
    until(ann, lambda: "Handed in as" in (ann.locator("#duet-say").text_content() or ""), "announced", WAIT)
    teacher.get_by_text("reports handed in: 1").wait_for()
    table, page, reports = (taken(teacher, kind) for kind in ("CSV", "HTML", "ZIP"))
    with zipfile.ZipFile(io.BytesIO(reports)) as archive:
        assert archive.namelist() == ["001 _Ann _b_.html"] and b"=Ann &lt;b&gt;" in archive.read(
            "001 _Ann _b_.html"
        )
    rows = list(csv.DictReader(io.StringIO(table.decode("utf-8-sig"))))
    assert [[row[key] for key in ("round", "answer_1", "answer_3", "'=Ann <b>")] for row in rows] == [
        ["1", "1", "1", "1"],
        ["2", "0", "2", "3"],
    ]
    assert b"=Ann &lt;b&gt;" in page and b"Round 2: 2 answered" in page
    ann.get_by_role("button", name="Take it back").click()
    teacher.get_by_text("reports handed in: 1").wait_for(state="detached")


def invite(host: LectureHost, teacher: Page, ann: Page, bo: Page) -> None:
    """The address on every page: a student closes it on one page, the teacher (by ×) on all; a key shows it
    only on the teacher's page."""
    teacher.get_by_role("tab", name="Join", exact=True).click()
    teacher.get_by_role("button", name="On every page").click()
    over = ann.locator("#duet-overlay")
    over.get_by_role("img", name="QR code of the address").wait_for()

    def is_in_view() -> bool:
        box = over.locator("section").bounding_box()
        return box is not None and box["y"] >= 0.0 and box["y"] + box["height"] <= 420.0

    until(ann, is_in_view, "the whole address", WAIT)
    ann.keyboard.press("Escape")
    over.locator("section").wait_for(state="detached")
    bo.locator("#duet-overlay section").wait_for()
    assert host.controls.operator is not None
    panel = host.controls.operator.panel
    assert isinstance(panel, TeacherPanel)
    for away in ("×", "Escape", "PageDown", "Alt+Shift+J"):
        teacher.locator("#duet-overlay section").wait_for()
        if away == "×":
            teacher.locator("#duet-overlay").get_by_role("button", name="Close").click()
        else:
            teacher.keyboard.press(away)
        for page in (teacher, bo):
            page.locator("#duet-overlay section").wait_for(state="detached")
        # The key would hide it again until the panel shows that it is hidden.
        until(teacher, lambda: not (host.control.presenter.inviting or panel.inviting), "away for all", WAIT)
        if away != "Alt+Shift+J":
            on_stage(teacher, "Alt+Shift+J")
            assert bo.locator("#duet-overlay section").count() == 0
    teacher.get_by_role("tab", name="Class", exact=True).click()


def draw(host: LectureHost, teacher: Page, ann: Page, bo: Page) -> None:
    """Another question: on a long page the phone keeps a strip of the scene and the banner in view."""
    lesson, drawn = next(
        (i, k)
        for i, one in enumerate(host.lessons.book.lessons)
        for k, step in enumerate(one.steps)
        if one.number == 4 and step.drawing is not None
    )
    ask(host.session, lambda _: host.lessons.act(GoTo(lesson, drawn)))
    ann.locator(".duet-draw").wait_for()
    # A reload, so that the check does not depend on earlier actions on the phone.
    bo.reload()
    on_stage(ann, "2")
    ballots = host.classroom.ballots
    until(teacher, lambda: len(ballots.questions) == 2, "the second answer", WAIT)
    both, one = (ballots.rounds_of(question)[0].keys() for question in ballots.questions)
    assert len(one) == 1 and one < both, "Ann is the same student"

    def stays() -> bool:
        # Later content may push it down again.
        bo.locator(".duet-draw").evaluate("board => board.scrollIntoView({block: 'end'})")
        return in_view(bo, ".duet-draw") and 150.0 < edge(bo, ".duet-banner", "top") < 400.0

    until(bo, stays, "a strip and the banner", WAIT)
    bo.get_by_role("button", name="1 ").first.click()
    teacher.get_by_text("2 answered · 0 not yet").wait_for()
    # A reason becomes one harmless line that only the teacher reads.
    bo.get_by_label("Because …").fill("<img src=x onerror=alert(1)>  it is\u202e half " + "x" * 300)
    reason = teacher.locator(".duet-reasons li")
    until(teacher, lambda: len(reason.inner_text()) > 190, "the reason", WAIT)
    assert reason.inner_text().startswith(
        "<img src=x onerror=alert(1)> it is half x"
    ) and reason.inner_text().endswith("x answer 1")
    assert teacher.locator(".duet-reasons img").count() == ann.get_by_text("x" * 50).count() == 0


def open_a_second_tab(opened: App, teacher: Page, ann: Page) -> None:
    """Two tabs are one student: the second replaces the first, and the first is back when it is used."""
    second = ann.context.new_page()
    come(second, opened.url)
    away = "Duet is open in another tab of this browser."
    ann.get_by_text(away).wait_for()
    until(ann, lambda: len(lecture_of(opened).classroom.here) == 2, "both students", WAIT)
    ann.locator("body").click(position={"x": 400, "y": 60})
    second.get_by_text(away).wait_for()
    ann.get_by_text("You follow the teacher").first.wait_for()
    teacher.get_by_text("students here: 2").wait_for()
    second.close()


def explore(host: LectureHost, teacher: Page, ann: Page) -> None:
    """Exploring and return: the tab changes to its breakout session and back by itself."""
    teacher.get_by_role("button", name="Explore freely").click()
    ann.locator(".duet-banner.own").first.wait_for()
    ann.locator(".duet-l-head").wait_for()
    close_software_note(ann)
    on_stage(ann, "[")
    speeds = lambda: [ask(one, lambda s: s.settings.page.speed) for one in sessions_of(host).values()]  # noqa: E731
    until(ann, lambda: speeds() == [0.5], "the own session is slower", WAIT)
    assert ask(host.session, lambda s: s.settings.page.speed) == 1.0
    teacher.get_by_role("button", name="Follow me").click()
    ann.locator(".duet-banner.follow").first.wait_for()
    until(ann, lambda: not sessions_of(host), "no session of their own", WAIT)


def look_at_the_plots(host: LectureHost, teacher: Page) -> None:
    """Empty parts of a class take no column of the teacher's plots."""
    third = next(i for i, one in enumerate(host.lessons.book.lessons) if one.number == 3)
    ask(host.session, lambda _: host.lessons.act(GoTo(third, 1)))
    # While a lesson asks its question, there are no plots.
    ask(host.session, lambda _: setattr(host.lessons.walk, "phase", Phase.DO))
    captions = teacher.locator(".duet-caption")
    captions.nth(1).wait_for()

    def side_by_side() -> bool:
        widths = teacher.evaluate(
            "() => [...document.querySelectorAll('.duet-caption')].map(one => one.parentElement.clientWidth)"
        )
        panel = teacher.locator("[data-floating-window]:has(.duet-plots)").bounding_box()
        assert panel is not None
        return len(widths) == 2 and abs(widths[0] - widths[1]) <= 2 and sum(widths) > 0.9 * panel["width"]

    until(teacher, side_by_side, "two plots side by side", WAIT)
