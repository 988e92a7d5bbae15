"""What a student does in the lessons, by the mouse alone or by the keyboard alone."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, ClassVar

from playwright.sync_api import Page

from app.page.panels.controls import TABS
from app.settings import Settings
from scenes.settings import specs

SPECS = specs(Settings)


def press(page: Page, label: str) -> None:
    """Press a button of the panel by the beginning of its label, a regular expression."""
    page.get_by_role("button", name=re.compile(rf"^\s*{label}")).first.click()


def control_of(key: str, value: Any) -> tuple[str, str, str]:
    """Return of a setting the tab on which it stands, its label, and what a person enters for a value."""
    spec = SPECS[key]
    tab = next(name for name, _, keys in TABS if key in keys)
    label = f"{spec.label} [{spec.page_unit}]" if spec.page_unit else spec.label
    if spec.choices:
        return tab, label, spec.choice_labels[spec.choices.index(value)]
    return tab, label, f"{value * spec.page_scale:g}"


class Clicks:
    """What a student does by the mouse alone."""

    LABELS: ClassVar = {
        "run": r"Run( again)?\s*$",
        "next": r"(Next|Skip the run|Back to the outcome)",
        "back": r"Back\s*$",
        "why": "Show me why",
        "check": "(Check|Test) my",
        "hint": r"Hint \d of",
        "reset": "Reset step",
        "again": r"Reset\s*$",
        "leave": "Leave the lessons",
    }

    def __init__(self, page: Page) -> None:
        self.page = page

    def choose(self, answer: int) -> None:
        press(self.page, rf"(● )?{answer + 1} ")

    def do(self, what: str) -> None:
        press(self.page, self.LABELS[what])

    def say(self, label: str, text: str) -> None:
        box = self.page.get_by_label(label, exact=True)
        box.click()
        box.fill(text)

    def set(self, key: str, value: Any) -> None:
        tab, label, entered = control_of(key, value)
        self.page.get_by_role("tab", name=tab, exact=True).click()
        row = self.page.locator("label:visible").get_by_text(label, exact=True).locator("xpath=../../..")
        if SPECS[key].choices:
            row.locator("input:visible").first.click()
            self.page.get_by_role("option", name=entered, exact=True).click()
        else:
            box = row.locator("input[type=text]").last
            box.fill(entered)
            # A click elsewhere leaves the box.
            self.page.get_by_role("tab", name=tab, exact=True).click()


class Keys:
    """What a student does by the keyboard alone."""

    KEYS: ClassVar = {
        "run": "Space",
        "next": "n",
        "back": "b",
        "why": "y",
        "check": "c",
        "hint": "h",
        "again": "r",
        "leave": "x",
        "slower": "[",
        "faster": "]",
    }

    def __init__(self, page: Page) -> None:
        self.page = page

    def choose(self, answer: int) -> None:
        self.page.keyboard.press(str(answer + 1))

    def do(self, what: str) -> None:
        if what == "reset":
            # A button without a key of its own: reached as every control is.
            self.tab_to(lambda: self._focused("innerText").strip() == "Reset step", "“Reset step”")
            self.page.keyboard.press("Enter")
            self._let_go()
        else:
            self.page.keyboard.press(self.KEYS[what])

    def say(self, label: str, text: str) -> None:
        self.tab_to(lambda: self._focused("getAttribute('aria-label')") == label, f"the box “{label}”")
        self.page.keyboard.press("Control+a")
        self.page.keyboard.type(text)
        self._let_go()

    def set(self, key: str, value: Any) -> None:
        tab, label, entered = control_of(key, value)
        names = {name for name, _, _ in TABS}
        self.tab_to(
            lambda: self._focused("getAttribute('role')") == "tab" and self._focused("innerText").strip() in names, "the tabs"
        )
        for _ in range(2 * len(names)):
            if self._focused("innerText").strip() == tab:
                break
            self.page.keyboard.press("ArrowRight")
        else:
            raise AssertionError(f"the tab “{tab}” cannot be reached by the arrows")
        self.page.keyboard.press("Enter")
        self.page.locator("[role=tab][aria-selected=true]").get_by_text(tab, exact=True).wait_for()
        self.tab_to(lambda: self._name() == label and self._focused("tagName") == "INPUT", f"“{label}”")
        if SPECS[key].choices:
            self._pick(entered)
        else:
            self.page.keyboard.press("Control+a")
            self.page.keyboard.type(entered)
            self.page.keyboard.press("Enter")
        self._let_go()

    def _pick(self, choice: str) -> None:
        """Go down the open list to a choice, and take it."""
        for _ in range(30):
            self.page.keyboard.press("ArrowDown")
            marked = self.page.evaluate(
                "document.getElementById(document.activeElement?.getAttribute('aria-activedescendant') ?? '')?.innerText ?? ''"
            )
            if str(marked).strip() == choice:
                self.page.keyboard.press("Enter")
                return
        raise AssertionError(f"“{choice}” is not among the choices")

    def tab_to(self, there: Callable[[], bool], what: str) -> None:
        """Press Tab until something has the focus."""
        for _ in range(120):
            if there():
                return
            self.page.keyboard.press("Tab")
        raise AssertionError(f"{what} cannot be reached by Tab")

    def _name(self) -> str:
        """What the control that has the focus is called."""
        return self._focused("getAttribute('aria-label')") or self._focused("labels?.[0]?.textContent").strip()

    def _focused(self, what: str) -> str:
        return str(self.page.evaluate(f"document.activeElement?.{what} ?? ''"))

    def _let_go(self) -> None:
        # Escape leaves a box as a click beside it would; keys are the lesson's again.
        self.page.keyboard.press("Escape")
        self.page.evaluate("document.activeElement?.blur()")


Hands = Clicks | Keys
