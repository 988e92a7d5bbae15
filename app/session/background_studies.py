"""Everything that is computed beside one session's run, behind one object; the maps and curves come part by part, while they are shown."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, Generic, NamedTuple, TypeVar

from app.runtime.job_pool import Job, Jobs
from app.session.counterexample_search import CounterexampleSearch
from app.session.knob_search import KnobSearch
from app.session.microscope import Microscope
from app.session.studies import Studies
from app.settings import Settings
from scenes import headless
from scenes.inputs import InputsLog, Recorded
from scenes.law_knobs import LawKnob, knobs
from scenes.laws import DEFAULT_LAW
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.sweep import TRADE_OFF_ORDERS, TradeOff, trade_off
from scenes.wanted import while_wanted

Part = TypeVar("Part")
Result = TypeVar("Result")


class BackgroundParts(Generic[Part, Result]):
    """The parts of one session's result; computed when they are first asked for, and again when the settings have changed.

    Args:
        background: where they are computed.
        wake: called when there is a further part.
        parts: what is computed one by one.
        compute: (settings, part) → result, at a module's top level.
        relevant: the settings of a run with fixed values for all that does not matter.
    """

    def __init__(
        self,
        background: Jobs,
        wake: Callable[[], None],
        parts: Sequence[Part],
        compute: Callable[[RunSettings, Part], Result],
        relevant: Callable[[RunSettings], RunSettings],
    ) -> None:
        self._background, self._wake = background, wake
        self._parts, self._compute, self._relevant = parts, compute, relevant
        self._of: RunSettings | None = None
        self._jobs: list[Job] = []

    def results(self, run: RunSettings) -> dict[Part, Result]:
        """Return what is there already, part by part."""
        of = self._relevant(run)
        if of != self._of:
            self.forget()
            self._of = of
            self._jobs = [
                self._background.submit(self, f"{part}", self._compute, of, part, wake=self._wake) for part in self._parts
            ]
        return {part: job.result for part, job in zip(self._parts, self._jobs, strict=True) if job.result is not None}

    @property
    def size(self) -> float:
        """How much of it is there, from 0 to 1."""
        return sum(job.result is not None for job in self._jobs) / len(self._parts)

    def forget(self) -> None:
        """Drop the results, and what is being computed."""
        self._background.cancel(self)
        self._of, self._jobs = None, []


SECONDS: Final = 12.0
"""Simulated time of a point [s]."""


class SafetyPoint(NamedTuple):
    """A run: smallest distance [m], and largest squared error [m² or rad²]."""

    d_min: float
    e2_max: float


def knob_curve(settings: RunSettings, knob: LawKnob) -> tuple[SafetyPoint, ...]:
    """Return the points of one knob, by their distance.

    Raises:
        Stopped: after the run at work, see `scenes.wanted`.
    """
    runs = (headless.run(knob.at(settings, value), SECONDS).summary for value in knob.setting.points)
    found = while_wanted(runs)
    return tuple(sorted(SafetyPoint(summary.d_min, summary.e2_max) for summary in found))


def _any_law(run: RunSettings) -> RunSettings:
    """Return the settings for the curves of all laws, which do not depend on the chosen one."""
    return replace(run, law=replace(run.law, law=DEFAULT_LAW, feed_forward=False))


def trade_off_row(settings: RunSettings, order: float) -> tuple[TradeOff, ...]:
    """Return the points of one n, every v of the map.

    Raises:
        Stopped: after the run at work, see `scenes.wanted`.
    """
    return tuple(while_wanted(trade_off(settings, SECONDS, order)))


def _any_order(run: RunSettings) -> RunSettings:
    """Return the settings for the map, which does not depend on the present n and v."""
    return replace(run, law=replace(run.law, order=1.0, nominal_velocity=0.1))


class BackgroundStudies:
    """The six studies of one session. All methods belong to the session's thread.

    Args:
        background: where they are computed; None where they are not.
        wake: called, from any thread, when there is news.
        inputs: of the run.
        settings: gives the session's present settings.
        change: sets one of them, by its key.
        watch: has a run replayed, by its name.

    Attributes:
        questions: "what if", and how smooth the run is.
        trade_off, safety_curves: distance against error over n and v, a row an n, and law by law, a curve a knob; None without a
            background.
        knob_search: for the same distance.
        counterexample: the search for a run that breaks the promise.
        microscope: which single steps are looked at.
    """

    def __init__(
        self,
        background: Jobs | None,
        wake: Callable[[], None],
        inputs: InputsLog,
        settings: Callable[[], Settings],
        change: Callable[[str, object], None],
        watch: Callable[[Recorded, str], None],
    ) -> None:
        self.questions = Studies(background, wake, inputs)
        self.trade_off = self.safety_curves = None
        if background is not None:
            self.trade_off = BackgroundParts(background, wake, TRADE_OFF_ORDERS, trade_off_row, _any_order)
            self.safety_curves = BackgroundParts(background, wake, knobs(), knob_curve, _any_law)
        self.knob_search = KnobSearch(background, wake, settings, change)
        self.counterexample = CounterexampleSearch(background, wake, settings, watch)
        self.microscope = Microscope(background, wake, inputs)

    def advance(self, elapsed: float, simulation: Simulation) -> None:
        """Ask and answer what is due. `elapsed`: wall time since the last call [s]."""
        self.questions.advance(elapsed, simulation)
        self.knob_search.advance()
        self.counterexample.advance(elapsed)

    def forget(self) -> None:
        """Drop what is about the run before a reset."""
        self.questions.forget()
        self.knob_search.forget()
        self.microscope.forget()

    def close(self) -> None:
        """Drop everything that is being computed."""
        self.forget()
        self.counterexample.close()
        for parts in (self.trade_off, self.safety_curves):
            if parts is not None:
                parts.forget()
