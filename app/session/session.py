"""One visitor's experiment: its run and the ghost beside it, paused, stepped, reset, changed, and advanced with the wall clock."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter
from typing import Final

from app.runtime.job_pool import Jobs
from app.session import actions
from app.session.action_handlers import ActionHandlers
from app.session.actions import ActionQueue
from app.session.clock import BUDGET, Clock, Halt, Pace, Reason, next_speed
from app.session.ghost_run import GhostRun
from app.session.input_source import InputSource, nudged, source_settings, with_joint
from app.session.late_law import GHOST, LateLawMaker, LateLawStatus, no_law
from app.session.parts import SessionParts
from app.session.relevant_settings import built_of
from app.session.replay_player import ReplayPlayer
from app.session.run_limits import RunLimits
from app.session.session_state import LASTING, RunState, SessionState, common_pieces, resumed
from app.settings import Settings
from controllers.kinematics import Arm, Array
from controllers.laws.situation import Law, Unanswered
from scenes.inputs import InputsLog
from scenes.roles import TargetSource, room_of
from scenes.run_text import on_grid
from scenes.settings import changed, values
from scenes.simulation import Simulation
from scenes.targets import HandTarget, HeldTarget, LinkTarget, PairTarget, Target

MOST_NOTICES: Final = 16
"""Notices that wait for a page; the oldest makes room."""


class Session:
    """A simulation that runs with the wall clock, and perhaps a second one, the ghost, on the same inputs.

    All methods but `post` belong to the one thread that calls `advance`; `post` may be called from anywhere.

    Args:
        settings: of the run and of the page.
        wake: called after every `post`, to ask for a frame at once.
        background: where replays, and what features study, are computed; without one they are not.
        law: makes a law that may answer later, for the run or the ghost.
    """

    # Of a replay, see `app.session.shown.Shown`.
    replay_time, replayed_file, reviewed, mark = None, "", False, None

    def __init__(
        self,
        settings: Settings,
        wake: Callable[[], None] = lambda: None,
        background: Jobs | None = None,
        law: LateLawMaker = no_law,
    ) -> None:
        self.settings, self.background = settings, background
        self._ask_for_frame = wake
        self.stirred = True
        """Whether anything was posted, or anything that was computed has come, since actions were last taken."""
        self.simulation = Simulation(settings.run)
        self.halt = Halt()
        """Why no step is made, if none is."""
        self.inputs = InputsLog()
        """What the run was made with."""
        self.law = law(background, self.wake)
        """A law that may answer later, which the run or the ghost may use instead of the settings' law."""
        self.law.in_ghost = settings.page.ghost == GHOST
        self._ghost = GhostRun(settings.run, lambda: self.law)
        self._wish: tuple[Target | None] | None = None
        """The target of a step that its law has not answered yet."""
        self.player = ReplayPlayer(self, background, self.wake)
        """Replays in the place of the live run."""
        self.handlers = ActionHandlers()
        """Handlers of what is posted: the session's own, and over them those of the page that operates it."""
        self._add_handlers()
        self.posts = ActionQueue(self.handlers.do)
        self._clock = Clock(settings.page.speed)
        self.stepping = 0.0
        """Wall time of the steps of the last frame [s]."""
        self._steps_asked, self._hurries_to = 0, 0.0
        self.limits = RunLimits()
        """What is asked of the run besides its settings."""
        self._input = InputSource()
        self.other_held: HeldTarget | None = None
        """What is held of the arm that keeps its place, and where; None while that arm is free."""
        self.parts = SessionParts(self)
        """State of features."""
        self.notices: deque[tuple[str, str]] = deque(maxlen=MOST_NOTICES)
        """Title and text of what `notify` was told; the page that shows them removes them."""
        self.simulation.use(self.law.of_run)
        self._ghost.begin(settings, self.simulation)

    def wake(self) -> None:
        """Ask for a frame at once; from any thread."""
        self.stirred = True
        self._ask_for_frame()

    def notify(self, title: str, text: str) -> None:
        """Tell the visitor something that no control shows. `title`, `text`: in English, for `tr`."""
        self.notices.append((title, text))

    def state(self) -> SessionState:
        """Return where the session is."""
        ghost = None
        if self.ghost is not None and self._ghost.source is None:
            ghost = RunState(*self._ghost.inputs.cut(self.ghost))
        halted: tuple[Reason, ...] = tuple(reason for reason in LASTING if reason in self.halt)
        return SessionState(RunState(*self.inputs.cut(self.simulation)), ghost, self._ghost.frozen, halted, self._input.began)

    def go_on_from(self, state: SessionState, history: float = 0.0) -> Iterator[None]:
        """Go on from where a session with the same settings was, its ghost too; yield every few steps that are made again for it.

        Args:
            history: for how much of the time before that the curves are made again [s].
        """
        run, ghost = common_pieces(state, history) if self.law.of_run is self.law.of_ghost is None else ((), ())
        self._ghost.frozen = state.frozen
        self._ghost.begin(self.settings, self.simulation)
        self._input.resume(self.simulation, state.source)
        yield from resumed(self.simulation, state.run, run)
        self.inputs.restore(state.run.pieces, self.simulation)
        if self.ghost is not None:
            beside = RunState(self.simulation.snapshot()) if state.ghost is None else state.ghost
            yield from resumed(self.ghost, beside, ghost)
            self._ghost.inputs.restore(beside.pieces, self.ghost)
        self.halt = Halt(state.halted)
        self._clock.forget()

    def close(self) -> None:
        """Drop everything that is being computed for this session, and close its law."""
        self.law.close()
        for part in self.parts:
            part.close()

    @property
    def ghost(self) -> Simulation | None:
        """The second run; its history has the same times as the first one's; None if there is none."""
        return self._ghost.simulation

    @property
    def ghost_run(self) -> GhostRun:
        """The second run with its inputs."""
        return self._ghost

    @property
    def ghost_hidden(self) -> bool:
        """True while the ghost may not be seen yet."""
        return self.limits.ghost_hidden

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        """Both runs, with their histories; the second one only if it may be seen."""
        return self.simulation, None if self.ghost_hidden else self.ghost

    @property
    def law_status(self) -> LateLawStatus:
        """State of the law that may answer later."""
        return self.law.status(not self.paused and self._clock.pace(False).slowed)

    def step_with(self, law: Law) -> bool:
        """Pause, and make one step of the run with another law, which answers at once; return False, and make none, as long as the
        ghost's law has not answered."""
        if not self.halt:
            self.halt.set("visitor")
        self.simulation.use(law)
        try:
            return self._step_both()
        finally:
            self.simulation.use(self.law.of_run)

    def assign_laws(self, reset: bool) -> None:
        """Follow a change of `law`: assign it to the run or the ghost. `reset`: also reset them, as recorded inputs belong to one law."""
        self.simulation.use(self.law.of_run)
        if self.ghost is not None:
            self.ghost.use(self.law.of_ghost)
        if reset and self.simulation.steps:
            self.reset()

    def post(self, action: actions.Action) -> None:
        """Queue an action for the beginning of one of the next frames, on the session's own thread; see `ActionQueue.put`."""
        self.posts.put(action)
        self.wake()

    def _add_handlers(self) -> None:
        handlers, player = self.handlers, self.player
        # In a replay they mean the replay.
        handlers.add_first(actions.Pause, player.pause)
        handlers.add_first(actions.SingleStep, player.single_step)
        handlers.add_first(actions.Reset, player.reset)
        handlers.add(actions.Pause, lambda _: self.toggle_pause())
        handlers.add(actions.SingleStep, lambda _: self.single_step())
        handlers.add(actions.Reset, lambda _: self.reset())
        handlers.add(actions.ChangeSpeed, lambda action: self.change("speed", next_speed(self.settings.page.speed, action.by)))
        handlers.add(actions.SetSetting, lambda action: self.change(action.key, action.value))
        handlers.add(actions.Digit, lambda action: self.change("scene", action.scene))
        handlers.add(actions.RestoreSettings, self._restore)
        handlers.add(actions.MoveJoint, self._move_joint)

    def _restore(self, action: actions.RestoreSettings) -> None:
        for key, value in values(action.settings).items():
            if values(self.settings)[key] != value:
                self.change(key, value)

    def _move_joint(self, action: actions.MoveJoint) -> None:
        held = with_joint(self.simulation, self.held, action.joint, action.angle)
        if held is not None:
            self.hold(held)

    @property
    def held(self) -> Target | None:
        """What the visitor holds, and where; None while they hold nothing."""
        return self._input.held

    @property
    def arm(self) -> Arm:
        """The arm that the visitor holds."""
        return self.simulation.guided

    @property
    def pace(self) -> Pace:
        """How the clock runs now; where it waits for a law, the machine is not slow."""
        pace, law = self._clock.pace(self.paused), self.law_status
        return replace(pace, slowed=False) if law.waits or law.slow or law.problem else pace

    def change(self, key: str, value: object) -> None:
        """Set one setting, from the next step on.

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
            self._input.set_source(None)
        elif rebuilt or source_settings(after.run) != source_settings(before.run):
            self._input.let_go()
        if after.page.autopilot and not before.page.autopilot:
            self._input.restart()
        if after.page.ghost != before.page.ghost:
            self._ghost.frozen = after.run
            self.law.in_ghost = after.page.ghost == GHOST
            self._ghost.begin(after, self.simulation)
            self.assign_laws(self.law.given and GHOST in (after.page.ghost, before.page.ghost))
        elif rebuilt:
            self._ghost.begin(after, self.simulation)
        elif after.run != before.run:
            self._ghost.apply(after)
        for part in self.parts:
            part.changed(before, after, rebuilt)

    def hold(self, target: Target | None) -> None:
        """Take a target from the visitor's hand, or (None) let go of it; the autopilot stops at once."""
        if target is not None and self.settings.page.autopilot:
            self.settings = replace(self.settings, page=replace(self.settings.page, autopilot=False))
        self._input.held = on_grid(target) if self.limits.on_grid else target

    def nudge(self, way: Array) -> None:
        """Move the place where the person holds the hand, or the ball, by (3,) [m], world. A person's own arms cannot be nudged."""
        held = nudged(self.simulation, self.arm, self.held, way)
        if held is not None:
            self.hold(held)

    def set_source(self, source: TargetSource | None) -> None:
        """Take the target from a source, such as a file, a camera or recorded inputs, from now on; None for the experiment's own one."""
        self._input.set_source(source)
        if source is not None and not self.settings.page.autopilot:
            self.settings = replace(self.settings, page=replace(self.settings.page, autopilot=True))

    def reset(self) -> None:
        """Start the run from its beginning with the present settings."""
        self.simulation.reset()
        if self._ghost.source is not None:
            self._ghost.begin(self.settings, self.simulation)
        elif self.ghost is not None:
            self.ghost.reset()
        for part in self.parts:
            part.reset()
        self._input.let_go()
        self.other_held = None
        self._clock.forget()
        self._hurries_to, self._wish = 0.0, None

    def show_beside(self, simulation: Simulation, source: TargetSource) -> None:
        """Show another run in the place of the ghost, with settings and inputs of its own, until the next reset; both begin now."""
        self._ghost.begin_other(simulation, source)

    def hurry(self, until: float) -> None:
        """Simulate as fast as the machine can up to a time of the run [s]; a pause or a reset ends that, too."""
        self.halt.go_on()
        self._hurries_to = until

    @property
    def coming(self) -> str:
        """Name of the run that is being loaded to be replayed; "" for none."""
        return self.player.coming

    @property
    def paused(self) -> bool:
        """Whether the run stands still, for whatever reason."""
        return bool(self.halt)

    def toggle_pause(self) -> None:
        """Pause or go on; nothing happens while the teacher has stopped the session."""
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

    def target(self) -> Target | None:
        """Return the active source's target, with what is held of the other arm; None for no change."""
        target, other = self._input.target(self.simulation, self.settings.page.autopilot), self.other_held
        if other is None or not self.settings.run.experiment.for_two:
            return target
        return PairTarget(target if isinstance(target, (HandTarget, LinkTarget)) else None, other)

    def way(self, seconds: float) -> Array:
        """Return where the hand, or the ball, will go in the next seconds (k, 3) [m], see `InputSource.way`; (0, 3) if unknown."""
        return self._input.way(self.simulation, self.settings.page.autopilot, seconds)

    def _step_both(self) -> bool:
        """Make a step of both runs; return False, and make none, as long as a law has not answered."""
        target = self.target() if self._wish is None else self._wish[0]
        runs = [(self.simulation, self.inputs)]
        if self.ghost is not None and self._ghost.source is None:
            # The run that may have to wait for its law goes first.
            runs.insert(0 if self.law.of_ghost is not None else 1, (self.ghost, self._ghost.inputs))
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
        self._ghost.catch_up(self.simulation.time)
        self.law.step_made(self.settings.run, self.settings.page.speed)
        return True

    def _make(self, due: int, budget: float) -> int:
        """Make so many steps, or as many as there is time for [s]; return how many were made."""
        begin, made = perf_counter(), 0
        now = begin
        while made < due and now <= begin + budget and self._step_both():
            made += 1
            now = perf_counter()
        self.stepping = now - begin
        return made

    def advance(self, elapsed: float, budget: float = BUDGET) -> int:
        """Take the actions and make the steps of one frame without a page, see `take_actions` and `step`."""
        self.take_actions(elapsed)
        return self.step(elapsed, budget)

    def take_actions(self, elapsed: float) -> None:
        """Do what was posted, and take in what was computed. `elapsed`: wall time since the last frame [s]."""
        self.stirred = False
        self.law.advance(elapsed, self.paused)
        for part in self.parts:
            part.advance(elapsed)
        self.posts.do()

    def step(self, elapsed: float, budget: float = BUDGET) -> int:
        """Simulate `elapsed` [s] of wall time, with no further step after `budget` [s] of it; return the number of steps made."""
        self.stepping = 0.0
        if "teacher" in self.halt:
            # What was asked for meanwhile is not made up for afterwards.
            self._steps_asked, self._hurries_to = 0, 0.0
            return 0
        if "hidden" in self.halt:
            # A hurry goes on when the tab is back in sight.
            return 0
        if self.paused:
            due, self._hurries_to = self._steps_asked, 0.0
            made = self._make(due, budget)
            self._steps_asked -= made
            return made
        dt = self.settings.run.dt
        ahead = round((self._hurries_to - self.simulation.time) / dt)
        due = ahead if ahead > 0 else self._clock.due(elapsed, dt, self.settings.page.speed)
        left = round((self.limits.frame_ends_at - self.simulation.time) / dt)
        due = min(due, left) if left > 0 else due
        made = self._make(due, budget)
        waits = self.law.waits
        if ahead <= 0:
            self._clock.note(made, made if waits else due, elapsed, dt)
        if ahead > 0 or waits:
            self._clock.forget()
        return made
