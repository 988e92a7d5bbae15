"""How lessons are walked in a real browser: by clicks alone or by keys alone, every answer, every verdict, every challenge."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from playwright.sync_api import Error, Page

from app.hosting.private_host import PrivateHost
from app.lessons.check import said_by
from app.lessons.lesson import Step, Trial
from app.lessons.phases import Phase
from app.lessons.reference_runs import person_of
from app.lessons.room_places import start_positions
from app.lessons.session.lesson_actions import GoTo
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.start import App
from controllers.kinematics import Array
from scenes.roles import TargetSource
from scenes.settings import values
from scenes.targets import BallTarget, HandTarget
from tests.app.conftest import ask, live_sessions
from tests.browser import close_software_note, until, wait_frames
from tests.tools.lesson_hands import Hands, Keys

LONG = 180.0
"""How long a run may take on a busy machine [s]."""

SETTLING = 4.0
"""Until an arm has given way to a ball that stays where it is [s]."""

FAST = 0.8
"""Speed limit for a push by arrows [m/s]."""

AHEAD = 0.25
"""How far ahead of the hand the target of a straight push is [m]."""

BURST = 6
"""Presses of keys between two frames, as of a key that is held down."""

DRAG = 0.02
"""Wall time between two places of a drag [s]."""


def enter(page: Page, opened: App, query: str) -> tuple[Session, LessonSession]:
    """Open a lesson by its link; return the session and its lessons."""
    known = set(live_sessions(opened))
    page.set_default_timeout(60_000)
    page.goto(f"{opened.url}/?{query}")
    page.locator(".duet-l-head").wait_for()
    until(page, lambda: set(live_sessions(opened)) - known, "a session", 60.0)
    close_software_note(page)
    assert isinstance(opened.host, PrivateHost)
    number = max(set(live_sessions(opened)) - known)
    return live_sessions(opened)[number], opened.host.visitors[number].lessons


def shown_step(page: Page, session: Session, run: LessonSession, lesson: int, step: int) -> None:
    """Go to a step, from 0, and wait until it is on the page."""
    ask(session, lambda _: run.act(GoTo(lesson, step)))
    crumb = f"Lesson {run.book.lessons[lesson].number} · step {step + 1} "
    until(page, lambda: crumb in (page.locator(".duet-l-head .crumb").text_content() or ""), crumb, 60.0)


CONTROLS = frozenset(
    {"button", "slider", "textbox", "spinbutton", "combobox", "checkbox", "tab", "radio", "searchbox", "switch", "link"}
)
"""Roles of what can be operated."""


def unnamed(page: Page) -> list[str]:
    """The controls that a listener would not know, by role and HTML: those without a name in the accessibility tree."""
    chrome = page.context.new_cdp_session(page)
    found: list[str] = []
    for node in chrome.send("Accessibility.getFullAXTree")["nodes"]:
        role = node.get("role", {}).get("value")
        if node.get("ignored") or role not in CONTROLS or str(node.get("name", {}).get("value") or "").strip():
            continue
        try:
            handle = chrome.send("DOM.resolveNode", {"backendNodeId": node["backendDOMNodeId"]})["object"]["objectId"]
            asked = {
                "objectId": handle,
                "functionDeclaration": "function(){return this.outerHTML.slice(0,200)}",
                "returnByValue": True,
            }
            found.append(f"{role}: {chrome.send('Runtime.callFunctionOn', asked)['result']['value']}")
        except Error:
            # It is gone already, and another one asks for its name the next time.
            found.append(f"{role}: gone")
    chrome.detach()
    return found


def named(page: Page) -> None:
    """Wait until every control has a name; a new one gets its own a moment after it was drawn."""
    without: list[str] = []

    def all_have() -> bool:
        without[:] = unnamed(page)
        return not without

    try:
        until(page, all_have, "names", 20.0)
    except AssertionError:
        raise AssertionError("controls without a name:\n" + "\n".join(without)) from None


@contextmanager
def dragging(session: Session, person: TargetSource) -> Iterator[None]:
    """Post a source's targets to a session, as a drag does, while the block runs."""
    over = threading.Event()

    def drag() -> None:
        while not over.wait(DRAG):
            session.post(lambda: session.hold(person.target(session.simulation.time)))

    thread = threading.Thread(target=drag, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        session.post(lambda: session.hold(None))


@dataclass
class Walked:
    """A walked step: answers with a verdict, runs that show why, "passed" for a challenge, wall time, headlines of the verdicts."""

    lesson: str
    step: str
    answers: int = 0
    whys: int = 0
    challenge: str = ""
    seconds: float = 0.0
    said: list[str] = field(default_factory=list)


class Walker:
    """Walks lessons that are open on a page.

    Args:
        page: the tab.
        session, run: of the tab, only to be asked, but for what a drag posts and for the settings of a challenge.
        hands: how.
    """

    def __init__(self, page: Page, session: Session, run: LessonSession, hands: Hands) -> None:
        self.page, self.session, self.run, self.hands = page, session, run, hands

    def at(self, phase: Phase, what: str = "") -> None:
        """Wait for a part of the present step, in the session and on the page."""
        until(self.page, lambda: self.run.walk.phase is phase, f"{phase} {what}", LONG)
        self.page.locator(f".duet-l-head .phases .now:text-is('{phase.value.capitalize()}')").wait_for()

    def on(self, label: str) -> None:
        """Wait until a button with this beginning is on the page: what is asked for can be seen to be possible."""
        self.page.get_by_role("button", name=re.compile(rf"^\s*{label}")).first.wait_for()

    def step(self) -> Walked:
        """Walk the present step from its beginning to its end, with every answer, and stay there."""
        begin, step = perf_counter(), self.run.walk.step
        walked = Walked(self.run.walk.lesson.id, step.id)
        question = step.question
        if question is not None:
            wrong = [i for i in range(len(question.choices)) if i != question.right]
            for answer in wrong:
                self._answer(answer, walked, skip=True)
                self.hands.do("reset")
            self._answer(question.right, walked, skip=False)
        else:
            self.at(Phase.DO, step.id)
            self._run_alone(step)
        while self.run.walk.phase is not self.run.walk.phases[-1]:
            before = self.run.walk.phase
            self.hands.do("next")
            until(self.page, lambda before=before: self.run.walk.phase is not before, f"on from {before}", LONG)
            self.at(self.run.walk.phase)
            self._look()
        if step.challenge is not None:
            (self._custom_law if step.challenge.custom_law else self._challenge)(step)
            walked.challenge = "passed"
        walked.seconds = perf_counter() - begin
        return walked

    # ---- parts of a step -------------------------------------------------------------------------------------------------------

    def _answer(self, answer: int, walked: Walked, skip: bool) -> None:
        """Give an answer, run or skip the run, and read the verdict."""
        page, run, step = self.page, self.run, self.run.walk.step
        self.at(Phase.PREDICT, step.id)
        assert page.get_by_role("button", name="Run (predict first)").is_disabled()
        self.hands.choose(answer)
        self.at(Phase.DO, step.id)
        assert run.walk.done.choice == answer
        if skip:
            self.on("Skip the run")
            self.hands.do("next")
        else:
            self._go()
        self.at(Phase.OBSERVE, step.id)
        card = page.locator(".duet-l-verdict .card .mark b")
        card.wait_for()
        question = step.question
        assert question is not None and run.walk.verdict is not None
        assert run.walk.verdict.right == (answer == question.right)
        headline = card.inner_text()
        assert headline == run.walk.verdict.headline, headline
        text = page.locator(".duet-l-verdict .card").inner_text()
        assert "You said" in text and "Measured" in text
        said = page.locator("#duet-say")
        until(page, lambda: headline in (said.text_content() or ""), "the verdict is announced", 60.0)
        walked.answers += 1
        walked.said.append(headline)
        if not skip:
            assert run.walk.done.outcome is not None and not run.walk.done.outcome.reference
        self._look()
        if answer != question.right and question.choices[answer].why is not None:
            self.on("Show me why")
            self.hands.do("why")
            until(page, lambda: run.view().showing, "the run that shows why", 60.0)
            self.on("Back to the outcome")
            self.hands.do("next")
            until(page, lambda: not run.view().showing, "the outcome", 60.0)
            self.at(Phase.OBSERVE, step.id)
            walked.whys += 1

    def _go(self) -> None:
        """Start the run, twice as fast."""
        ask(self.session, lambda s: s.change("speed", 2.0))
        self.on(r"Run( again)?\s*$")
        self.hands.do("run")
        until(self.page, lambda: not self.session.paused or self.session.simulation.steps > 0, "the run", 60.0)

    def _run_alone(self, step: Step) -> None:
        """Let a run without a question go to its end; one that is the student's own goes on by itself."""
        if not self.run.walk.yours:
            self._go()
            if step.measurements or step.observe:
                self.at(Phase.OBSERVE, step.id)

    def _challenge(self, step: Step) -> None:
        """Fail once, read why, open the hints, then pass as the lesson's own attempt does."""
        page, run, hands = self.page, self.run, self.hands
        challenge = step.challenge
        assert challenge is not None
        self.on("Check my")
        before = run.walk.done.attempts
        hands.do("check")
        until(page, lambda: run.walk.done.attempts > before, "the first attempt", LONG)
        attempt = page.locator(".duet-l-attempt .card")
        attempt.wait_for()
        if run.walk.done.last is not None and not run.walk.done.last.passed:
            assert attempt.get_attribute("class") is not None and "wrong" in str(attempt.get_attribute("class"))
        for count in range(1, len(step.hints) + 1):
            hands.do("hint")
            until(page, lambda count=count: page.locator(".duet-l-hints li").count() == count, "a hint", 60.0)
        trial = next(trial for trial in step.trials if not trial.fails)
        if challenge.forecasts:
            self._forecast(step, trial)
        elif challenge.setup.input.kind == "yours":
            self._by_hand(step, trial)
        else:
            self._settings(trial)
            self._go()
            until(page, lambda: run.walk.finished(self.session.simulation) and self.session.paused, "the run's end", LONG)
            until(page, lambda: run.walk.done.attempts > before + 1, "judged at its end", LONG)
        assert run.walk.done.passed, (step.id, trial.name, run.walk.done.last)
        page.locator(".duet-l-attempt .card.right").wait_for()

    def _custom_law(self, step: Step) -> None:
        """Have the law in the file tested; it passes."""
        self.on("Test my law")
        self.hands.do("check")
        until(self.page, lambda: self.run.walk.done.passed, f"{step.id}: the six tests", LONG)
        self.page.get_by_text("6 of 6 tests passed.").first.wait_for()
        for count in range(1, len(step.hints) + 1):
            self.hands.do("hint")
            until(self.page, lambda count=count: self.page.locator(".duet-l-hints li").count() == count, "a hint", 60.0)

    def _settings(self, trial: Trial) -> None:
        """Set what a trial sets, with the page's own controls."""
        session = self.session
        for key, value in values(trial.setup.settings(session.settings).run).items():
            if values(session.settings)[key] == value:
                continue
            self.hands.set(key, value)
            until(self.page, lambda key=key, value=value: values(session.settings)[key] == value, f"{key} = {value}", 60.0)

    def _by_hand(self, step: Step, trial: Trial) -> None:
        """Do by drags what a trial's person does, in a fresh run with a trial's settings."""
        page, run, session = self.page, self.run, self.session
        self._settings(trial)
        turn = run.walk.run_id
        self.hands.do("again")
        until(page, lambda: run.walk.run_id != turn and session.simulation.time < 2.0, "a fresh run", 60.0)
        simulation = session.simulation
        if trial.setup.input.kind == "none":
            positions = ask(session, lambda s: start_positions(s.simulation.room, trial.setup.start))
            assert positions is not None and simulation.room.ball is not None
            place = positions[simulation.room.ball].copy()
            person: TargetSource = _Still(place)
        else:
            person = ask(session, lambda _: person_of(simulation, trial.setup))
        if isinstance(self.hands, Keys):
            if isinstance(person, _Still):
                self._nudge_by_keys(person.place)
            elif trial.setup.input.name == "elbow_to":
                self._swing_by_keys(step)
            else:
                self._push_by_keys()
            self._checked()
            return
        with dragging(session, person):
            until(page, lambda: simulation.time >= trial.setup.seconds, "the drag", LONG)
            self._checked()

    def _checked(self) -> None:
        """Have the run judged."""
        attempts = self.run.walk.done.attempts
        self.hands.do("check")
        until(self.page, lambda: self.run.walk.done.attempts > attempts, "the attempt", LONG)

    def _swing_by_keys(self, step: Step) -> None:
        """Swing the elbow to both marks with J and K."""
        simulation, (low, high) = self.session.simulation, self.run.walk.marks(self.session.simulation)
        for there, back, place, other in (("J", "K", high, low), ("K", "J", low, high)):

            def miss(place: Array, other: Array) -> tuple[float, bool]:
                """How far the elbow is from a mark, and whether it has gone past it, as seen from the other one."""
                elbow = simulation.kinematics.joint_point(simulation.guided.elbow)
                past = np.linalg.norm(elbow - other) > np.linalg.norm(place - other)
                return float(np.linalg.norm(elbow - place)), bool(past)

            for _ in range(400):
                away, past = ask(self.session, lambda _, of=(place, other): miss(*of))
                if away < 0.012:
                    break
                self.page.keyboard.press(back if past else there)
                wait_frames(self.page, 2)
            else:
                raise AssertionError(f"{step.id}: the mark cannot be reached with {there} and {back}")

    def _ways(self) -> dict[str, Array]:
        """Return by key how far it moves what is the student's, found out by trying, forth and back."""
        session, page = self.session, self.page
        ways: dict[str, Array] = {}
        for key in ("ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "PageDown"):
            page.keyboard.press(key)
            until(page, lambda: session.held is not None, key, 60.0)
            # Whatever else was pressed has arrived when a frame is over.
            wait_frames(page, 2)
            before = ask(session, lambda _: _held_at(session))
            page.keyboard.press(key)
            until(page, lambda before=before: bool(np.abs(_held_at(session) - before).max() > 1e-4), key, 60.0)
            ways[key] = ask(session, lambda _: _held_at(session)) - before
        return ways

    def _push_by_keys(self) -> None:
        """Push the guided hand at the other one with the arrows, in slow motion, until it is 10 mm nearer than d_m."""
        session, simulation, page = self.session, self.session.simulation, self.page
        for _ in range(3):
            self.hands.do("slower")
        until(page, lambda: session.settings.page.speed == 0.25, "slow motion", 60.0)
        ways = self._ways()
        # Arrows do not meet the other hand as squarely as a script does; "w_max 0.4 m/s or more" is the hint.
        self.hands.set("wmax", FAST)
        until(page, lambda: values(session.settings)["wmax"] == FAST, "a faster hand", 60.0)
        # The ways are known now; the push begins with a fresh run.
        turn = self.run.walk.run_id
        self.hands.do("again")
        until(page, lambda: self.run.walk.run_id != turn and simulation.time < 0.5, "a fresh run", 60.0)
        other = next(arm for arm in simulation.room.arms if arm is not simulation.guided)
        nearest = float(values(session.settings)["dm"]) - 0.01

        def hands() -> tuple[Array, Array]:
            own, its = (simulation.kinematics.hand_pose(arm).translation.copy() for arm in (simulation.guided, other))
            return own, its

        start, its = ask(session, lambda _: hands())
        straight = (its - start) / np.linalg.norm(its - start)
        deadline = perf_counter() + LONG
        while ask(session, lambda s: s.simulation.sample().distance) > nearest:
            assert perf_counter() < deadline, "the other arm keeps away"
            own = ask(session, lambda _: hands()[0])
            rest = start + (float((own - start) @ straight) + AHEAD) * straight
            rest = rest - ask(session, lambda s, own=own: _held_at(s) if s.held else own)
            for _ in range(BURST):
                key = min(ways, key=lambda key, rest=rest: float(np.linalg.norm(rest - ways[key])))
                page.keyboard.press(key)
                rest = rest - ways[key]
            wait_frames(page, 1)

    def _nudge_by_keys(self, place: Array) -> None:
        """Move what is the student's, hand or ball, to a place with the arrows, and wait until all is at rest."""
        session, page = self.session, self.page
        ways = self._ways()
        deadline = perf_counter() + LONG
        while True:
            assert perf_counter() < deadline, "the place is not reached"
            rest = place - ask(session, lambda _: _held_at(session))
            key = min(ways, key=lambda key: float(np.linalg.norm(rest - ways[key])))
            nearer = np.linalg.norm(rest - ways[key]) < np.linalg.norm(rest)
            if nearer:
                # As a key does that is held down, but for the last of the way.
                for _ in range(8 if np.linalg.norm(rest) > 0.3 else 1):
                    page.keyboard.press(key)
            else:
                break
            wait_frames(page, 1)
        settled = session.simulation.time + SETTLING
        until(page, lambda: session.simulation.time > settled, "the arm at rest", LONG)

    def _forecast(self, step: Step, trial: Trial) -> None:
        said = said_by(step, trial)
        for i, (label, number) in enumerate(zip(self.run.view().forecasts, said, strict=True)):
            assert number is not None

            def taken(i: int = i, number: float = number) -> bool:
                known = self.run.said[i] if i < len(self.run.said) else None
                return known is not None and abs(known - number) <= 1e-3 * abs(number)

            self.hands.say(label, f"{number:.4g}")
            until(self.page, taken, f"the number for {label}", 60.0)
        self._checked()

    def _look(self) -> None:
        """No formula is missing, and no text is wider than the panel."""
        wait_frames(self.page, 2)
        wrong = self.page.evaluate(
            """() => { const bad = [];
                 for (const block of document.querySelectorAll('.duet-lesson')) {
                   if (/\\$|\\\\[a-z]/.test(block.innerText)) bad.push('unset formula: ' + block.innerText.slice(0, 80));
                   if (block.scrollWidth > block.clientWidth + 1) bad.push('too wide: ' + block.innerText.slice(0, 80));
                 }
                 for (const image of document.querySelectorAll('.duet-lesson img'))
                   if (image.complete && !image.naturalWidth) bad.push('no picture: ' + image.alt);
                 return bad; }"""
        )
        assert not wrong, wrong

    def on_to_the_next(self) -> None:
        """Go on to the next step or lesson, and wait for it."""
        here = self.run.walk.step
        self.hands.do("next")
        until(self.page, lambda: self.run.walk.step is not here, "the next step", 60.0)


def _held_at(session: Session) -> Array:
    """Where the student wants what is theirs to be, (3,) [m]."""
    assert isinstance(session.held, (BallTarget, HandTarget))
    return session.held.position.copy()


@dataclass(frozen=True)
class _Still:
    """Holds the ball at a place."""

    place: Array

    def target(self, time: float) -> BallTarget:
        """Return the place."""
        del time
        return BallTarget(self.place)
