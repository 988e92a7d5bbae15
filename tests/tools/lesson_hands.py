"""A student's actions in the lessons, by mouse only or by keyboard only."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page

from app.page.panels.controls import TABS
from tests.app.page.by_hand import row_of
from tests.app.page.helpers import SPECS, page_label

BUTTONS = {
    "run": (r"Run( again)?\s*$", "Space"),
    "next": (r"(Next(?! push)|Skip the run|Back to the outcome)", "n"),
    "why": ("Show me why", "y"),
    "check": ("(Check|Test) my|Count this push", "c"),
    "hint": (r"Hint \d of", "h"),
    "reset": ("Reset step", None),
    "again": (r"Reset\s*$", "r"),
    "leave": ("Leave the lessons", "x"),
}
"""Action → (beginning of the button's label, key); a button without a key is reached by Tab."""


def press(page: Page, label: str) -> None:
    """Press a button of the panel by a regular expression for the beginning of its label."""
    page.get_by_role("button", name=re.compile(rf"^\s*(?:{label})")).first.click()


def control_of(key: str, value: Any) -> tuple[str, str, str]:
    """A setting's tab, its label, and the text that a person enters for a value."""
    spec = SPECS[key]
    entered = (
        spec.options()[value]
        if spec.choices
        else value
        if spec.read is not None
        else f"{value * spec.page_scale:g}"
    )
    return next(name for name, _, keys in TABS if key in keys), page_label(key), entered


class Clicks:
    """A student with a mouse only."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def choose(self, answer: int) -> None:
        press(self.page, rf"(● )?{answer + 1} ")

    def do(self, what: str) -> None:
        press(self.page, BUTTONS[what][0])

    def say(self, label: str, text: str) -> None:
        self.page.get_by_label(label, exact=True).fill(text)

    def slide(self, label: str, text: str) -> None:
        row = row_of(self.page, label)
        row.locator("input[type=text]").last.fill(text)
        self.page.locator(".duet-l-head").click()

    def set(self, key: str, value: Any) -> None:
        tab, label, entered = control_of(key, value)
        # While the panel with the tabs is folded, the step's own controls are in the lesson.
        tabs = self.page.get_by_role("tab", name=tab, exact=True)
        elsewhere = tabs if tabs.is_visible() else self.page.locator(".duet-l-head")
        elsewhere.click()
        row = row_of(self.page, label)
        if SPECS[key].choices:
            row.locator("input:visible").first.click()
            self.page.get_by_role("option", name=entered, exact=True).click()
        else:
            row.locator("input:visible").last.fill(entered)
            # A click elsewhere moves the focus out of the box.
            elsewhere.click()


class Keys:
    """A student with a keyboard only."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def choose(self, answer: int) -> None:
        self.page.keyboard.press(str(answer + 1))

    def do(self, what: str) -> None:
        label, key = BUTTONS[what]
        if key is None:
            self._tab_to(lambda: self._focused("innerText") == label, label)
            self._enter(None)
        else:
            self.page.keyboard.press(key)

    def say(self, label: str, text: str) -> None:
        self._tab_to(lambda: self._focused("getAttribute('aria-label')") == label, f"the box “{label}”")
        self._enter(text)

    def slide(self, label: str, text: str) -> None:
        self._to_input(label)
        self._enter(text)

    def _to_input(self, label: str) -> None:
        names = ("getAttribute('aria-label')", "labels?.[0]?.textContent")
        self._tab_to(
            lambda: self._focused("tagName") == "INPUT" and label in map(self._focused, names), f"“{label}”"
        )

    def set(self, key: str, value: Any) -> None:
        tab, label, entered = control_of(key, value)
        tabs = {name for name, _, _ in TABS}
        if self.page.get_by_role("tab", name=tab, exact=True).is_visible():
            at_tabs = lambda: (  # noqa: E731
                self._focused("getAttribute('role')") == "tab" and self._focused("innerText") in tabs
            )
            self._tab_to(at_tabs, "the tabs")
            self._press_until("ArrowRight", lambda: self._focused("innerText") == tab, f"the tab “{tab}”")
            self.page.keyboard.press("Enter")
            self.page.locator("[role=tab][aria-selected=true]").get_by_text(tab, exact=True).wait_for()
        self._to_input(label)
        if SPECS[key].choices:
            marked = "document.getElementById(document.activeElement?.getAttribute('aria-activedescendant') ?? '')?.innerText"
            self._press_until(
                "ArrowDown",
                lambda: str(self.page.evaluate(marked)).strip() == entered,
                f"the choice “{entered}”",
            )
        self._enter(None if SPECS[key].choices else entered)

    def _tab_to(self, there: Callable[[], bool], what: str) -> None:
        self._press_until("Tab", there, what)

    def _press_until(self, key: str, there: Callable[[], bool], what: str) -> None:
        for _ in range(120):
            if there():
                return
            self.page.keyboard.press(key)
        raise AssertionError(f"{what} cannot be reached by {key}")

    def _focused(self, what: str) -> str:
        return str(self.page.evaluate(f"document.activeElement?.{what} ?? ''")).strip()

    def _enter(self, text: str | None) -> None:
        """Replace the focused text and press Enter; then remove the focus, so that keys reach the lesson."""
        if text is not None:
            self.page.keyboard.press("Control+a")
            self.page.keyboard.type(text)
        self.page.keyboard.press("Enter")
        self.page.keyboard.press("Escape")
        self.page.evaluate("document.activeElement?.blur()")


Hands = Clicks | Keys
