"""A student in a lesson, without a page."""

from collections.abc import Callable

import numpy as np

from app.features.lessons.bookmark import Phase
from app.features.lessons.reference_runs import person_of
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.targets import HandTarget
from tests.app.features.lessons.helpers import our_book

BOOK = our_book()


class Student:
    def __init__(self, lesson: int = 0, step: int = 0, settings: Settings | None = None) -> None:
        self.session = Session(settings or Settings())
        self.run = LessonSession(self.session, BOOK)
        self.run.enter(lesson, step)

    def frame(self, elapsed: float = 0.05) -> None:
        self.session.advance(elapsed)
        self.run.decide()
        assert np.isfinite(self.session.simulation.positions).all()

    def frames_until(self, true: Callable[[], object], elapsed: float = 0.05) -> None:
        assert any(self.frame(elapsed) or true() for _ in range(4000)), "the run does not end"

    def finish(self) -> None:
        self.run.act(do.Press("run"))
        self.run_out()

    def run_out(self) -> None:
        self.run.runner.further.result(60.0)
        session, run = self.session, self.run
        self.frames_until(
            lambda: (
                session.paused
                and not run.computing
                and (run.runner.further.done() or session.simulation.steps == 0)
            )
        )
        self.run.decide()

    def to_challenge(self) -> None:
        """Continue to the step's challenge; skip the parts before it."""
        while self.run.walk.phase is not Phase.CHALLENGE:
            self.run.act(do.Press("next"))
            self.frame(0.0)

    def swing(self) -> None:
        """Drag the elbow from mark to mark until the present run is long enough."""
        setup = next(trial.setup for trial in self.run.walk.step.trials if not trial.fails)
        person = person_of(self.session.simulation, setup)
        while self.session.simulation.time < setup.seconds:
            self.session.hand.hold(person.target(self.session.simulation.time))
            self.frame(0.02)


def duel() -> Student:
    """Student before the first push of the duel (lesson *hold*)."""
    one = Student(BOOK.index("hold"), 2)
    one.to_challenge()
    return one


def push(one: Student, fast: float, then: float | None = None) -> None:
    """Push the hand at the other one for 1 s, and count it. `then`: another top speed for the second half."""
    session, run = one.session, one.run
    session.change("wmax", fast)
    run.act(do.Press("again"))
    pose = session.simulation.kinematics.hand_pose(session.hand.arm)
    place, turn = pose.translation.copy(), pose.rotation.copy()
    while session.simulation.time < 1.0:
        place[0] -= 0.05 * fast
        session.hand.hold(HandTarget(place.copy(), turn))
        one.frame()
        if then is not None and session.simulation.time > 0.5:
            session.change("wmax", then)
    run.act(do.Press("check"))
