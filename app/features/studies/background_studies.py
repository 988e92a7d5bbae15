"""Background studies of one session."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, Final, Generic, NamedTuple, TypeVar

from app.features.studies.counterexample_search import CounterexampleSearch
from app.features.studies.knob_search import WINDOW, KnobSearch
from app.features.studies.law_knobs import LawKnob, knobs
from app.features.studies.microscope import Magnified, Microscope
from app.features.studies.studies import Studies, Who
from app.runtime.job_pool import Job, Jobs
from app.session.frame import Frame
from app.session.parts import SessionPart
from app.session.session import Session
from app.settings import ATTACK, Settings
from controllers.errors import BadSetting
from scenes import headless
from scenes.inputs import InputsLog
from scenes.laws import DEFAULT_LAW
from scenes.rerun import WhatIf
from scenes.settings import RunSettings
from scenes.sweep import TRADE_OFF_ORDERS, TradeOff, trade_off
from scenes.wanted import while_wanted

Part = TypeVar("Part")
Result = TypeVar("Result")


class BackgroundParts(Generic[Part, Result]):
    """A result in parts, recomputed when relevant settings change.

    Args:
        compute: (settings, part) → result, at a module's top level.
        relevant: sets irrelevant settings to fixed values.
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
        of = self._relevant(run)
        if of != self._of:
            self.forget()
            self._of = of
            self._jobs = [
                self._background.submit(self, f"{part}", self._compute, of, part, wake=self._wake)
                for part in self._parts
            ]
        return {
            part: job.result
            for part, job in zip(self._parts, self._jobs, strict=True)
            if job.result is not None
        }

    @property
    def size(self) -> float:
        """Finished share, 0 to 1."""
        return sum(job.result is not None for job in self._jobs) / len(self._parts)

    def forget(self) -> None:
        self._background.cancel(self)
        self._of, self._jobs = None, []


SECONDS: Final = 12.0
"""Simulated time of a point [s]."""


class SafetyPoint(NamedTuple):
    """Smallest distance [m] and largest squared error [m² or rad²]."""

    d_min: float
    e2_max: float


def knob_curve(settings: RunSettings, knob: LawKnob) -> tuple[SafetyPoint, ...]:
    """Points of one knob, sorted by distance.

    Raises:
        Stopped: see `scenes.wanted`.
    """
    runs = (headless.run(knob.at(settings, value), SECONDS).summary for value in knob.setting.points)
    found = while_wanted(runs)
    return tuple(sorted(SafetyPoint(summary.d_min, summary.e2_max) for summary in found))


def _any_law(run: RunSettings) -> RunSettings:
    return replace(run, law=replace(run.law, law=DEFAULT_LAW, feed_forward=False))


def trade_off_row(settings: RunSettings, order: float) -> tuple[TradeOff, ...]:
    """Points of one n for every v of the map.

    Raises:
        Stopped: see `scenes.wanted`.
    """
    return tuple(while_wanted(trade_off(settings, SECONDS, order)))


def _any_order(run: RunSettings) -> RunSettings:
    return replace(run, law=replace(run.law, order=1.0, nominal_velocity=0.1))


class BackgroundStudies(SessionPart):
    """`trade_off`, a row per n, and `safety_curves`, a curve per knob, are None for a custom law."""

    name: ClassVar[str] = "studies"

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._make()
        if session.settings.page.what_if:
            self.questions.prepare(session.settings)

    def _make(self) -> None:
        session = self._session
        # They know only the settings' laws, and would answer for another one.
        jobs = None if session.law.given else session.background
        wake, inputs = session.wake, session.inputs
        self.questions = Studies(jobs, wake, inputs)
        self.trade_off = self.safety_curves = None
        if jobs is not None:
            self.trade_off = BackgroundParts(jobs, wake, TRADE_OFF_ORDERS, trade_off_row, _any_order)
            self.safety_curves = BackgroundParts(jobs, wake, knobs(), knob_curve, _any_law)
        self.knob_search = KnobSearch(jobs, wake, lambda: session.settings, session.change)
        self.counterexample = CounterexampleSearch(
            jobs, wake, lambda: session.settings, session.player.watch_file
        )
        self.microscope = Microscope(jobs, wake, inputs)

    def law_changed(self) -> None:
        self.close()
        self._make()

    def advance(self, elapsed: float) -> None:
        """Start what is due, and collect answers. `elapsed`: wall time [s]."""
        self.questions.advance(elapsed, self._session.simulation)
        self.knob_search.advance()
        self.counterexample.advance(elapsed)

    def changed(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        self.questions.follow(before, after, rebuilt)

    def measure_smoothness(self) -> None:
        session, ghost = self._session, self._session.ghost_run
        runs: dict[Who, tuple[InputsLog, RunSettings]] = {"law": (session.inputs, session.settings.run)}
        if ghost.simulation is not None and ghost.source is None:
            runs["ghost"] = ghost.inputs, ghost.simulation.settings
        self.questions.measure_smoothness(runs)

    def match_distance(self) -> None:
        """See `KnobSearch.ask`."""
        session = self._session
        self.knob_search.ask(session.ghost_run.frozen, session.inputs.window(WINDOW))
        if self.knob_search.busy and self.safety_curves is not None:
            # They would have other settings afterwards, and the search need not wait for them.
            self.safety_curves.forget()

    def open_link(self, query: Mapping[str, str]) -> tuple[str, ...]:
        if ATTACK in query:
            try:
                self.counterexample.open(query[ATTACK])
            except BadSetting as error:
                return (str(error),)
        return ()

    def curves(self) -> WhatIf | None:
        return self.questions.what_if

    def reset(self) -> None:
        self.questions.forget()
        self.knob_search.forget()
        self.microscope.forget()

    def close(self) -> None:
        self.reset()
        self.counterexample.close()
        for parts in (self.trade_off, self.safety_curves):
            if parts is not None:
                parts.forget()


def magnified(frame: Frame) -> Magnified | None:
    """None for a replay."""
    part = frame.part(BackgroundStudies)
    return part.microscope.magnify(frame.live.simulation) if part is not None and frame.of_live else None
