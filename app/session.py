"""One visitor's experiment and its clock: pause, single step, slow motion, reset, and who moves the guided arm."""

import logging
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Final

import numpy as np

from app.settings import Settings
from controllers.kinematics import Array
from scenes.autopilot import Autopilot
from scenes.settings import changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget

log = logging.getLogger("duet.session")

BUDGET: Final = 0.02
"""Wall time that one session may use for its steps in one frame [s]; beyond it simulated time slows down, but no step is dropped."""

LONGEST_GAP: Final = 0.1
"""A pause of the program (a closed laptop, a debugger) is not caught up beyond this [s]."""

SPEEDS: Final = (0.25, 0.5, 1.0, 2.0)
"""What the speed may be, simulated over wall time."""


@dataclass(frozen=True)
class Pace:
    """How the clock runs.

    Attributes:
        paused: nothing moves.
        rate: simulated seconds per wall second, over the last half second or so.
        slowed: the machine cannot keep up with the speed asked for.
    """

    paused: bool
    rate: float
    slowed: bool


class Session:
    """A simulation that runs with the wall clock.

    All methods but `post` belong to the one thread that calls `advance`; `post` may be called from anywhere.

    Args:
        settings: of the run and of the page.
        wake: called after every `post`, so that whoever draws need not wait for the next regular frame.
    """

    def __init__(self, settings: Settings, wake: Callable[[], None] = lambda: None) -> None:
        self.settings = settings
        self._wake = wake
        self.simulation = Simulation(settings.run)
        self.paused = False
        self.held: HandTarget | None = None
        """Where a person holds the guided hand; None while nobody touches it."""
        self._posts: deque[Callable[[], None]] = deque()
        self._debt = 0.0
        self._steps_asked = 0
        self._rate = settings.page.speed
        self._slowness = 0.0
        self._autopilot: Autopilot | None = None
        self._autopilot_begin = 0.0

    def post(self, action: Callable[[], None]) -> None:
        """Have something done at the beginning of the next frame, on the session's own thread."""
        self._posts.append(action)
        self._wake()

    @property
    def pace(self) -> Pace:
        """How the clock runs now."""
        return Pace(self.paused, 0.0 if self.paused else self._rate, self._slowness > 0.5)

    def change(self, key: str, value: object) -> None:
        """Set one setting, from the next step on.

        Raises:
            BadSetting: impossible value; nothing is changed.
        """
        before, after = self.settings, changed(self.settings, key, value)
        self.settings = after
        if after.run != before.run:
            self.simulation.apply(after.run)
        if (after.run.rig, after.run.guided) != (before.run.rig, before.run.guided):
            self.held = None
        if (after.run.rig, after.run.guided, after.run.seed) != (before.run.rig, before.run.guided, before.run.seed) or (
            after.page.autopilot and not before.page.autopilot
        ):
            self._autopilot = None

    def hold(self, target: HandTarget | None) -> None:
        """A person takes hold of the guided hand, moves it, or (None) lets go of it."""
        if target is not None and self.settings.page.autopilot:
            self.settings = replace(self.settings, page=replace(self.settings.page, autopilot=False))
        self.held = target

    def nudge(self, way: Array) -> None:
        """Move the place where the person holds the hand by (3,) [m], world."""
        simulation = self.simulation
        pose = simulation.kinematics.hand_pose(simulation.guided)
        held = self.held or HandTarget(pose.translation.copy(), pose.rotation.copy())
        # A key held down must not run further ahead than an arm's length.
        place = np.clip(held.position + way, pose.translation - 0.3, pose.translation + 0.3)
        self.hold(HandTarget(place, held.rotation))

    def reset(self) -> None:
        """Begin anew: as a fresh start with the present settings."""
        self.simulation.reset()
        self.held = None
        self._autopilot = None
        self._debt = 0.0

    def toggle_pause(self) -> None:
        """Pause or go on."""
        self.paused = not self.paused
        self._debt, self._steps_asked = 0.0, 0

    def single_step(self) -> None:
        """Pause, and make one step."""
        self.paused = True
        self._steps_asked += 1

    def change_speed(self, by: int) -> None:
        """Take the next slower (−1) or faster (+1) speed."""
        nearest = min(range(len(SPEEDS)), key=lambda i: abs(SPEEDS[i] - self.settings.page.speed))
        self.change("speed", SPEEDS[min(max(nearest + by, 0), len(SPEEDS) - 1)])

    def target(self) -> HandTarget | None:
        """Return where the person, or the autopilot, wants the guided hand now."""
        if self.held is not None:
            return self.held
        if not self.settings.page.autopilot:
            return None
        simulation = self.simulation
        if self._autopilot is None:
            start = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
            self._autopilot = Autopilot(simulation.room, self.settings.run.guided, self.settings.run.seed, start)
            self._autopilot_begin = simulation.time
        return self._autopilot.target(simulation.time - self._autopilot_begin)

    def advance(self, elapsed: float) -> int:
        """Do what was posted, then simulate `elapsed` seconds of wall time; return the number of steps made."""
        while self._posts:
            action = self._posts.popleft()
            try:
                action()
            except Exception:
                # One visitor's odd input must not stop the clock of all.
                log.exception("an action of the page failed and was left out")
        if self.paused:
            steps, self._steps_asked = self._steps_asked, 0
            for _ in range(steps):
                self.simulation.step(self.target())
            return steps
        dt, speed = self.settings.run.dt, self.settings.page.speed
        self._debt += min(elapsed, LONGEST_GAP) * speed
        wanted, made = int(self._debt / dt + 1e-9), 0
        deadline = perf_counter() + BUDGET
        while made < wanted:
            self.simulation.step(self.target())
            made += 1
            if made % 8 == 0 and perf_counter() > deadline:
                break
        late = made < wanted or elapsed > LONGEST_GAP
        self._debt = 0.0 if late else self._debt - made * dt
        if elapsed > 0.0:
            share = min(elapsed / 0.5, 1.0)
            self._rate += (made * dt / elapsed - self._rate) * share
            self._slowness += ((1.0 if late else 0.0) - self._slowness) * min(elapsed / 1.0, 1.0)
        return made
