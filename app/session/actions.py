"""What a visitor can ask for with a key, a control or a handle, as typed values; and the queue in which they wait for their session."""

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
    """What waits in a queue: every subclass is a frozen dataclass. An action of one room stands beside what does it.

    Attributes:
        newest_by: names of fields; an action drops an older one of its class with the same values there. None where every one counts.
    """

    newest_by: ClassVar[tuple[str, ...] | None]

    def __init_subclass__(cls, *, newest_by: tuple[str, ...] | None = (), eq: bool = True) -> None:
        cls.newest_by = newest_by
        dataclass(frozen=True, eq=eq)(cls)

    @property
    def control(self) -> Hashable:
        """The control on which it replaces an older one while both wait; None where every press counts."""
        return None if self.newest_by is None else (type(self), *(getattr(self, name) for name in self.newest_by))


class Pause(Action, newest_by=None):
    """Pause, or go on."""


class SingleStep(Action, newest_by=None):
    """Pause, and make one step."""


class Reset(Action):
    """Start the run from its beginning."""


class ChangeSpeed(Action, newest_by=None):
    """Take the next slower (−1) or faster (+1) speed."""

    by: Literal[-1, 1]


class SetSetting(Action, newest_by=("key",)):
    """Set one setting, named by its key."""

    key: str
    value: object


class Digit(Action):
    """A digit, from 1: the experiment of that number in the picker; an answer of that number where one is asked for."""

    number: int

    @property
    def control(self) -> Hashable:
        return SetSetting("scene", self.number).control

    @property
    def scene(self) -> str:
        """Name of the experiment."""
        return tuple(EXPERIMENTS)[self.number - 1]


class MoveJoint(Action, newest_by=("joint",)):
    """Hold the guided arm with one joint, counted from 0, at an angle [rad]."""

    joint: int
    angle: float


class Drag(Action, newest_by=("handle", "phase"), eq=False):
    """Pull at a handle of the stage.

    Attributes:
        handle: its name, or that of the node of the stage.
        phase: "start", "update" or "end".
        place: where it is pulled to (3,) [m].
        turn: how it is turned (3, 3); None where it cannot be.
        taken: where the mouse took hold of it (3,) [m]; None where that does not matter.
    """

    handle: str
    phase: str
    place: Array
    turn: Array | None = None
    taken: Array | None = None


class Toggle(Action, newest_by=None):
    """Switch the autopilot, the avoidance, the ghost, the arrows or what the scene shows of λ on or off."""

    what: Literal["autopilot", "avoidance", "ghost", "gizmo", "contact"]


class Hover(Action):
    """Show the arrows on the hand or the ball while the pointer is there, or no more."""

    on: bool


class Nudge(Action, newest_by=None):
    """Move the hand or the ball by one step along each axis of the visitor's view."""

    right: int = 0
    up: int = 0
    away: int = 0


class SwingElbow(Action, newest_by=None):
    """Swing the elbow by one step to one side (+1) or the other (−1)."""

    sign: Literal[-1, 1]


class FirstView(Action):
    """Point the visitor's camera as at the start."""


class Describe(Action):
    """Say in a sentence what is to be seen."""


class ShowAll(Action):
    """Show all settings in the panel, or few."""

    whole: bool = True


class RestoreSettings(Action):
    """Set every setting that differs from these."""

    settings: Settings


log = logging.getLogger("duet.session")

BUDGET: Final = 0.010
"""Wall time in one frame after which what still waits is left for the next one [s]."""

MOST_REBUILDS: Final = 4
"""How often in `PERIOD` a session's page is built again, however often its visitor asks for it."""

PERIOD: Final = 1.0
"""[s]"""

MOST_PRESSES: Final = 64
"""Actions of no control that may wait; one more is left out."""


class ActionQueue:
    """Actions in the order in which they were asked for. `put` may be called from any thread, the rest from the session's only.

    Args:
        handle: does an action.
        clock: returns the time [s].
    """

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
        """Queue an action; an older one of its control is dropped if it still waits."""
        control = action.control
        with self._lock:
            if control is None:
                if len(self._waiting) >= MOST_PRESSES:
                    return
                control = ("press", next(self._presses))
            # The newest goes to the end: what was asked for in between comes before it.
            self._leave_out(control)
            self._waiting[control] = action, claim_entry()

    def rebuilt(self) -> None:
        """Note that the action which is being done has the page built again."""
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
        """Do what waits, in order, until `BUDGET` is spent or the page was built again too often for one more time."""
        deadline = self._clock() + BUDGET
        # Which action builds is known only once it is done, so that none goes on where none may build.
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
