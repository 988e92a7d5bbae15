"""The run that a step of a lesson asks for, in a session: begun with its settings, and measured."""

from collections import deque
from collections.abc import Sequence

from app.lessons.law_challenge import attempt_of
from app.lessons.runs import LONGEST
from app.lessons.session.further_runs import FurtherRuns
from app.lessons.session.lesson_settings import apply_settings, begin, with_look
from app.lessons.walkthrough import Walkthrough
from app.session.session import Session
from app.settings import Settings
from scenes.inputs import Recorded, RecordedPerson


class StepRunner:
    """Begins and measures the run of a step; belongs to the session's thread.

    Args:
        further: the further runs that it is compared with.
        notes: takes title and text of notices for the visitor.

    Attributes:
        seen: (lesson, step) → the run in which the visitor saw what came of it.
    """

    def __init__(self, session: Session, further: FurtherRuns, notes: deque[tuple[str, str]]) -> None:
        self._session, self._further, self._notes = session, further, notes
        self.seen: dict[tuple[str, str], Recorded] = {}

    def begin(self, walk: Walkthrough, own_settings: bool = False) -> None:
        """Begin the present run. `own_settings`: with the visitor's, not with those of the step."""
        self._further.prepare(walk.lesson.id, walk.step, walk.setup if walk.showing else None)
        if not own_settings:
            self.apply(walk.settings(with_look(Settings(), self._session)))
        begin(self._session, walk)

    def apply(self, settings: Settings) -> None:
        """Apply settings; a notice names the one that is not possible."""
        problem = apply_settings(self._session, settings)
        if problem:
            self._notes.append(("A setting of the lesson is not possible here", problem))

    def observe(self, walk: Walkthrough) -> None:
        """Measure the run, and keep it where it is the one that answers the step's question."""
        showing, step = walk.showing, (walk.lesson.id, walk.step.id)
        if walk.observe(self._session.simulation).complete and not showing and self._session.student_law.file is None:
            recorded = self._session.recorded(LONGEST)
            if recorded is not None:
                self.seen[step] = recorded

    def check(self, walk: Walkthrough, said: Sequence[float | None]) -> None:
        """Try the step's challenge with the run as it is. `said`: the forecasts that the visitor has typed."""
        session, challenge = self._session, walk.step.challenge
        if challenge is None:
            return
        if challenge.custom_law:
            if session.law.examination is not None:
                session.law.examination.begin()
            return
        count = len(challenge.forecasts)
        recorded = session.recorded() if challenge.keep else None
        person = RecordedPerson(recorded) if recorded is not None and recorded.begin == 0.0 else None
        walk.attempt(session.simulation, (*said, *(None,) * count)[:count], person)

    def advance_own_tests(self, walk: Walkthrough) -> bool:
        """Look after the tests of the visitor's own law; return whether there is anything new."""
        examination = self._session.law.examination
        if examination is None or not examination.advance():
            return False
        if examination.progress.finished:
            walk.attempt_custom_law(attempt_of(examination.progress.verdicts).judgements)
        return True
