"""Nothing that a student does leaves a lesson stuck: odd actions in any order, and then the way out and the way on."""

import contextlib
import math
import random
from collections.abc import Callable

import numpy as np
import pytest

from app.lessons.loading import load_lessons
from app.lessons.phases import Phase
from app.lessons.session.lesson_actions import (
    Check,
    Choose,
    GoBack,
    GoOn,
    GoTo,
    Leave,
    LessonAction,
    ResetStep,
    RunAgain,
    ShowHint,
    ShowWhy,
    StartOrPause,
)
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadSetting
from scenes.settings import Spec, specs
from scenes.targets import BallTarget, HandTarget

BOOK = load_lessons()
ACTIONS: tuple[Callable[[random.Random], LessonAction], ...] = (
    lambda rng: Choose(rng.randrange(6)),
    lambda rng: GoTo(rng.randrange(12), rng.randrange(6)),
    *[
        lambda _, action=action: action()
        for action in (GoOn, GoOn, GoBack, StartOrPause, StartOrPause, RunAgain, ResetStep, ShowWhy, Check, ShowHint, Leave)
    ],
)
OTHERS = ("pause", "step", "reset", "setting", "setting", "hold", "let go", "autopilot", "frames", "frames", "reload")


class Student:
    """Does anything, in any order, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.session = Session(Settings())
        self.run = LessonSession(self.session, BOOK)
        self.run.enter(self.rng.randrange(len(BOOK.lessons)))

    def frame(self, elapsed: float = 0.03) -> None:
        """What the frame loop does."""
        self.session.advance(elapsed)
        self.run.decide()
        assert np.isfinite(self.session.simulation.positions).all()

    def act(self) -> None:
        """One thing a student may do in the lessons, or beside them."""
        self.run.act(self.rng.choice(ACTIONS)(self.rng))

    def meddle(self) -> None:
        """One thing a student may do with the controls, the handles or the tab."""
        session, rng = self.session, self.rng
        match rng.choice(OTHERS):
            case "pause":
                session.toggle_pause()
            case "step":
                session.single_step()
            case "reset":
                session.reset()
            case "setting":
                key = rng.choice(list(specs(Settings)))
                with contextlib.suppress(BadSetting):
                    session.change(key, some_value(rng, specs(Settings)[key]))
            case "hold" if not self.run.hands_off:
                place = np.array([rng.uniform(-1.0, 1.0) for _ in range(3)])
                session.hold(rng.choice((HandTarget(place), BallTarget(place))))
            case "let go":
                session.hold(None)
            case "autopilot":
                session.change("autopilot", not session.settings.page.autopilot)
            case "reload":
                saved = self.run.saved()
                assert saved is not None
                self.session = Session(Settings())
                self.run = LessonSession(self.session, BOOK)
                self.run.resume(saved, reopen=True)
            case _:
                for _ in range(rng.randrange(1, 60)):
                    self.frame(0.1)


def some_value(rng: random.Random, spec: Spec) -> object:
    """A value that a control could give, or nearly."""
    if spec.choices:
        return rng.choice(spec.choices)
    if math.isinf(spec.low) or math.isinf(spec.high):
        return rng.random() < 0.5
    return rng.uniform(spec.low, spec.high)


@pytest.mark.parametrize("seed", [3, 7])
def test_whatever_is_done_there_is_a_way_on_and_a_fresh_start(seed: int, caplog: pytest.LogCaptureFixture) -> None:
    student = Student(seed)
    for _ in range(30):
        student.rng.choice((student.act, student.meddle))()
        student.frame()
        if not student.run.open:
            student.run.enter()
    run = student.run
    last = run.walk.lesson is BOOK.lessons[-1] and run.walk.step is run.walk.lesson.steps[-1]
    here = run.walk.step
    for _ in range(20):
        if run.walk.locked:
            run.act(Choose(0))
        run._runs.wait(60.0)
        run.act(GoOn())
        student.frame()
    assert run.walk.step is not here or (last and run.walk.phase is run.walk.phases[-1]), "next gets on"
    run.act(ResetStep())
    student.frame()
    assert run.walk.phase is run.walk.phases[0] and (student.session.paused or not run.walk.locked)
    if run.walk.locked:
        run.act(Choose(0))
    assert run.walk.phase is Phase.DO
    student.session.change("speed", 2.0)
    student.session.halt.go_on()
    run._runs.wait(60.0)
    for _ in range(4000):
        if run.walk.phase is not Phase.DO or run.walk.yours:
            break
        student.frame(0.1)
    else:
        raise AssertionError("the run does not end")
    assert not [record for record in caplog.records if record.exc_info], caplog.text
