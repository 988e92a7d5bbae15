"""Walk all lessons in a real browser, by clicks and by keys: `python -m tests.tools.walk_lessons` prints each step.

Exit code 1 on a failure; its picture is saved to the artefact folder.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp

from playwright.sync_api import Browser, Page

from app.features import FEATURES
from app.features.custom_law.command_options import CustomLawOptions
from app.features.custom_law.commands import NewLaw, new_law
from app.hosting.serve_options import ServeOptions
from app.start import App, start_app
from tests.browser import launch, listen, save_picture, started_playwright, until
from tests.tools.lesson_hands import Clicks, Keys
from tests.tools.lesson_walker import Walker, enter, named, shown_step

HANDS = {"clicks": Clicks, "keys": Keys}


@contextmanager
def tab(browser: Browser, width: int, height: int) -> Iterator[Page]:
    """An empty tab; its errors fail the walk."""
    context = browser.new_context(viewport={"width": width, "height": height})
    page = context.new_page()
    errors: list[str] = []
    listen(page, errors)
    try:
        yield page
    finally:
        context.close()
    assert not errors, "the page complained: " + "; ".join(errors)


def walk(page: Page, house: App, by: str, numbers: list[int], pictures: bool) -> None:
    """Walk lessons by clicks or by keys, and print every step. Raises AssertionError if a lesson fails."""

    def picture(page: Page) -> None:
        save_picture(
            page, f"{by}-{run.walk.lesson.number:02d}-{run.walk.step_index + 1}-{run.walk.phase.value}"
        )

    session, run = enter(page, house, f"lesson={numbers[0]}")
    walker = Walker(page, session, run, HANDS[by](page))
    if pictures:
        walker.check = picture
    for number in numbers:
        lesson = next(lesson for lesson in run.book.lessons if lesson.number == number)
        if run.walk.lesson is not lesson:
            shown_step(page, session, run, number - 1, 0)
        for step in lesson.steps:
            try:
                found = walker.step()
                named(page)
            except BaseException:
                save_picture(page, f"walk-{by}-{lesson.id}-{step.id}")
                raise
            did = f"{len(found.said):2d} answers, {found.whys} whys, challenge {found.challenge or '–':7s}"
            print(f"{by:6s} {found.lesson:18s} {found.step:14s} {did} {found.seconds:6.1f} s", flush=True)
            if (step, number) != (lesson.steps[-1], numbers[-1]) and step is not run.book.lessons[-1].steps[
                -1
            ]:
                walker.on_to_the_next()
    walker.hands.do("leave")
    until(page, lambda: not run.open, "leaving")


def custom_law() -> Path:
    """Path of a new law that passes the six tests, as a student would write it from the template."""
    path = Path(mkdtemp()) / "my_law.py"
    new_law(NewLaw(path))
    # The template, as printed in the paper, demands any speed near a singular row; well damped, it passes.
    path.write_text(path.read_text(encoding="utf-8").replace("MU = 0.01 ", "MU = 0.06 "), encoding="utf-8")
    return path


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--by", choices=HANDS, nargs="*", default=list(HANDS))
    parser.add_argument("--lessons", type=int, nargs="+", default=list(range(1, 12)), help="numbers")
    parser.add_argument("--size", type=int, nargs=2, default=(1024, 768), help="of the window [px]")
    parser.add_argument("--pictures", action="store_true", help="of every phase, in the artefact folder")
    given = parser.parse_args()
    house = start_app(ServeOptions(features=(CustomLawOptions(custom_law()),)), features=FEATURES)
    failed = 0
    with started_playwright() as playwright:
        browser = launch(playwright)
        for by in given.by:
            try:
                with tab(browser, *given.size) as page:
                    walk(page, house, by, given.lessons, given.pictures)
            except Exception:
                failed = 1
                traceback.print_exc()
        browser.close()
    house.close()
    return failed


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)
