"""The last challenge in a real browser: a custom law is broken, repaired, tested, and passes."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page

from app.features.custom_law import examination
from app.features.custom_law.arena import TrialResult
from app.features.custom_law.command_options import CustomLawOptions
from app.features.custom_law.commands import NewLaw, new_law
from app.features.custom_law.trials import TRIALS
from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Press
from app.features.lessons.session.lesson_session import LessonSession
from app.hosting.visitor import Visitor
from app.start import App
from scenes.laws import DEFAULT_LAW
from tests.app.conftest import OpenHouse, ask, private_of, visitor_of
from tests.app.features.lessons.helpers import lessons_of, unfold_controls
from tests.app.inline import Inline
from tests.browser import PageAt, close_software_note, screenshot, until

pytestmark = pytest.mark.thorough

MISTAKE = "def law(situation):\n    return situation.{name}\n"


def mended(path: Path, text: bytes, name: str) -> TrialResult:
    """Fast replacement for a slow test: passes if the law is damped as required."""
    return TrialResult(name, b"MU = 0.06 " in text, f"{name} is named")


FORGET = """() => {
  const KEY = "duet-law my_law.py", set = Storage.prototype.setItem;
  Storage.prototype.setItem = function (key, value) { if (key !== KEY) set.call(this, key, value); };
  sessionStorage.removeItem(KEY);
}"""
"""Script: remove the editor's unsaved text from the browser, and prevent storing it before the reload."""


@dataclass(frozen=True)
class Desk:
    """A visitor at the challenge with the editor. `template`: the file's initial law."""

    page: Page
    opened: App
    jobs: Inline
    path: Path
    template: str

    @property
    def visitor(self) -> Visitor:
        return visitor_of(self.opened)

    @property
    def lessons(self) -> LessonSession:
        return lessons_of(self.visitor)

    @property
    def area(self) -> Locator:
        return self.page.locator(".duet-law textarea")

    @property
    def fault(self) -> Locator:
        return self.page.locator(".duet-law .fault")

    @property
    def lamps(self) -> Locator:
        return self.page.locator(".duet-law .lamps .ok")

    @property
    def damped(self) -> str:
        return self.template.replace("MU = 0.01 ", "MU = 0.06 ")

    def another_editor_saves(self, text: str) -> None:
        self.path.write_text(text, encoding="utf-8")

    def saved(self) -> str:
        return self.path.read_text(encoding="utf-8")

    def sha256(self) -> str:
        return sha256(self.path.read_bytes()).hexdigest()

    def page_knows_the_file(self) -> None:
        """Wait until the editor has received the file's present text."""

        def known() -> bool:
            told = self.page.locator(".duet-law-state[data-text]").first.get_attribute("data-text")
            return json.loads(told or "{}").get("sha") == self.sha256()

        until(self.page, known, "the page knows the file")

    def replace_text(self, text: str) -> None:
        """Replace the editor's text, by keys."""
        self.area.focus()
        self.page.keyboard.press("Control+a")
        self.page.keyboard.insert_text(text)

    def save_and_test(self, text: str) -> None:
        """Enter and save a text, and complete the tests that saving starts."""
        earlier = len(self.jobs.jobs)
        self.replace_text(text)
        self.page.keyboard.press("Control+Enter")
        until(self.page, lambda: self.saved() == text, "the text in the file")

        def all_tested() -> bool:
            # Neither six lamps nor finished jobs of a text before count.
            for kind in TRIALS:
                self.jobs.work(kind)
            states = [job.state for job in self.jobs.jobs[earlier:] if job.kind in TRIALS]
            return states == ["done"] * len(TRIALS)

        until(self.page, all_tested, "the tests of what was saved")
        until(self.page, lambda: self.lamps.count() == len(TRIALS), "six green lamps")

    def to_challenge(self) -> None:
        run = self.lessons
        while run.walk.phase is not Phase.CHALLENGE:
            before = run.walk.phase
            self.page.keyboard.press("n")
            until(self.page, lambda before=before: run.walk.phase is not before, "the next part")


@pytest.fixture(scope="module")
def shared_desk(
    lasting_house: OpenHouse, lasting_page_at: PageAt, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Desk]:
    path, jobs = tmp_path_factory.mktemp("law") / "my_law.py", Inline()
    assert new_law(NewLaw(path)) == 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(examination, "examine_one", mended)
        opened = lasting_house(features=(CustomLawOptions(path, edit_law=True),), jobs=jobs)
        page = lasting_page_at(1100, 700)
        page.goto(f"{opened.url}/?lesson=10&step=5")
        page.locator(".duet-l-head").wait_for()
        page.get_by_role("button", name="Leave the lessons").wait_for()
        yield Desk(page, opened, jobs, path, path.read_text(encoding="utf-8"))


@pytest.fixture
def desk(shared_desk: Desk) -> Desk:
    """Visitor at the untried challenge; file and editor have the template's law."""
    desk, page = shared_desk, shared_desk.page
    desk.another_editor_saves(desk.template)
    page.evaluate(FORGET)
    page.reload()
    page.locator(".duet-l-head").wait_for()
    close_software_note(page)
    until(page, lambda: len(private_of(desk.opened).visitors) == 1, "the visitor who came again")
    ask(desk.visitor.session, lambda _: desk.lessons.act(Press("reset")))
    desk.to_challenge()
    until(page, lambda: desk.area.count() == 1 and desk.area.input_value() == desk.template, "the template")
    return desk


def test_a_mistake_is_named_with_its_line_while_the_run_continues(desk: Desk) -> None:
    page, session = desk.page, desk.visitor.session
    page.get_by_role("button", name="Run", exact=True).click()
    desk.another_editor_saves(MISTAKE.format(name="gone"))
    said = re.compile(r"my_law\.py, line 2: AttributeError")
    page.locator(".card.wrong.law .what", has_text=said).wait_for()
    until(page, lambda: "line 2" in (page.locator("#duet-say").text_content() or ""), "announced")
    time = ask(session, lambda s: s.simulation.time)
    until(page, lambda: session.paused or session.simulation.time > time, "the clock")
    # An untouched editor follows the file; the line stays marked until the text changes.
    until(page, lambda: "line 2: AttributeError" in desk.fault.inner_text(), "the mark")
    assert desk.area.input_value() == desk.saved()
    lines, mark = page.locator(".duet-law pre").bounding_box(), page.locator(".duet-law .mark").bounding_box()
    assert lines is not None and mark is not None and 15.0 < mark["y"] - lines["y"] < 30.0
    desk.area.focus()
    page.keyboard.type("#")
    assert not desk.fault.is_visible()
    # The message disappears when the file is correct again.
    desk.another_editor_saves(desk.template)
    page.locator(".card.right.law", has_text="my_law.py runs.").wait_for()


def test_tab_and_a_new_line_indent(desk: Desk) -> None:
    keyboard = desk.page.keyboard
    desk.area.focus()
    keyboard.press("Control+End")
    keyboard.type("def other(x):\nif x:\nreturn 1")
    keyboard.press("Shift+Tab")
    keyboard.press("End")
    keyboard.press("Tab")
    assert desk.area.input_value().endswith("def other(x):\n    if x:\n    return 1    ")


def test_another_editors_text_can_be_taken_and_undone(desk: Desk) -> None:
    page = desk.page
    desk.another_editor_saves(MISTAKE.format(name="gone"))
    until(page, lambda: "'gone'" in (desk.fault.text_content() or ""), "the file's text")
    desk.replace_text(desk.damped)
    desk.another_editor_saves(MISTAKE.format(name="lost"))
    page.keyboard.press("Control+Enter")
    page.get_by_role("button", name="Save mine over it").wait_for()
    assert "lost" in desk.saved() and desk.area.input_value() == desk.damped
    page.get_by_role("button", name="Take the file’s text").click()
    # The new text's problem, not the previous one at the same line.
    until(page, lambda: "'lost'" in (desk.fault.text_content() or ""), "the other text")
    desk.area.focus()
    page.keyboard.press("Control+z")
    assert desk.area.input_value() == desk.damped
    page.keyboard.press("Control+Enter")
    until(page, lambda: desk.saved() == desk.damped, "the text in the file")


def test_a_saved_law_is_tested_and_runs_with_the_papers_law_as_ghost(desk: Desk) -> None:
    page, session = desk.page, desk.visitor.session
    desk.save_and_test(desk.damped)
    page.locator(".card.right.law", has_text="my_law.py runs.").wait_for()
    until(page, lambda: session.settings.page.ghost == DEFAULT_LAW, "the ghost")
    page.keyboard.press("Escape")
    desk.area.blur()
    unfold_controls(page)
    page.get_by_text(f"my_law.py, SHA-256 {desk.sha256()[:12]}…").wait_for(state="attached")


def test_results_are_marked_when_another_editor_changes_the_file(desk: Desk) -> None:
    desk.save_and_test(desk.damped)
    desk.another_editor_saves(desk.template)
    results = desk.page.locator(".card.stale.law")
    results.get_by_text("The file was changed since; test it again.").wait_for()
    until(desk.page, lambda: desk.lamps.count() == 0, "no lamps over another text")
    screenshot(desk.page, "stale-results")


def test_six_tests_finish_one_by_one_and_pass_the_challenge(desk: Desk) -> None:
    page, run = desk.page, desk.lessons
    before = run.walk.done.attempts
    desk.save_and_test(desk.damped)
    # The tests after saving also count as an attempt, a moment after the lamps are green.
    until(page, lambda: run.walk.done.attempts == before + 1, "the first examination")
    attempts = run.walk.done.attempts
    page.keyboard.press("Escape")
    desk.area.blur()
    page.keyboard.press("c")
    tests = page.locator(".duet-l-attempt [role=status] .tests li")
    page.locator(".tests li.now em", has_text="being tested").first.wait_for()
    page.get_by_role("button", name="Testing …").wait_for()
    passed = tests.locator("em", has_text="passed")
    for number, name in enumerate(TRIALS, 1):
        assert desk.jobs.work(name) == [name]
        until(page, lambda number=number: passed.count() == number, f"{name} passed")
    until(page, lambda: run.walk.done.attempts > attempts, "the second examination")
    page.get_by_text("6 of 6 tests passed.").first.wait_for()
    assert [tests.nth(i).locator("em").inner_text() for i in range(tests.count())] == ["passed"] * len(TRIALS)
    assert all("is named" in tests.nth(i).inner_text() for i in range(len(TRIALS)))
    until(page, lambda: desk.lamps.count() == len(TRIALS), "six green lamps")
    page.get_by_text("Challenge passed.").first.wait_for()
    page.get_by_role("button", name="Test my law").wait_for()
    assert run.walk.done.passed and run.walk.done.attempts == attempts + 1, "each examination counts once"


def test_an_unsaved_text_survives_a_reload_without_overwriting_the_file(desk: Desk) -> None:
    page = desk.page
    desk.area.focus()
    page.keyboard.press("Control+End")
    page.keyboard.type("# mine")
    desk.another_editor_saves(desk.damped)
    desk.page_knows_the_file()
    page.keyboard.press("Control+Enter")
    page.get_by_role("button", name="Save mine over it").wait_for()
    assert desk.saved() == desk.damped
    page.reload()
    desk.area.wait_for()
    until(page, lambda: desk.area.input_value() == f"{desk.template}# mine", "the text that is not saved")
