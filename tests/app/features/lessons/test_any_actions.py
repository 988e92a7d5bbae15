"""After any actions in any order, a lesson is never stuck and loses nothing."""

import contextlib
import math
import random

import numpy as np
import pytest

from app.features.lessons.bookmark import Phase
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadSetting
from scenes.settings import specs
from scenes.targets import BallTarget, HandTarget
from tests.app.features.lessons.student import BOOK, Student

PRESSES = 2 * (do.Press("next"), do.Press("run")) + tuple(
    do.Press(what) for what in ("back", "again", "reset", "why", "check", "hint", "leave")
)


class WildStudent(Student):
    """Random actions, reproducible by the seed."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        super().__init__(self.rng.randrange(len(BOOK.lessons)))

    def act(self) -> None:
        others = (do.Choose(self.rng.randrange(6)), do.GoTo(self.rng.randrange(12), self.rng.randrange(6)))
        self.run.act(self.rng.choice((*others, *PRESSES)))

    def meddle(self) -> None:
        """One random action with the controls, the handles or the tab."""
        session, rng = self.session, self.rng
        place = np.array([rng.uniform(-1.0, 1.0) for _ in range(3)])
        match rng.choice(
            ("pause", "step", "reset", "setting", "setting", "hold", "let go", "autopilot", "", "", "reload")
        ):
            case "pause":
                session.control.toggle_pause()
            case "step":
                session.control.single_step()
            case "reset":
                session.reset()
            case "setting":
                key, spec = rng.choice(list(specs(Settings).items()))
                number = (
                    rng.uniform(spec.low, spec.high)
                    if math.isfinite(spec.high - spec.low)
                    else rng.random() < 0.5
                )
                with contextlib.suppress(BadSetting):
                    session.change(key, rng.choice(spec.choices) if spec.choices else number)
            case "hold" if not self.run.hands_off:
                session.hand.hold(rng.choice((HandTarget(place), BallTarget(place))))
            case "let go":
                session.hand.hold(None)
            case "autopilot":
                session.change("autopilot", not session.settings.page.autopilot)
            case "reload":
                saved = self.run.saved_lesson()
                assert saved is not None
                self.session = Session(Settings())
                self.run = LessonSession(self.session, BOOK)
                self.run.resume(saved, reopen=True)
            case _:
                for _ in range(rng.randrange(1, 60)):
                    self.frame(0.1)


@pytest.mark.usefixtures("fast_machine")
@pytest.mark.parametrize("seed", [3, 7])
def test_after_any_actions_a_lesson_can_continue_and_restart(
    seed: int, caplog: pytest.LogCaptureFixture
) -> None:
    student = WildStudent(seed)
    for _ in range(30):
        student.rng.choice((student.act, student.meddle))()
        student.frame(0.03)
        if not student.run.open:
            student.run.enter()
    run, here = student.run, student.run.walk.step
    last = run.walk.lesson is BOOK.lessons[-1] and here is run.walk.lesson.steps[-1]
    for _ in range(20):
        if run.walk.locked:
            run.act(do.Choose(0))
        run.runner.further.result(60.0)
        run.act(do.Press("next"))
        student.frame(0.03)
    assert run.walk.step is not here or (last and run.walk.phase is run.walk.phases[-1]), (
        "*next* reaches another step"
    )
    run.act(do.Press("reset"))
    student.frame(0.03)
    assert run.walk.phase is run.walk.phases[0] and (student.session.paused or not run.walk.locked)
    if run.walk.locked:
        run.act(do.Choose(0))
    assert run.walk.phase is Phase.DO
    student.session.change("speed", 2.0)
    student.session.control.halt.go_on()
    run.runner.further.result(60.0)
    student.frames_until(lambda: run.walk.phase is not Phase.DO or run.walk.yours, 0.1)
    assert not [record for record in caplog.records if record.exc_info], caplog.text
