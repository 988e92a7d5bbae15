"""Actions of a visitor, and their queue."""

import itertools
import logging
import threading
from collections import deque
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from time import perf_counter
from typing import ClassVar, Final, Literal, dataclass_transform

from app.settings import Settings
from app.web.entries import claim_entry
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class Action:
    """Base class of actions; every subclass is a frozen dataclass.

    Attributes:
        newest_by: a newer action with equal values of these fields replaces a waiting one; None: every one
            counts.
    """

    newest_by: ClassVar[tuple[str, ...] | None]

    def __init_subclass__(cls, *, newest_by: tuple[str, ...] | None = (), eq: bool = True) -> None:
        cls.newest_by = newest_by
        dataclass(frozen=True, eq=eq)(cls)

    @property
    def control(self) -> Hashable:
        """Key under which actions replace each other; None if every press counts."""
        return (
            None
            if self.newest_by is None
            else (type(self), *(getattr(self, name) for name in self.newest_by))
        )


class Pause(Action, newest_by=None):
    """Pause or resume."""


class SingleStep(Action, newest_by=None):
    """Pause and make one step."""


class Reset(Action):
    """Restart the run."""


class ChangeSpeed(Action, newest_by=None):
    by: Literal[-1, 1]


class SetSetting(Action, newest_by=("key",)):
    key: str
    value: object


class Digit(Action):
    """A digit, from 1: chooses an experiment, or an answer."""

    number: int

    @property
    def control(self) -> Hashable:
        return SetSetting("scene", self.number).control

    @property
    def scene(self) -> str:
        return tuple(EXPERIMENTS)[self.number - 1]


class MoveJoint(Action, newest_by=("joint",)):
    """Hold a joint of the guided arm, counted from 0, at an angle [rad]."""

    joint: int
    angle: float


class Drag(Action, newest_by=("handle", "phase"), eq=False):
    """Drag a handle of the 3-D view.

    Attributes:
        handle: name of the handle or of the node.
        phase: "start", "update" or "end".
        place: (3,) [m].
        turn: (3, 3); None for handles that do not turn.
        taken: grasped point (3,) [m], or None.
    """

    handle: str
    phase: str
    place: Array
    turn: Array | None = None
    taken: Array | None = None


class Toggle(Action, newest_by=None):
    what: Literal["autopilot", "avoidance", "ghost", "gizmo", "contact"]


class Hover(Action):
    on: bool


class Nudge(Action, newest_by=None):
    """Steps of the hand or the ball along the axes of the visitor's view."""

    right: int = 0
    up: int = 0
    away: int = 0


class SwingElbow(Action, newest_by=None):
    sign: Literal[-1, 1]


class FirstView(Action):
    """Reset the visitor's camera."""


class Describe(Action):
    """Describe the scene."""


class ShowAll(Action):
    """Show all settings, or only the usual ones."""

    whole: bool = True


class RestoreSettings(Action):
    settings: Settings


log = logging.getLogger("duet.session")

BUDGET: Final = 0.010
"""Longest time for actions in one frame [s]."""

MOST_REBUILDS: Final = 4

PERIOD: Final = 1.0
"""[s]"""

MOST_PRESSES: Final = 64


class ActionQueue:
    """Waiting actions in order. Any thread may call `put`; the rest belongs to the session's thread.
    `clock`: returns the time [s]."""

    def __init__(self, handle: Callable[[Action], object], clock: Callable[[], float] = perf_counter) -> None:
        self._handle, self._clock = handle, clock
        self._lock = threading.Lock()
        self._waiting: dict[Hashable, tuple[Action, Callable[[], None]]] = {}
        self._presses = itertools.count()
        self._rebuilds: deque[float] = deque(maxlen=MOST_REBUILDS)
        self._rebuilding = False

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, action: Action) -> None:
        """Replaces a waiting action of the same control."""
        control = action.control
        with self._lock:
            if control is None:
                if len(self._waiting) >= MOST_PRESSES:
                    return
                control = ("press", next(self._presses))
            # The newest goes to the end, after all earlier requests.
            self._leave_out(control)
            self._waiting[control] = action, claim_entry()

    def rebuilt(self) -> None:
        self._rebuilding = True

    def drop(self) -> None:
        with self._lock:
            for control in tuple(self._waiting):
                self._leave_out(control)

    def _leave_out(self, control: Hashable) -> None:
        _, end_entry = self._waiting.pop(control, (None, None))
        if end_entry is not None:
            end_entry()

    def do(self) -> None:
        """Do the waiting actions, within `BUDGET` and the limit on rebuilt pages."""
        deadline = self._clock() + BUDGET
        # Only after an action is it known whether it rebuilt the page, so stop at the limit.
        while self._may_rebuild() and (waited := self._next()) is not None:
            self._rebuilding = False
            action, end_entry = waited
            # From here on what the action writes into the control is newer.
            end_entry()
            try:
                self._handle(action)
            except Exception:
                # One visitor's odd input must not stop the clock of all.
                log.exception("an action of the page failed and was left out")
            now = self._clock()
            if self._rebuilding:
                self._rebuilds.append(now)
            if now >= deadline:
                return

    def _may_rebuild(self) -> bool:
        return len(self._rebuilds) < MOST_REBUILDS or self._clock() - self._rebuilds[0] >= PERIOD

    def _next(self) -> tuple[Action, Callable[[], None]] | None:
        with self._lock:
            first = next(iter(self._waiting), None)
            return None if first is None else self._waiting.pop(first)
