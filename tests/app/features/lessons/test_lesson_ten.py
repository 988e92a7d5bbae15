"""The end of the lessons in a real browser: a law of one's own is broken, mended, tested, and passes."""

import re
from hashlib import sha256
from pathlib import Path

import pytest

from app.features.custom_law import examination
from app.features.custom_law.arena import TrialResult
from app.features.custom_law.command_options import CustomLawOptions
from app.features.custom_law.commands import NewLaw, new_law
from app.features.custom_law.trials import TRIALS
from app.features.lessons.bookmark import Phase
from scenes.laws import DEFAULT_LAW
from tests.app.conftest import OpenHouse, ask, visitor_of
from tests.app.features.lessons.helpers import lessons_of, unfold_controls
from tests.app.inline import Inline
from tests.browser import PageAt, close_software_note, until


def mended(path: Path, text: bytes, name: str) -> TrialResult:
    """In place of a test, which takes its time: whether the law is damped as it was asked for."""
    return TrialResult(name, b"MU = 0.06 " in text, f"{name} is named")


@pytest.mark.thorough
def test_ones_custom_law_is_broken_mended_tested_and_passes(
    house: OpenHouse, page_at: PageAt, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(examination, "examine_one", mended)
    path, desk = tmp_path / "my_law.py", Inline()
    assert new_law(NewLaw(path)) == 0
    text = path.read_text(encoding="utf-8")
    opened = house(features=(CustomLawOptions(path, edit_law=True),), jobs=desk)
    page = page_at(1100, 700)
    page.goto(f"{opened.url}/?lesson=10&step=5")
    page.locator(".duet-l-head").wait_for()
    page.get_by_role("button", name="Leave the lessons").wait_for()
    close_software_note(page)
    session, run = visitor_of(opened).session, lessons_of(visitor_of(opened))
    while run.walk.phase is not Phase.CHALLENGE:
        before = run.walk.phase
        page.keyboard.press("n")
        until(page, lambda before=before: run.walk.phase is not before, "the next part")

    # A mistake is named with its line, the clock goes on, and the message goes when the file is right again.
    page.get_by_role("button", name="Run", exact=True).click()
    path.write_text("def law(situation):\n    return situation.gone\n", encoding="utf-8")
    page.locator(
        ".card.wrong.law .what", has_text=re.compile(r"my_law\.py, line 2: AttributeError")
    ).wait_for()
    until(page, lambda: "line 2" in (page.locator("#duet-say").text_content() or ""), "announced")
    time = ask(session, lambda s: s.simulation.time)
    until(page, lambda: session.paused or session.simulation.time > time, "the clock")

    # An untouched editor follows the file; the line is marked where it stands, until the text is another one.
    area, fault = page.locator(".duet-law textarea"), page.locator(".duet-law .fault")
    until(page, lambda: "line 2: AttributeError" in fault.inner_text(), "the mark")
    lines, mark = page.locator(".duet-law pre").bounding_box(), page.locator(".duet-law .mark").bounding_box()
    assert lines is not None and mark is not None and 15.0 < mark["y"] - lines["y"] < 30.0

    # Tab, Shift+Tab and a new line indent; undo takes it back.
    area.focus()
    page.keyboard.press("Control+End")
    page.keyboard.type("def other(x):\nif x:\nreturn 1")
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("End")
    page.keyboard.press("Tab")
    assert area.input_value().endswith("def other(x):\n    if x:\n    return 1    ")
    assert not fault.is_visible()

    # Another editor's text is not overwritten before the visitor says so, nor theirs by it.
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(text.replace("MU = 0.01 ", "MU = 0.06 "))
    written = area.input_value()
    path.write_text("def law(situation):\n    return situation.lost\n", encoding="utf-8")
    page.keyboard.press("Control+Enter")
    page.get_by_role("button", name="Save mine over it").wait_for()
    assert "lost" in path.read_text(encoding="utf-8") and area.input_value() == written
    page.get_by_role("button", name="Take the file’s text").click()
    # Its own problem, not the one of the text before it, which is at the same line.
    until(page, lambda: "'lost'" in (fault.text_content() or ""), "the other text")
    area.focus()
    page.keyboard.press("Control+z")
    assert area.input_value() == written
    page.keyboard.press("Control+Enter")
    until(page, lambda: path.read_text(encoding="utf-8") == written, "the text in the file")
    page.locator(".card.right.law", has_text="my_law.py runs.").wait_for()
    until(page, lambda: session.settings.page.ghost == DEFAULT_LAW, "the ghost")
    # What is saved is tested at once; the tests that are asked for come after those.
    lamps = page.locator(".duet-law .lamps .ok")
    until(
        page,
        lambda: [desk.work(name) for name in TRIALS] and lamps.count() == len(TRIALS),
        "what was saved is tested",
    )
    attempts = run.walk.done.attempts
    page.keyboard.press("Escape")
    area.blur()

    unfold_controls(page)
    page.get_by_text(f"my_law.py, SHA-256 {sha256(path.read_bytes()).hexdigest()[:12]}…").wait_for(
        state="attached"
    )

    # The six tests come one by one, in words, and pass the challenge.
    page.keyboard.press("c")
    tests = page.locator(".duet-l-attempt [role=status] .tests li")
    page.locator(".tests li.now em", has_text="being tested").first.wait_for()
    page.get_by_role("button", name="Testing …").wait_for()
    for number, name in enumerate(TRIALS, 1):
        assert desk.work(name) == [name]
        until(
            page,
            lambda number=number: tests.locator("em", has_text="passed").count() == number,
            f"{name} passed",
        )
    until(page, lambda: run.walk.done.attempts > attempts, "the second examination")
    page.get_by_text("6 of 6 tests passed.").first.wait_for()
    assert [tests.nth(i).locator("em").inner_text() for i in range(tests.count())] == ["passed"] * len(TRIALS)
    assert all("is named" in tests.nth(i).inner_text() for i in range(len(TRIALS)))
    until(page, lambda: lamps.count() == len(TRIALS), "six green lamps")
    page.get_by_text("Challenge passed.").first.wait_for()
    page.get_by_role("button", name="Test my law").wait_for()
    assert run.walk.done.passed and run.walk.done.attempts == attempts + 1, "each examination counts once"

    # A text that is not saved survives a reload, and another editor's one that came after the visitor's own is safe, too.
    area.focus()
    page.keyboard.press("Control+End")
    page.keyboard.type("# mine")
    path.write_text(text, encoding="utf-8")
    page.get_by_text(f"my_law.py, SHA-256 {sha256(path.read_bytes()).hexdigest()[:12]}…").wait_for(
        state="attached"
    )
    page.keyboard.press("Control+Enter")
    page.get_by_role("button", name="Save mine over it").wait_for()
    assert path.read_text(encoding="utf-8") == text
    page.reload()
    area.wait_for()
    until(page, lambda: area.input_value() == f"{written}# mine", "the text that is not saved")
