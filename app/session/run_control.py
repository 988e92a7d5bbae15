"""Steps of a run: by the clock, one by one, up to a time, or none."""

from time import perf_counter
from typing import Protocol

from app.session.clock import BUDGET, Clock, Halt, Pace
from app.session.late_law import LateLaw
from app.settings import Settings
from scenes.simulation import Simulation


class Stepped(Protocol):
    settings: Settings
    simulation: Simulation
    law: LateLaw

    def step_both(self) -> bool:
        """See `app.session.session.Session.step_both`."""
        ...


class RunControl:
    """The clock of one session, and what overrides it.

    Attributes:
        stepping: wall time of the last frame's steps [s].
        frame_ends_at: time of the run that ends a frame, for a decision before the next step [s]; 0 for no
            limit.
    """

    def __init__(self, session: Stepped) -> None:
        self._session = session
        self.halt = Halt()
        self.stepping = 0.0
        self.frame_ends_at = 0.0
        self._clock = Clock(session.settings.page.speed)
        self._steps_asked, self._fast_forward_to = 0, 0.0

    def toggle_pause(self) -> None:
        """Ignored while the teacher has stopped the session."""
        if "teacher" in self.halt:
            return
        if self.halt:
            self.halt.go_on()
        else:
            self.halt.set("visitor")
        self._clock.forget()
        self._steps_asked = 0

    def single_step(self) -> None:
        if not self.halt:
            self.halt.set("visitor")
        self._steps_asked += 1

    def hurry(self, until: float) -> None:
        """Simulate as fast as possible up to a time of the run [s]; a pause or a reset ends this."""
        self.halt.go_on()
        self._fast_forward_to = until

    def forget(self) -> None:
        self._clock.forget()
        self._fast_forward_to = 0.0

    @property
    def pace(self) -> Pace:
        return self._clock.pace(bool(self.halt))

    @property
    def slowed(self) -> bool:
        return self._clock.pace(False).slowed

    def step(self, elapsed: float, budget: float = BUDGET) -> int:
        """Number of steps made in `elapsed` [s] of wall time, within `budget` [s]."""
        self.stepping = 0.0
        if "teacher" in self.halt:
            # Time missed meanwhile is not caught up.
            self._steps_asked, self._fast_forward_to = 0, 0.0
            return 0
        if "hidden" in self.halt:
            # A hurried run continues when the tab is visible again.
            return 0
        if self.halt:
            due, self._fast_forward_to = self._steps_asked, 0.0
            made = self._make(due, budget)
            self._steps_asked -= made
            return made
        session = self._session
        dt, time = session.settings.run.dt, session.simulation.time
        ahead = round((self._fast_forward_to - time) / dt)
        due = ahead if ahead > 0 else self._clock.due(elapsed, dt, session.settings.page.speed)
        left = round((self.frame_ends_at - time) / dt)
        due = min(due, left) if left > 0 else due
        made = self._make(due, budget)
        waits = session.law.waits
        if ahead <= 0:
            self._clock.note(made, made if waits else due, elapsed, dt)
        if ahead > 0 or waits:
            self._clock.forget()
        return made

    def _make(self, due: int, budget: float) -> int:
        begin, made = perf_counter(), 0
        now = begin
        while made < due and now <= begin + budget and self._session.step_both():
            made += 1
            now = perf_counter()
        self.stepping = now - begin
        return made
