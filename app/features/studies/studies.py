"""What if, and smoothness, on a session's inputs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, Literal

from app.runtime.job_pool import Job, Jobs, JobWatch
from app.settings import Settings
from scenes.headless import summarise
from scenes.inputs import CHAPTER, InputsLog, Recorded
from scenes.rerun import WHAT_IF_KEYS, WhatIf, warm, what_if
from scenes.settings import RunSettings, values
from scenes.simulation import Simulation
from scenes.smoothness import SUBSTEPS, StepStudy, largest_velocity_step, unmeasured

REST: Final = 0.1
"""Wall time after which an unmoved slider rests [s]."""

WINDOW: Final = 20.0
"""Part of the run recomputed by "what if" [s]."""

MOVING: Final = 1500
"""Steps recomputed while a slider moves (0.1 s of work)."""

SMOOTHNESS_WINDOW: Final = 10.0
"""Part of the run recomputed for its smoothness [s]."""

Who = Literal["law", "ghost"]

LEAST: Final = 50


@dataclass(frozen=True)
class Smoothness:
    law: StepStudy
    ghost: StepStudy | None

    @property
    def finished(self) -> bool:
        return all(m.verdict != "measuring" for m in (self.law, self.ghost) if m is not None)


class Studies:
    """All methods belong to the thread that advances the session.

    Args:
        background, wake: see `JobWatch`.

    Attributes:
        message: reason of a failure, for the visitor, or "".
    """

    def __init__(self, background: Jobs | None, wake: Callable[[], None], inputs: InputsLog) -> None:
        self._jobs, self._inputs = JobWatch(background, wake, self._failed), inputs
        self.what_if: WhatIf | None = None
        self.smoothness: Smoothness | None = None
        self.message = ""
        self._rested: float | None = None
        self._moved = False

    @property
    def busy(self) -> bool:
        return self._rested is not None or any(kind != "warm" for kind in self._jobs.kinds)

    def prepare(self, settings: Settings) -> None:
        self._jobs.submit("warm", lambda _: None, warm, settings.run)

    def follow(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        """Prepare, ask or drop "what if" after a change. `rebuilt`: True if the experiment changed."""
        if rebuilt:
            self.forget()
        if not after.page.what_if:
            self.forget_what_if()
        elif not before.page.what_if:
            self.prepare(after)
        elif self._jobs.computes and (after.run.law, after.run.gain) != (before.run.law, before.run.gain):
            # A long answer in progress is about an outdated value.
            self._jobs.drop("what if")
            self._rested, self._moved = 0.0, True

    def advance(self, elapsed: float, simulation: Simulation) -> None:
        """Start what is due for a run, and collect answers. `elapsed`: wall time [s]."""
        self._jobs.collect()
        if self._rested is None:
            return
        self._rested += elapsed
        # A short answer in progress is finished, or none would come while the slider moves.
        if "newest" in self._jobs.kinds:
            return
        if self._moved:
            self._moved = False
            self._ask_what_if("newest", min(MOVING * simulation.settings.dt, WINDOW), simulation)
        elif self._rested >= REST:
            self._rested = None
            self._ask_what_if("what if", WINDOW, simulation)

    def _ask_what_if(self, kind: str, seconds: float, simulation: Simulation) -> None:
        recorded = self._inputs.window(seconds)
        if recorded is None:
            return
        table = simulation.history.table(recorded.steps)
        if len(table) < recorded.steps:
            # At small time steps the log is longer than the drawn curves.
            recorded = self._inputs.window(len(table) * simulation.settings.dt - CHAPTER)
            if recorded is None or recorded.steps > len(table):
                return
            table = table[-recorded.steps :]
        present = values(simulation.settings)
        asked = {key: present[key] for key in WHAT_IF_KEYS}

        def done(answer: WhatIf) -> None:
            self.message, self.what_if = "", answer

        self._jobs.submit(kind, done, what_if, recorded, asked, summarise(simulation, table), urgent=True)

    def measure_smoothness(self, runs: dict[Who, tuple[InputsLog, RunSettings]]) -> None:
        """Start measuring. `runs`: of "law", and of "ghost" if it exists."""
        if not self._jobs.computes:
            return
        self._forget_smoothness()
        known: dict[Who, tuple[Recorded, RunSettings]] = {}
        for who, (inputs, run) in runs.items():
            recorded = inputs.window(SMOOTHNESS_WINDOW)
            if recorded is not None and recorded.steps >= LEAST:
                known[who] = recorded, run
        if "law" not in known:
            self.message = "There is too little to measure yet; run it for a few seconds."
            return
        self.message = ""
        blank = {who: unmeasured(recorded, settings) for who, (recorded, settings) in known.items()}
        self.smoothness = Smoothness(blank["law"], blank.get("ghost"))
        for place, substeps in enumerate(SUBSTEPS):
            for who, (recorded, run) in known.items():
                kind = f"smoothness {who} {substeps}"
                self._jobs.submit(
                    kind,
                    partial(self._take_measure, who, place),
                    largest_velocity_step,
                    recorded,
                    run,
                    substeps,
                )

    def _take_measure(self, who: Who, place: int, step: float) -> None:
        if self.smoothness is not None:
            measured: StepStudy = getattr(self.smoothness, who)
            largest = (*measured.largest[:place], step, *measured.largest[place + 1 :])
            self.smoothness = replace(self.smoothness, **{who: replace(measured, largest=largest)})

    def _failed(self, job: Job) -> None:
        if job.kind.startswith("smoothness"):
            self._forget_smoothness()
        if job.kind != "warm":
            self.message = job.message

    def _forget_smoothness(self) -> None:
        self.smoothness = None
        for kind in self._jobs.kinds:
            if kind.startswith("smoothness"):
                self._jobs.drop(kind)

    def forget(self) -> None:
        self._jobs.close()
        self.forget_what_if()
        self.smoothness, self.message = None, ""

    def forget_what_if(self) -> None:
        self._jobs.drop("what if")
        self._jobs.drop("newest")
        self._rested = self.what_if = None
        self._moved = False
