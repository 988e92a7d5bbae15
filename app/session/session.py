"""One visitor's experiment: its run and the ghost beside it, paused, stepped, reset, changed, and advanced with the wall clock."""

import math
from collections.abc import Callable, Hashable
from dataclasses import replace
from time import perf_counter
from typing import Final

from app.custom_law.custom_law import CustomLaw
from app.custom_law.examination import Examination
from app.custom_law.time_share import SHARE
from app.runtime.job_pool import JobPool
from app.session.action_queue import ActionQueue
from app.session.clock import BUDGET, LONGEST_GAP, Clock, Pace, next_speed
from app.session.halt import Halt
from app.session.input_source import InputSource, nudged, source_key
from app.session.input_sources import NO_SOURCES, InputSources
from app.session.shown import Player
from app.session.studies import SMOOTHNESS_WINDOW, Smoothness, Studies, Who
from app.session.trade_off import TradeOffMap
from app.settings import Settings
from controllers.kinematics import Array
from controllers.laws.situation import Unanswered
from scenes.files import readable
from scenes.inputs import KEEP, InputsLog, Recorded
from scenes.rerun import WhatIf
from scenes.roles import TargetSource
from scenes.room import room_of
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import Target

GHOST_KEEP: Final = 30.0
"""How much of the ghost's run can be made again [s]."""


def _built_of(settings: Settings) -> tuple[object, ...]:
    """Return what room, arms, handles and page are made of: where another one is chosen, something of them is built again."""
    run, page = settings.run, settings.page
    return (
        *(run.scene, run.robot, run.rig, run.point, run.guided, run.path),
        *(page.language, page.theme, page.profile, page.picture, page.ghost, page.details, page.source),
    )


class Session:
    """A simulation that runs with the wall clock, and perhaps a second one, the ghost, on the same inputs.

    All methods but `post` belong to the one thread that calls `advance`; `post` may be called from anywhere.

    Args:
        settings: of the run and of the page.
        wake: called after every `post`, to ask for a frame at once.
        background: where "what if" and smoothness are computed; without one they are not.
        sources: what the server was started with: persons beside the built-in one, and a student's law.
    """

    def __init__(
        self,
        settings: Settings,
        wake: Callable[[], None] = lambda: None,
        background: JobPool | None = None,
        sources: InputSources = NO_SOURCES,
    ) -> None:
        self.settings = settings
        self.sources = sources
        self.background = background
        self._wake = wake
        self.simulation = Simulation(settings.run)
        self.ghost: Simulation | None = None
        """The second run; its history has the same times as the first one's; None if there is none."""
        self.halt = Halt()
        """Why no step is made, if none is."""
        self.inputs = InputsLog()
        """What the run was made with."""
        self._ghost_inputs = InputsLog(GHOST_KEEP)
        self._frozen = settings.run.law, settings.run.gain
        self._custom_law = CustomLaw(sources.law_file) if sources.law_file is not None else None
        self._custom_law_runs = True
        self._law_part = SHARE
        """Part of the wall time that its calls may be waited for."""
        self._law_time = math.inf
        """Time that a call of it may take in real time [s]."""
        self._wish: tuple[Target | None] | None = None
        """The target of a step that its law has not answered yet."""
        self.examination: Examination | None = None
        """The tests of a law of one's own; None where there is none."""
        if sources.law_file is not None and background is not None:
            self.examination = Examination(sources.law_file, background, wake)
        self.simulation.use(self._law_of_run())
        # Background studies know the settings' laws only, and would answer for another one.
        with_studies = background is not None and self._custom_law is None
        self._studies = Studies(background, wake) if with_studies and background is not None else None
        self.trade_off = TradeOffMap(background, wake) if with_studies and background is not None else None
        """Distance against error over n and v; None where there is no background, or a student's law runs."""
        self.player: Player | None = None
        """Replays in the place of the live run; None where nothing is replayed."""
        self.posts = ActionQueue()
        """What waits for the next frame."""
        self._clock = Clock(settings.page.speed)
        self._steps_asked = 0
        self._hurries_to = 0.0
        self._input = InputSource()
        self._raise_ghost()
        if self._studies is not None and settings.page.what_if:
            self._studies.prepare(settings)

    def go_on_from(self, other: "Session") -> None:
        """Go on from where another session with the same settings is, its ghost too; that one is left alone."""
        self._frozen, self.halt = other._frozen, Halt(other.halt)
        self.simulation.resume(other.simulation.snapshot())
        self._raise_ghost()
        if self.ghost is not None and other.ghost is not None:
            self.ghost.resume(other.ghost.snapshot())

    def close(self) -> None:
        """Drop everything that is being computed for this session, and end its own law's process."""
        if self._custom_law is not None:
            self._custom_law.close()
        if self.examination is not None:
            self.examination.drop()
        if self._studies is not None:
            self._studies.forget()
        if self.trade_off is not None:
            self.trade_off.forget()

    @property
    def custom_law(self) -> str | None:
        """Name of the file of the law that runs instead of the settings'; None if theirs does."""
        law = self._law_of_run()
        return readable(law.path.name) if law is not None else None

    @property
    def own_ghost(self) -> str | None:
        """Name of the file of the ghost's law; None if it runs another one, or there is no ghost."""
        law = self._law_of_ghost()
        return readable(law.path.name) if law is not None else None

    @property
    def custom_law_problem(self) -> str:
        """Why the student's law is not in force, and the arm stands still; "" if all is well, or no run uses it."""
        law = self._law_of_run() or self._law_of_ghost()
        return law.problem.text if law is not None and law.problem is not None else ""

    @property
    def custom_law_away(self) -> bool:
        """Whether the file of one's own law is gone; what it said last stays in force."""
        return self._custom_law is not None and self._custom_law.away

    @property
    def custom_law_waits(self) -> bool:
        """Whether everything stands still because the law of one's own has not answered yet."""
        return self._custom_law is not None and self._calls_custom_law and self._custom_law.waiting

    @property
    def custom_law_slow(self) -> tuple[float, float] | None:
        """How long a call of the law of one's own takes, and how long it may in real time [s]; None unless it slows down the run."""
        law = self._custom_law
        if law is None or not self._calls_custom_law or self.paused:
            return None
        if not self._clock.pace(False).slowed or law.need <= self._law_time:
            return None
        return law.need, self._law_time

    @property
    def _calls_custom_law(self) -> bool:
        return (self._law_of_run() or self._law_of_ghost()) is not None

    def let_custom_law_run(self, runs: bool) -> None:
        """Switch the student's law on or off, as a lesson asks for it; the run is reset."""
        if self._custom_law is not None and runs != self._custom_law_runs:
            self._custom_law_runs = runs
            self._assign_laws(True)

    def _law_of_run(self) -> CustomLaw | None:
        return self._custom_law if self._custom_law_runs and self.settings.page.ghost != "own" else None

    def _law_of_ghost(self) -> CustomLaw | None:
        return self._custom_law if self._custom_law_runs and self.settings.page.ghost == "own" else None

    def _assign_laws(self, reset: bool) -> None:
        """Assign laws to the run and its ghost. `reset`: also reset them, because recorded inputs belong to one law only."""
        self.simulation.use(self._law_of_run())
        if self.ghost is not None:
            self.ghost.use(self._law_of_ghost())
        if reset and self.simulation.steps:
            self.reset()

    def post(self, action: Callable[[], None], control: Hashable = None) -> None:
        """Have something done at the beginning of one of the next frames, on the session's own thread; see `ActionQueue.put`."""
        self.posts.put(action, control)
        self._wake()

    @property
    def held(self) -> Target | None:
        """What the visitor holds, and where; None while they hold nothing."""
        return self._input.held

    @property
    def pace(self) -> Pace:
        """How the clock runs now; where it waits for a law of one's own, the machine is not slow."""
        pace = self._clock.pace(self.paused)
        held_up = self.custom_law_waits or self.custom_law_slow is not None or self.custom_law_problem
        return replace(pace, slowed=False) if held_up else pace

    def change(self, key: str, value: object) -> None:
        """Set one setting, from the next step on.

        Raises:
            BadSetting: impossible value; nothing is changed.
        """
        before, after = self.settings, changed(self.settings, key, value)
        room_of(after.run)  # May be impossible here: a robot's package may be missing.
        self.settings, self._wish = after, None
        if _built_of(before) != _built_of(after):
            self.posts.rebuilt()
        roles = self.simulation.roles
        if after.run != before.run:
            self.simulation.apply(after.run)
        rebuilt = self.simulation.roles is not roles
        if after.page.source != before.page.source:
            self._input.set_source(None)
        elif rebuilt or source_key(after.run) != source_key(before.run):
            self._let_go()
        if after.page.autopilot and not before.page.autopilot:
            self._input.restart()
        if after.page.ghost != before.page.ghost:
            self._frozen = after.run.law, after.run.gain
            self._raise_ghost()
            self._assign_laws(self._custom_law is not None and "own" in (after.page.ghost, before.page.ghost))
        elif rebuilt:
            self._raise_ghost()
        elif self.ghost is not None and after.run != before.run:
            self.ghost.apply(self._ghost_settings())
        self._study(before, after, rebuilt)

    def _study(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        studies = self._studies
        if studies is None:
            return
        if rebuilt:
            studies.forget()
        if not after.page.what_if:
            studies.forget_what_if()
        elif not before.page.what_if:
            studies.prepare(after)
        elif (after.run.law, after.run.gain) != (before.run.law, before.run.gain):
            studies.ask()

    def _ghost_settings(self) -> RunSettings:
        run, choice = self.settings.run, self.settings.page.ghost
        if choice == "own":
            return run
        if choice in ("off", "frozen"):
            law, gain = self._frozen
            return replace(run, law=law, gain=gain)
        return replace(run, law=replace(run.law, law=choice))

    def _raise_ghost(self) -> None:
        """Have a ghost begin where the run is now, or none."""
        self._ghost_inputs.forget()
        if self.settings.page.ghost == "off":
            self.ghost = None
            return
        self.ghost = Simulation(self._ghost_settings())
        self.ghost.use(self._law_of_ghost())
        self.ghost.resume(self.simulation.snapshot())

    def hold(self, target: Target | None) -> None:
        """Take a target from the visitor's hand, or (None) let go of it; the autopilot stops at once."""
        if target is not None and self.settings.page.autopilot:
            self.settings = replace(self.settings, page=replace(self.settings.page, autopilot=False))
        self._input.held = target

    def nudge(self, way: Array) -> None:
        """Move the place where the person holds the hand, or the ball, by (3,) [m], world. A person's own arms cannot be nudged."""
        held = nudged(self.simulation, self.held, way)
        if held is not None:
            self.hold(held)

    def _let_go(self) -> None:
        self._input.held = None
        self._input.restart()

    def set_source(self, source: TargetSource | None) -> None:
        """Take the target from a source, such as a file, a camera or recorded inputs, from now on; None for the experiment's own one.

        What the visitor holds still goes first.
        """
        self._input.set_source(source)
        if source is not None and not self.settings.page.autopilot:
            self.settings = replace(self.settings, page=replace(self.settings.page, autopilot=True))

    def reset(self) -> None:
        """Start the run from its beginning with the present settings."""
        self.simulation.reset()
        if self.ghost is not None:
            self.ghost.reset()
        if self._studies is not None:
            self._studies.forget()
        self._let_go()
        self._clock.forget()
        self._hurries_to, self._wish = 0.0, None

    def hurry(self, until: float) -> None:
        """Simulate as fast as the machine can up to a time of the run [s]; a pause or a reset ends that, too."""
        self.halt.go_on()
        self._hurries_to = until

    def recorded(self, seconds: float = KEEP) -> Recorded | None:
        """Return the newest piece of the run as it can be made again, see `InputsLog.window`."""
        return self.inputs.window(seconds)

    @property
    def what_if(self) -> WhatIf | None:
        """How the last 30 s would have gone with the present settings; None unless the page asks for it and a law setting was moved."""
        return self._studies.what_if if self._studies is not None else None

    @property
    def smoothness(self) -> Smoothness | None:
        """What `measure_smoothness` has found so far."""
        return self._studies.smoothness if self._studies is not None else None

    @property
    def computing(self) -> bool:
        """Whether "what if" or smoothness is being computed."""
        return self._studies is not None and self._studies.busy

    @property
    def study_message(self) -> str:
        """Why something could not be computed, for the visitor; "" if all is well."""
        return self._studies.message if self._studies is not None else ""

    def measure_smoothness(self) -> None:
        """Make the last 10 s again in ever smaller steps, beside the run; `smoothness` then tells what came out."""
        if self._studies is None:
            return
        runs: dict[Who, tuple[Recorded | None, RunSettings]] = {"law": (self.inputs.window(SMOOTHNESS_WINDOW), self.settings.run)}
        if self.ghost is not None:
            runs["ghost"] = self._ghost_inputs.window(SMOOTHNESS_WINDOW), self.ghost.settings
        self._studies.measure_smoothness(runs)

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
        """Pause, and make one step."""
        if not self.halt:
            self.halt.set("visitor")
        self._steps_asked += 1

    def change_speed(self, by: int) -> None:
        """Take the next slower (−1) or faster (+1) speed."""
        self.change("speed", next_speed(self.settings.page.speed, by))

    def target(self) -> Target | None:
        """Return the active source's target, or None."""
        return self._input.target(self.simulation, self.settings.page.autopilot)

    def _step_both(self) -> bool:
        """Make a step of both runs; return False, and make none, as long as a law of one's own has not answered."""
        target = self.target() if self._wish is None else self._wish[0]
        runs = [(self.simulation, self.inputs)]
        if self.ghost is not None:
            # The run that may have to wait for its law goes first.
            runs.insert(0 if self._law_of_ghost() is not None else 1, (self.ghost, self._ghost_inputs))
        for simulation, inputs in runs:
            inputs.record(simulation, target)
            try:
                simulation.step(target)
            except Unanswered:
                inputs.take_back()
                self._wish = (target,)
                return False
        self._wish = None
        if self._custom_law is not None:
            calls = max(self._custom_law.step_made(), 1)
            self._law_time = self._law_part * self.settings.run.dt / self.settings.page.speed / calls
        return True

    def _allow_custom_law(self, elapsed: float) -> None:
        """Let the law of one's own have its share of a frame; `elapsed`: wall time since the last one [s]."""
        if self._custom_law is None:
            return
        self._custom_law.refresh()
        if self._calls_custom_law and not self.paused:
            self._law_part = self.sources.law_share.part(id(self))
        self._custom_law.allow(self._law_part * min(elapsed, LONGEST_GAP))

    def _make(self, due: int, budget: float) -> int:
        """Make so many steps, or as many as there is time for [s]; return how many were made."""
        deadline, made = perf_counter() + budget, 0
        while made < due and self._step_both():
            made += 1
            if made % 8 == 0 and perf_counter() > deadline:
                break
        return made

    replay_time = None
    """Live, see `app.session.shown.Shown`."""

    replayed_file = ""

    def advance(self, elapsed: float, budget: float = BUDGET) -> int:
        """Take the actions and make the steps of one frame without a page, see `take_actions` and `step`."""
        self.take_actions(elapsed)
        return self.step(elapsed, budget)

    def take_actions(self, elapsed: float) -> None:
        """Do what was posted, and take in what was computed. `elapsed`: wall time since the last frame [s]."""
        self._allow_custom_law(elapsed)
        if self._studies is not None:
            self._studies.advance(elapsed, self.settings, self.simulation, self.inputs.window)
        self.posts.do()

    def step(self, elapsed: float, budget: float = BUDGET) -> int:
        """Simulate `elapsed` [s] of wall time; return the number of steps made.

        `budget`: wall time after which no further step is made [s].
        """
        if "teacher" in self.halt:
            # What was asked for meanwhile is not made up for afterwards.
            self._steps_asked, self._hurries_to = 0, 0.0
            return 0
        if self.paused:
            due, self._hurries_to = self._steps_asked, 0.0
            made = self._make(due, budget)
            self._steps_asked -= made
            return made
        dt = self.settings.run.dt
        ahead = round((self._hurries_to - self.simulation.time) / dt)
        due = ahead if ahead > 0 else self._clock.due(elapsed, dt, self.settings.page.speed)
        made = self._make(due, budget)
        waits = self.custom_law_waits
        if ahead <= 0:
            self._clock.note(made, made if waits else due, elapsed, dt)
        if ahead > 0 or waits:
            self._clock.forget()
        return made
