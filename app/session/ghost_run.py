"""The ghost: a second run on the same inputs, with another law or with the settings of an earlier moment."""

from dataclasses import replace
from typing import Final

from app.session.student_law import StudentLaw
from app.settings import Settings
from scenes.inputs import InputsLog
from scenes.settings import RunSettings
from scenes.simulation import Simulation

KEEP: Final = 30.0
"""How much of the ghost's run can be made again [s]."""


class GhostRun:
    """The ghost of one session.

    Args:
        run: settings of the law, gain and hardware that a frozen ghost keeps.
        law: of the student, which the ghost may use.

    Attributes:
        simulation: its history has the same times as the session's; None while there is no ghost.
        inputs: what it was made with.
        frozen: run settings with the law, gain and hardware that a frozen ghost keeps.
    """

    def __init__(self, run: RunSettings, law: StudentLaw) -> None:
        self.simulation: Simulation | None = None
        self.inputs = InputsLog(KEEP)
        self.frozen = run
        self._law = law

    def begin(self, settings: Settings, beside: Simulation) -> None:
        """Have a ghost begin where the run is now, or none."""
        self.inputs.forget()
        self.simulation = None
        if settings.page.ghost != "off":
            self.simulation = Simulation(self._settings(settings))
            self.simulation.use(self._law.of_ghost)
            self.simulation.resume(beside.snapshot())

    def apply(self, settings: Settings) -> None:
        """Take on changed settings of the run from the next step on."""
        if self.simulation is not None:
            self.simulation.apply(self._settings(settings))

    def _settings(self, settings: Settings) -> RunSettings:
        run, choice = settings.run, settings.page.ghost
        match choice:
            case "own":
                return run
            case "off" | "frozen":
                return replace(run, law=self.frozen.law, gain=self.frozen.gain, hardware=self.frozen.hardware)
            case _:
                return replace(run, law=replace(run.law, law=choice))
