"""Lessons walked in a real browser by clicks or keys: every answer, verdict and challenge."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter

from playwright.sync_api import Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.check import said_by
from app.features.lessons.lesson import Question, Step, Trial
from app.features.lessons.session.lesson_actions import GoTo
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.start import App
from tests.app.conftest import ask, private_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.by_hand import visit
from tests.browser import lasting, until, wait_frames
from tests.tools.lesson_hands import Hands
from tests.tools.lesson_moves import LONG, LessonMoves

CONTROLS = {
    "button",
    "checkbox",
    "combobox",
    "link",
    "radio",
    "searchbox",
    "slider",
    "spinbutton",
    "switch",
    "tab",
    "textbox",
}
"""Roles of controls."""

FLAWS = """() => { const bad = [];
  for (const block of document.querySelectorAll('.duet-lesson')) {
    if (/\\$|\\\\[a-z]/.test(block.innerText)) bad.push('unset formula: ' + block.innerText.slice(0, 80));
    if (block.scrollWidth > block.clientWidth + 1) bad.push('too wide: ' + block.innerText.slice(0, 80));
  }
  for (const image of document.querySelectorAll('.duet-lesson img'))
    if (image.complete && !image.naturalWidth) bad.push('no picture: ' + image.alt);
  const orange = button => button.offsetParent && getComputedStyle(button).getPropertyValue('--button-bg').startsWith('light-dark(');
  const bright = [...document.querySelectorAll('button')].filter(orange).map(button => button.innerText.trim());
  if (bright.length > 1) bad.push('more than one button stands out: ' + bright.join(', '));
  return bad; }"""


def enter(page: Page, opened: App, query: str) -> tuple[Session, LessonSession]:
    """Open a lesson by its link. Returns the session and its lessons."""
    session = visit(page, opened, query)
    page.locator(".duet-l-head").wait_for()
    return session, next(
        lessons_of(one) for one in private_of(opened).visitors.values() if one.session is session
    )


def shown_step(page: Page, session: Session, run: LessonSession, lesson: int, step: int) -> None:
    """Go to a step (0-based; lesson −1 is the test before lesson 1), and wait until it is shown."""
    place = next(i for i, one in enumerate(run.book.lessons) if one.number == lesson + 1)
    ask(session, lambda _: run.act(GoTo(place, step)))
    crumb = re.compile(rf"^\D*{lesson + 1}\D+{step + 1}\D")
    until(
        page,
        lambda: crumb.search(page.locator(".duet-l-head .crumb").first.text_content() or ""),
        f"lesson {lesson + 1}, step {step + 1}",
    )


def named(page: Page) -> None:
    """Wait until every control has a name in the accessibility tree; new ones get it a moment later."""
    chrome = page.context.new_cdp_session(page)

    def unnamed() -> list[int]:
        nodes = [
            node for node in chrome.send("Accessibility.getFullAXTree")["nodes"] if not node.get("ignored")
        ]
        controls = [node for node in nodes if node.get("role", {}).get("value") in CONTROLS]
        return [
            n["backendDOMNodeId"] for n in controls if not str(n.get("name", {}).get("value") or "").strip()
        ]

    try:
        until(page, lambda: not unnamed(), "names", 20.0)
    except AssertionError:
        shown = [
            chrome.send("DOM.getOuterHTML", {"backendNodeId": node})["outerHTML"][:200] for node in unnamed()
        ]
        raise AssertionError("controls without a name:\n" + "\n".join(shown)) from None
    chrome.detach()


@dataclass
class Walked:
    """A walked step: headlines of verdicts, explaining runs, "passed" for a challenge, wall time."""

    lesson: str
    step: str
    said: list[str] = field(default_factory=list)
    whys: int = 0
    challenge: str = ""
    seconds: float = 0.0


class Walker:
    """Walks lessons on a page; session and lessons of the tab are only read, except for the page's speed."""

    def __init__(self, page: Page, session: Session, run: LessonSession, hands: Hands) -> None:
        self.page, self.session, self.run, self.hands = page, session, run, hands
        self.moves = LessonMoves(page, session, run, hands)
        self.check: Callable[[Page], None] = lambda _: None
        """Called with the page once per phase of a step."""
        self._checked = set[Phase]()

    def step(self) -> Walked:
        """Walk the present step from its beginning to its end, with every answer, and stay there."""
        begin, walk = perf_counter(), self.run.walk
        step, question = walk.step, walk.step.question
        walked = Walked(walk.lesson.id, step.id)
        self._checked.clear()
        if question is not None:
            for answer in sorted(range(len(question.choices)), key=lambda i: i == question.right):
                self._answer(question, answer, walked)
        else:
            self._at(Phase.DO)
            if not walk.yours:
                self._go()
                if step.measurements or step.observe:
                    self._at(Phase.OBSERVE)
        while walk.phase is not walk.phases[-1]:
            before = walk.phase
            self.hands.do("next")
            until(
                self.page, lambda before=before: self.run.walk.phase is not before, f"on from {before}", LONG
            )
            self._at(walk.phase)
            self._look()
        if step.challenge is not None:
            self._challenge(step)
            walked.challenge = "passed"
        walked.seconds = perf_counter() - begin
        return walked

    def on_to_the_next(self) -> None:
        here = self.run.walk.step
        self.hands.do("next")
        until(self.page, lambda: self.run.walk.step is not here, "the next step")

    def _at(self, phase: Phase) -> None:
        """Wait for a phase of the present step, in the session and on the page."""
        until(self.page, lambda: self.run.walk.phase is phase, f"{phase} of {self.run.walk.step.id}", LONG)
        self.page.locator(f".duet-l-head .phases .now:text-is('{phase.value.capitalize()}')").wait_for()
        if phase not in self._checked:
            self._checked.add(phase)
            self.check(self.page)

    def _on(self, label: str) -> None:
        """Wait for a button by the beginning of its label: the user must see that the action is possible."""
        self.page.get_by_role("button", name=re.compile(rf"^\s*(?:{label})")).first.wait_for()

    def _look(self) -> None:
        """Check formulas, widths of texts, and that at most one button is highlighted."""
        wait_frames(self.page, 2)
        assert lasting(self.page, lambda: self.page.evaluate(FLAWS)) == []

    def _answer(self, question: Question, answer: int, walked: Walked) -> None:
        """Answer, check verdict and explanation; before the right answer (last) skip and reset the run."""
        page, run, right = self.page, self.run, answer == question.right
        self._at(Phase.PREDICT)
        assert page.get_by_role("button", name="Run (predict first)").is_disabled()
        self.hands.choose(answer)
        self._at(Phase.DO)
        assert run.walk.done.choice == answer
        if right:
            self._go()
        else:
            self._on("Skip the run")
            self.hands.do("next")
        self._at(Phase.OBSERVE)
        verdict = run.walk.view().verdict
        assert verdict is not None and verdict.right == right
        headline = verdict.headline
        until(
            page,
            lambda: page.locator(".duet-l-verdict .card .mark b").all_inner_texts() == [headline],
            "the verdict",
        )
        text = page.locator(".duet-l-verdict .card").inner_text()
        assert "You said" in text
        until(
            page,
            lambda: headline in (page.locator("#duet-say").text_content() or ""),
            "the verdict is announced",
        )
        walked.said.append(headline)
        outcome = run.walk.done.outcome
        assert outcome is not None and not (right and outcome.reference), (right, outcome)
        self._look()
        if not right and question.choices[answer].why is not None:
            self._on("Show me why")
            self.hands.do("why")
            until(page, lambda: run.walk.view().showing, "the run that shows why")
            self._on("Back to the outcome")
            self.hands.do("next")
            until(page, lambda: not run.walk.view().showing, "the outcome")
            self._at(Phase.OBSERVE)
            # Buttons reappear under the outcome; a click between two layouts would be lost.
            self._look()
            walked.whys += 1
        if not right:
            self.hands.do("reset")

    def _go(self) -> None:
        """Start the run at double speed."""
        ask(self.session, lambda s: s.change("speed", 2.0))
        self._on(r"Run( again)?\s*$")
        self.hands.do("run")
        until(self.page, lambda: not self.session.paused or self.session.simulation.steps > 0, "the run")

    def _challenge(self, step: Step) -> None:
        """Fail once, open the hints, then pass like the lesson's own attempt; a custom law passes at once."""
        page, run, challenge = self.page, self.run, step.challenge
        assert challenge is not None
        self._on("(Check|Test) my|Count this push")
        # A hand without motion makes no push.
        if not challenge.best_of:
            self._check()
        if not (challenge.custom_law or challenge.best_of):
            last, card = run.walk.done.last, page.locator(".duet-l-attempt .card")
            assert last is not None
            until(
                page,
                lambda: ("wrong" in (card.get_attribute("class") or "")) is not last.passed,
                "how it was judged",
            )
        for count in range(1, len(step.hints) + 1):
            self.hands.do("hint")
            until(page, lambda count=count: page.locator(".duet-l-hints li").count() == count, "a hint")
        trial = next(trial for trial in step.trials if not trial.fails)
        if challenge.custom_law:
            page.get_by_text("6 of 6 tests passed.").first.wait_for()
        elif challenge.forecasts:
            self._forecast(step, trial)
        elif challenge.setup.input.kind == "yours":
            self.moves.move(trial)
            self._check()
        else:
            attempts = run.walk.done.attempts
            self.moves.settings(trial)
            self._go()
            until(
                page,
                lambda: run.walk.done.attempts > attempts and self.session.paused,
                "judged at the run's end",
                LONG,
            )
        assert run.walk.done.passed, (step.id, trial.name, run.walk.done.last)
        if not challenge.custom_law:
            page.locator(".duet-l-attempt .card.right").wait_for()

    def _check(self) -> None:
        """Test the run or the law by the page."""
        before = self.run.walk.done.last
        self.hands.do("check")
        until(self.page, lambda: self.run.walk.done.last is not before, "the attempt", LONG)

    def _forecast(self, step: Step, trial: Trial) -> None:
        for i, (label, number) in enumerate(
            zip(self.run.walk.view().forecasts, said_by(step, trial), strict=True)
        ):
            assert number is not None

            def known(i: int = i, number: float = number) -> bool:
                said = self.run.said[i] if i < len(self.run.said) else None
                return said is not None and abs(said - number) <= 1e-3 * abs(number)

            self.hands.say(label, f"{number:.4g}")
            until(self.page, known, f"the number for {label}")
        self._check()
