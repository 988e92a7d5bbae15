"""One visitor's experiment."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.runtime.job_pool import Jobs
from app.session import actions
from app.session.action_handlers import ActionHandlers
from app.session.actions import ActionQueue
from app.session.clock import BUDGET, Pace, next_speed
from app.session.ghost_run import GhostRun
from app.session.input_source import source_settings, with_joint
from app.session.late_law import GHOST, LateLawMaker, LateLawStatus, no_law
from app.session.parts import SessionParts
from app.session.relevant_settings import built_of
from app.session.replay_player import ReplayPlayer, ReplayStatus
from app.session.run_control import RunControl
from app.session.visitor_hand import VisitorHand
from app.settings import Settings
from controllers.laws.situation import Unanswered
from scenes.inputs import InputsLog
from scenes.roles import room_of
from scenes.settings import changed, values
from scenes.simulation import Simulation
from scenes.targets import Target

MOST_NOTICES: Final = 16
"""Largest number of waiting notices; the oldest is dropped."""


class Session:
    """A run, and perhaps a ghost, advanced with the wall clock.

    Any thread may call `post`; the rest belongs to the thread that calls `advance`.

    Args:
        wake: requests a frame, after every `post`.
        background: None: no replays and studies.
    """

    def __init__(
        self,
        settings: Settings,
        wake: Callable[[], None] = lambda: None,
        background: Jobs | None = None,
        law: LateLawMaker = no_law,
    ) -> None:
        self.settings, self.background = settings, background
        self._ask_for_frame = wake
        self.dirty = True
        """True if anything was posted or computed since the last actions."""
        self.simulation = Simulation(settings.run)
        self.inputs = InputsLog()
        self.law = law(background, self.wake)
        self.law.in_ghost = settings.page.ghost == GHOST
        self._law_given = self.law.given
        self.ghost_run = GhostRun(settings.run, lambda: self.law)
        self._wish: tuple[Target | None] | None = None
        """Target of a step without its law's answer."""
        self.player = ReplayPlayer(self, background, self.wake)
        self.handlers = ActionHandlers()
        """Handlers of posted actions; the operator's page covers them."""
        self._add_handlers()
        self.posts = ActionQueue(self.handlers.do)
        self.control = RunControl(self)
        self.hand = VisitorHand(self)
        self.parts = SessionParts(self)
        self.notices: deque[tuple[str, str]] = deque(maxlen=MOST_NOTICES)
        """Title and text; the page that shows them removes them."""
        self.simulation.use(self.law.of_run)
        self.ghost_run.begin(settings, self.simulation)

    def wake(self) -> None:
        self.dirty = True
        self._ask_for_frame()

    def notify(self, title: str, text: str) -> None:
        self.notices.append((title, text))

    def close(self) -> None:
        self.law.close()
        for part in self.parts:
            part.close()

    @property
    def ghost(self) -> Simulation | None:
        """The second run; None without one."""
        return self.ghost_run.simulation

    @property
    def ghost_hidden(self) -> bool:
        return self.ghost_run.hidden

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        """Run and ghost; None for a hidden ghost."""
        return self.simulation, None if self.ghost_hidden else self.ghost

    @property
    def law_status(self) -> LateLawStatus:
        return self.law.status(not self.paused and self.control.slowed)

    def assign_laws(self, reset: bool) -> None:
        """Assign a changed `law` to the run or the ghost.

        `reset`: also reset the runs, because recorded inputs belong to one law.
        """
        if self.law.given is not self._law_given:
            self._law_given = self.law.given
            for part in self.parts:
                part.law_changed()
        self.simulation.use(self.law.of_run)
        if self.ghost is not None:
            self.ghost.use(self.law.of_ghost)
        if reset and self.simulation.steps:
            self.reset()

    def post(self, action: actions.Action) -> None:
        self.posts.put(action)
        self.wake()

    def _add_handlers(self) -> None:
        handlers, player = self.handlers, self.player
        # During a replay they act on the replay.
        handlers.add_first(actions.Pause, player.pause)
        handlers.add_first(actions.SingleStep, player.single_step)
        handlers.add_first(actions.Reset, player.reset)
        handlers.add(actions.Pause, lambda _: self.control.toggle_pause())
        handlers.add(actions.SingleStep, lambda _: self.control.single_step())
        handlers.add(actions.Reset, lambda _: self.reset())
        handlers.add(
            actions.ChangeSpeed,
            lambda action: self.change("speed", next_speed(self.settings.page.speed, action.by)),
        )
        handlers.add(actions.SetSetting, lambda action: self.change(action.key, action.value))
        handlers.add(actions.Digit, lambda action: self.change("scene", action.scene))
        handlers.add(actions.RestoreSettings, self._restore)
        handlers.add(actions.MoveJoint, self._move_joint)

    def _restore(self, action: actions.RestoreSettings) -> None:
        for key, value in values(action.settings).items():
            if values(self.settings)[key] != value:
                self.change(key, value)

    def _move_joint(self, action: actions.MoveJoint) -> None:
        held = with_joint(self.simulation, self.hand.held, action.joint, action.angle)
        if held is not None:
            self.hand.hold(held)

    @property
    def held(self) -> Target | None:
        return self.hand.held

    @property
    def pace(self) -> Pace:
        """State of the clock; waiting for a law does not count as slow."""
        pace, law = self.control.pace, self.law_status
        return replace(pace, slowed=False) if law.waits or law.slow or law.problem else pace

    def change(self, key: str, value: object) -> None:
        """Set one setting from the next step on.

        Raises:
            BadSetting: impossible value; nothing is changed.
        """
        before, after = self.settings, changed(self.settings, key, value)
        room_of(after.run)  # May be impossible here: a robot's package may be missing.
        self.settings, self._wish = after, None
        if built_of(before) != built_of(after):
            self.posts.rebuilt()
        roles = self.simulation.roles
        if after.run != before.run:
            self.simulation.apply(after.run)
        rebuilt = self.simulation.roles is not roles
        if after.page.source != before.page.source:
            self.hand.source.set_source(None)
        elif rebuilt or source_settings(after.run) != source_settings(before.run):
            self.hand.source.let_go()
        if after.page.autopilot and not before.page.autopilot:
            self.hand.source.restart()
        if after.page.ghost != before.page.ghost:
            self.ghost_run.frozen = after.run
            self.law.in_ghost = after.page.ghost == GHOST
            self.ghost_run.begin(after, self.simulation)
            self.assign_laws(self.law.given and GHOST in (after.page.ghost, before.page.ghost))
        elif rebuilt:
            self.ghost_run.begin(after, self.simulation)
        elif after.run != before.run:
            self.ghost_run.apply(after)
        for part in self.parts:
            part.changed(before, after, rebuilt)

    def reset(self) -> None:
        self.simulation.reset()
        if self.ghost_run.source is not None:
            self.ghost_run.begin(self.settings, self.simulation)
        elif self.ghost is not None:
            self.ghost.reset()
        for part in self.parts:
            part.reset()
        self.hand.let_go()
        self.control.forget()
        self._wish = None

    @property
    def replay(self) -> ReplayStatus:
        return ReplayStatus(coming=self.player.coming)

    @property
    def paused(self) -> bool:
        return bool(self.control.halt)

    def target(self) -> Target | None:
        return self.hand.target()

    def step_both(self) -> bool:
        """Step run and ghost; False, without a step, while a law has not answered."""
        target = self.hand.target() if self._wish is None else self._wish[0]
        runs = [(self.simulation, self.inputs)]
        if self.ghost is not None and self.ghost_run.source is None:
            # The run that may have to wait for its law is stepped first.
            runs.insert(0 if self.law.of_ghost is not None else 1, (self.ghost, self.ghost_run.inputs))
        for simulation, inputs in runs:
            inputs.record(simulation, target)
            try:
                simulation.step(target)
            except Unanswered:
                inputs.take_back()
                self._wish = (target,)
                return False
            inputs.note_answers(simulation)
        self._wish = None
        self.ghost_run.catch_up(self.simulation.time)
        self.law.step_made(self.settings.run, self.settings.page.speed)
        return True

    def advance(self, elapsed: float, budget: float = BUDGET) -> int:
        """Do one frame without a page; number of steps made."""
        self.take_actions(elapsed)
        return self.control.step(elapsed, budget)

    def take_actions(self, elapsed: float) -> None:
        """Do the actions and collect results. `elapsed`: wall time since the last frame [s]."""
        self.dirty = False
        self.law.advance(elapsed, self.paused)
        for part in self.parts:
            part.advance(elapsed)
        self.posts.do()
