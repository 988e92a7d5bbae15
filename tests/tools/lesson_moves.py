"""A student's settings and moves in a challenge: the page's controls; hand, ball and elbow by keys."""

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

LONG = 180.0  # longest run on a busy machine [s]
SETTLING = 4.0  # until an arm rests after avoiding a resting ball [s]
FAST = 0.8  # speed limit for a push by arrows, which meets the other hand less squarely than a script's [m/s]
AHEAD = 0.25  # distance of a straight push's target ahead of the hand [m]
STEP = 0.02  # motion of hand or ball per arrow key [m]
BURST = 8  # key presses between two frames, like a held key


class LessonMoves:
    """Does the actions of a challenge's trial. See `Walker`."""

    def __init__(self, page: Page, session: Session, run: LessonSession, hands: Hands) -> None:
        self.page, self.session, self.run, self.hands = page, session, run, hands

    def settings(self, trial: Trial, **further: float) -> None:
        """Enter a trial's settings, and further ones, with the page's own controls."""
        for key, value in (values(trial.setup.settings(self.session.settings).run) | further).items():
            if values(self.session.settings)[key] != value:
                self.hands.set(key, value)
                until(
                    self.page,
                    lambda key=key, value=value: values(self.session.settings)[key] == value,
                    f"{key} = {value}",
                )

    def move(self, trial: Trial) -> None:
        """Repeat the motion of a trial's person in a fresh run with the trial's settings."""
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

                    # One motion after the other: together they may not move the elbow.
                    until(page, begun, "a motion")
                    until(
                        page,
                        lambda: bool(np.abs(session.simulation.velocities).max() < 1e-3),
                        "the end of it",
                        LONG,
                    )
        else:
            # In slow motion, towards the other hand, until it is 10 mm nearer than d_m.
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
        """Restart the run, and remove the focus so that keys reach the page."""
        turn, before = self.run.walk.run_id, max(self.session.simulation.time, 2.0)
        self.hands.do("again")
        until(
            self.page,
            lambda: self.run.walk.run_id != turn and self.session.simulation.time < before,
            "a fresh run",
        )
        self.page.evaluate("document.activeElement?.blur()")

    def _swing(self) -> None:
        """Swing the elbow to both marks by J and K."""
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
        """Move hand or ball by arrows to a goal, which may move, after a measurement of each key's motion."""
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
    """Wanted place of the student's hand or ball, or its present one if nothing is held (3,) [m]."""
    if isinstance(session.held, (BallTarget, HandTarget)):
        return session.held.position.copy()
    ball = session.simulation.room.ball
    return hands_of(session)[0] if ball is None else session.simulation.positions[ball].copy()
