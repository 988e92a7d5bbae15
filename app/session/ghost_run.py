"""The ghost: a second run with another law, earlier settings, or its own inputs."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.session import late_law
from app.session.late_law import LateLaw
from app.settings import Settings
from scenes.inputs import InputsLog, Recorded
from scenes.roles import TargetSource
from scenes.settings import RunSettings
from scenes.simulation import Simulation

KEEP: Final = 60.0
"""Length of the run that can be recomputed [s]."""


class GhostRun:
    """The ghost of one session.

    Attributes:
        simulation: its history has the session's times; None without a ghost.
        source: of its own inputs; None if it uses the session's.
        frozen: run settings with the law, gain and hardware that a frozen ghost keeps.
        hidden: True while it plays against the visitor.
    """

    def __init__(self, run: RunSettings, law: Callable[[], LateLaw]) -> None:
        self.simulation: Simulation | None = None
        self.inputs = InputsLog(KEEP)
        self.source: TargetSource | None = None
        self.frozen = run
        self.hidden = False
        self._law = law

    def recorded(self, seconds: float) -> Recorded | None:
        """See `InputsLog.window`; None without a ghost."""
        return None if self.simulation is None else self.inputs.window(seconds)

    def begin(self, settings: Settings, beside: Simulation) -> None:
        self.inputs.forget()
        self.simulation = self.source = None
        if settings.page.ghost != "off":
            self.simulation = Simulation(self._settings(settings))
            self.simulation.use(self._law().of_ghost)
            self.simulation.resume(beside.snapshot())

    def begin_other(self, simulation: Simulation, source: TargetSource) -> None:
        self.inputs.forget()
        self.simulation, self.source = simulation, source

    def catch_up(self, time: float) -> None:
        """Simulate a run with its own inputs up to a time [s]."""
        simulation, source = self.simulation, self.source
        while (
            simulation is not None
            and source is not None
            and simulation.time < time - 0.5 * simulation.settings.dt
        ):
            self.inputs.record(simulation, target := source.target(simulation.time))
            simulation.step(target)

    def apply(self, settings: Settings) -> None:
        """A run with its own inputs keeps its settings."""
        if self.simulation is not None and self.source is None:
            self.simulation.apply(self._settings(settings))

    def _settings(self, settings: Settings) -> RunSettings:
        run, choice = settings.run, settings.page.ghost
        match choice:
            case late_law.GHOST:
                return run
            case "off" | "frozen":
                return replace(run, law=self.frozen.law, gain=self.frozen.gain, hardware=self.frozen.hardware)
            case _:
                return replace(run, law=replace(run.law, law=choice))
