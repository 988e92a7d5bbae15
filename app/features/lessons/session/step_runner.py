"""Begins and measures a step's run."""

import logging
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Final

from app.features.custom_law.student_law import examination, let_custom_law_run, tests_of
from app.features.lessons.lesson import Setup, Step
from app.features.lessons.outcomes import reference
from app.features.lessons.reference_runs import begin_reference_run, measured, person_of
from app.features.lessons.runs import LONGEST
from app.features.lessons.walkthrough import Walkthrough
from app.features.measures.quantities.quantity import UNITS
from app.features.measures.room_places import start_positions
from app.features.studies.background_studies import BackgroundStudies
from app.i18n.speaking import N_
from app.session.session import Session
from app.settings import Look, Settings
from controllers.errors import BadSetting
from scenes.inputs import Recorded, RecordedPerson
from scenes.settings import values
from scenes.simulation import Simulation

log = logging.getLogger("duet.lessons")

_RUNS: Final = ThreadPoolExecutor(1, "duet-lessons")
"""One thread for all further runs, so that pages stay responsive."""


def _make_runs(step: Step, why: Setup | None) -> None:
    try:
        if why is not None:
            reference(step, why)
            return
        if step.measurements and step.asked != "first":
            reference(step, step.setup)
        if step.challenge is not None:
            for forecast in step.challenge.forecasts:
                m = forecast.measurement
                measured(step.challenge.setup.with_changes(forecast.changes), m.name, m.parameters)
    except Exception:
        log.exception("the runs that a step compares with could not be made")


def with_look(settings: Settings, session: Session) -> Settings:
    """A lesson keeps the page's current look."""
    page = session.settings.page
    look = Look(page.theme, page.profile, page.picture, page.language)
    return replace(settings, page=replace(look.of(settings.page), gizmo=page.gizmo))


def asks_for_custom_law(walk: Walkthrough) -> bool:
    return walk.challenge is not None and walk.challenge.custom_law


def deviation_from_lesson(session: Session, walk: Walkthrough) -> tuple[str, str] | None:
    """Notice (title, text) if the visitor's choice stops the lesson's run."""
    asked, has = walk.setup.run, session.settings.run
    if (asked.scene, asked.rig, asked.robot) != (has.scene, has.rig, has.robot):
        return N_("The lesson needs its own experiment"), N_(
            "It has been restarted. Leave the lessons for another one."
        )
    if not walk.yours and not session.settings.page.autopilot:
        return N_("The lesson moves this one"), N_(
            "The run has been restarted. It is your turn where the step asks you to pull."
        )
    return None


class StepRunner:
    """Belongs to the session's thread. `further`: done if no run is pending."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.further: Future[None] = Future()
        self.further.set_result(None)
        self._further_of: tuple[object, ...] = ()
        self.seen: dict[tuple[str, str], Recorded] = {}
        self._warm = False
        self._tests = tests_of(session)

    def begin(self, walk: Walkthrough, own_settings: bool = False) -> None:
        """Begin the current run from its start. `own_settings`: keep the visitor's settings."""
        session = self._session
        step = walk.lesson.id, walk.step.id, walk.showing
        if self._further_of != step:
            self._further_of = step
            self.further = _RUNS.submit(_make_runs, walk.step, walk.beside)
        if not own_settings:
            self.apply(walk.setup.settings(with_look(Settings(), session)))
        let_custom_law_run(session, asks_for_custom_law(walk))
        session.reset()
        start = start_positions(session.simulation.room, walk.setup.start)
        if start is not None:
            session.simulation.reset(start)
            if session.ghost is not None:
                session.ghost.reset(start)
        session.hand.on_grid = walk.pushes
        if walk.yours:
            session.hand.set_source(None)
            session.change("autopilot", False)
        else:
            session.hand.set_source(person_of(session.simulation, walk.setup, walk.kept))
        if walk.showing:
            asked = walk.step.setup
            beside = Simulation(asked.run)
            begin_reference_run(beside, asked)
            session.ghost_run.begin_other(beside, person_of(beside, asked, walk.kept))
        # The visitor's hand responds at once; any other run waits for Run.
        session.control.frame_ends_at = 0.0 if walk.yours else walk.setup.seconds
        session.control.halt.go_on()
        session.control.halt.set("lesson", walk.locked or not walk.yours)
        if not self._warm:
            # The decisive moment of the first run should not wait for a starting process.
            session.parts.of(BackgroundStudies).questions.prepare(session.settings)
            self._warm = True

    def apply(self, settings: Settings) -> None:
        """Apply settings in any order that works; a notice shows the last refusal."""
        problem = ""
        for _ in range(3):
            problem = ""
            for key, value in values(settings).items():
                if values(self._session.settings)[key] != value:
                    try:
                        self._session.change(key, value)
                    except BadSetting as error:
                        problem = str(error)
            if not problem:
                return
        self._session.notify("A setting of the lesson is not possible here", problem)

    def observe(self, walk: Walkthrough) -> None:
        showing, step = walk.showing, (walk.lesson.id, walk.step.id)
        if (
            walk.observe(self._session.simulation).complete
            and not showing
            and self._session.law_status.file is None
        ):
            recorded = self._session.inputs.window(LONGEST)
            if recorded is not None:
                self.seen[step] = recorded

    def check(self, walk: Walkthrough, said: Sequence[float | None]) -> None:
        """Check the step's challenge, if it is open, with the current run.

        `said`: forecasts, in their measurements' shown units.
        """
        session, challenge = self._session, walk.challenge
        if challenge is None:
            return
        if challenge.custom_law:
            tests = examination(session)
            if tests is not None:
                tests.begin()
                self._tests = tests_of(session)
            return
        typed = (*said, *(None,) * len(challenge.forecasts))
        forecasts = [
            None if number is None else number / UNITS[forecast.measurement.unit].factor
            for forecast, number in zip(challenge.forecasts, typed, strict=False)
        ]
        recorded = session.inputs.window() if challenge.keep or walk.duel else None
        person = RecordedPerson(recorded) if recorded is not None and recorded.begin == 0.0 else None
        walk.attempt(session.simulation, forecasts, person)

    def advance_law_tests(self, walk: Walkthrough) -> bool:
        before, self._tests = self._tests, tests_of(self._session)
        if self._tests == before:
            return False
        # Quick tests may be finished in the frame in which they begin.
        if self._tests.finished and (before.number != self._tests.number or not before.finished):
            walk.attempt_custom_law(self._tests.verdicts)
        return True
