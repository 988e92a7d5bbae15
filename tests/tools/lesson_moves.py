"""What a student sets and moves in a challenge: settings with the page's controls, hand, ball and elbow with the keys of every page."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from playwright.sync_api import Page

from app.features.lessons.lesson import Trial
from app.features.lessons.panel.null_motion_sliders import LABELS
from app.features.lessons.session.lesson_session import LessonSession
from app.features.measures.room_places import mark_places, start_positions
from app.session.session import Session
from controllers.kinematics import Array
from scenes.settings import values
from scenes.targets import BallTarget, HandTarget
from tests.app.conftest import ask
from tests.app.page.by_hand import hands_of
from tests.browser import until
from tests.tools.lesson_hands import Hands

LONG = 180.0  # a run on a busy machine [s]
SETTLING = 4.0  # until an arm has given way to a ball that stays where it is [s]
FAST = 0.8  # speed limit for a push by arrows, which do not meet the other hand as squarely as a script does [m/s]
AHEAD = 0.25  # how far ahead of the hand the target of a straight push is [m]
STEP = 0.02  # how far an arrow moves hand or ball [m]
BURST = 8  # presses of keys between two frames, as of a key that is held down


class LessonMoves:
    """Does what a trial of a challenge does. See `Walker`."""

    def __init__(self, page: Page, session: Session, run: LessonSession, hands: Hands) -> None:
        self.page, self.session, self.run, self.hands = page, session, run, hands

    def settings(self, trial: Trial, **further: float) -> None:
        """Set what a trial sets, with the page's own controls, and further settings."""
        for key, value in (values(trial.setup.settings(self.session.settings).run) | further).items():
            if values(self.session.settings)[key] != value:
                self.hands.set(key, value)
                until(
                    self.page,
                    lambda key=key, value=value: values(self.session.settings)[key] == value,
                    f"{key} = {value}",
                )

    def move(self, trial: Trial) -> None:
        """Move what a trial's person moves, as far, in a fresh run with the trial's settings."""
        session, page = self.session, self.page
        if trial.setup.input.kind == "none":
            self.settings(trial)
            positions = ask(session, lambda s: start_positions(s.simulation.room, trial.setup.start))
            ball = session.simulation.room.ball
            assert positions is not None and ball is not None
            place = positions[ball].copy()
            self._steer(lambda _: place, lambda s: bool(np.linalg.norm(place - held_at(s)) < STEP))
            settled = session.simulation.time + SETTLING
            until(page, lambda: session.simulation.time > settled, "the arm at rest", LONG)
        elif trial.setup.input.name == "elbow_to":
            self.settings(trial)
            self._fresh_run()
            self._swing()
        elif trial.setup.input.name == "null_motions":
            self._fresh_run()
            ways = dict(trial.setup.input.parameters)
            for label, way in zip(
                LABELS, (ways.get(name, 0.0) for name in ("swing", "x", "y", "z")), strict=True
            ):
                if way:
                    still = ask(session, lambda s: s.simulation.positions.copy())
                    self.hands.slide(label, f"{np.degrees(way):.0f}")

                    def begun(still: Array = still) -> bool:
                        return bool(np.abs(session.simulation.positions - still).max() > 0.01)

                    # One motion after the other: together they may leave the elbow where it was.
                    until(page, begun, "a motion")
                    until(
                        page,
                        lambda: bool(np.abs(session.simulation.velocities).max() < 1e-3),
                        "the end of it",
                        LONG,
                    )
        else:
            # In slow motion, at the other hand, until it is 10 mm nearer than d_m.
            self.settings(trial, wmax=FAST)
            ask(session, lambda s: s.change("speed", 0.25))
            start, other = ask(session, hands_of)
            straight = (other - start) / np.linalg.norm(other - start)
            nearest = float(values(session.settings)["dm"]) - 0.01
            self._steer(
                lambda s: start + (float((hands_of(s)[0] - start) @ straight) + AHEAD) * straight,
                lambda s: s.simulation.sample().distance <= nearest,
            )

    def _fresh_run(self) -> None:
        """Begin the run again, with the focus where keys are the page's."""
        turn, before = self.run.walk.run_id, max(self.session.simulation.time, 2.0)
        self.hands.do("again")
        until(
            self.page,
            lambda: self.run.walk.run_id != turn and self.session.simulation.time < before,
            "a fresh run",
        )
        self.page.evaluate("document.activeElement?.blur()")

    def _swing(self) -> None:
        """Swing the elbow to both marks with J and K."""
        low, high = mark_places(self.session.simulation.room, self.run.walk.step.marks)
        for mark in (high, low):

            def there(mark: Array = mark) -> bool:
                miss = mark - ask(
                    self.session, lambda s: s.simulation.kinematics.joint_point(s.simulation.guided.elbow)
                )
                if np.linalg.norm(miss) < 0.012:
                    return True
                self.page.keyboard.press("J" if miss @ (high - low) > 0.0 else "K")
                return False

            until(self.page, there, "the mark", LONG)

    def _steer(self, goal: Callable[[Session], Array], done: Callable[[Session], bool]) -> None:
        """Move hand or ball with the arrows to a goal that may move, in a fresh run, once it is known how far each key moves it."""
        session, page, ways = self.session, self.page, dict[str, Array]()
        self._fresh_run()
        page.keyboard.press("ArrowUp")
        until(page, lambda: session.held is not None, "something held")
        for key in ("ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "PageDown"):
            before = ask(session, held_at)
            page.keyboard.press(key)
            until(page, lambda before=before: bool(np.abs(held_at(session) - before).max() > 1e-4), key)
            ways[key] = ask(session, held_at) - before
        self._fresh_run()

        def there() -> bool:
            over, rest = ask(session, lambda s: (done(s), goal(s) - held_at(s)))
            for _ in range(0 if over else BURST):
                key = min(ways, key=lambda key: float(np.linalg.norm(rest - ways[key])))
                if np.linalg.norm(rest - ways[key]) >= np.linalg.norm(rest):
                    break
                page.keyboard.press(key)
                rest = rest - ways[key]
            return over

        until(page, there, "the place", LONG)


def held_at(session: Session) -> Array:
    """Where the student wants what is theirs to be, or where it is while nothing is wanted (3,) [m]."""
    if isinstance(session.held, (BallTarget, HandTarget)):
        return session.held.position.copy()
    ball = session.simulation.room.ball
    return hands_of(session)[0] if ball is None else session.simulation.positions[ball].copy()
