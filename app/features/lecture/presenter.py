"""What the projector shows of a step, and how a clicker goes through it: scene, question, answers, run, outcome, explanation, challenge."""

from collections.abc import Callable
from enum import StrEnum
from math import ceil
from time import monotonic
from typing import Final, Literal, NamedTuple, get_args

from app.features.lessons.bookmark import Phase, phases_of
from app.features.lessons.progress import StepProgress
from app.features.lessons.walkthrough import Walkthrough
from app.i18n.speaking import N_

ScreenAction = Literal[
    "on", "back", "live", "freeze", "blank", "stage", "panels", "timer 30", "timer 60", "timer 90", "timer off"
]
"""What a teacher asks of the projectors: the next station, the one before; the present picture, hold it, or black; the stage alone, or with
the panels; a timer, or none."""

TIMERS: Final[dict[ScreenAction, int]] = {"timer 30": 30, "timer 60": 60, "timer 90": 90, "timer off": 0}
"""Times that a class can be given to answer [s], and none."""

MOST_QUOTES: Final = 4
"""Reasons of students that are shown at once."""

InvitedPages = Literal["", "screens", "teachers", "all"]
"""Which pages show the address: none, the projectors, besides them the teachers' pages, or besides those the students'."""

INVITED: Final[tuple[InvitedPages, ...]] = get_args(InvitedPages)
"""From none to all."""


class Station(StrEnum):
    """What of a step the projector shows."""

    SCENE = "scene"
    QUESTION = "question"
    ANSWERS = "answers"
    RUN = "run"
    OUTCOME = "outcome"
    EXPLANATION = "explanation"
    CHALLENGE = "challenge"
    TRY = "try"


STATION_NAMES: Final = {
    Station.SCENE: N_("the scene"),
    Station.QUESTION: N_("the question"),
    Station.ANSWERS: N_("the class's answers"),
    Station.RUN: N_("the run"),
    Station.OUTCOME: N_("what was measured"),
    Station.EXPLANATION: N_("the explanation"),
    Station.CHALLENGE: N_("the challenge"),
    Station.TRY: N_("the challenge, on the stage"),
}
"""What a teacher calls the stations."""

_OF_PHASE: Final = {
    Phase.PREDICT: Station.SCENE,
    Phase.DO: Station.RUN,
    Phase.OBSERVE: Station.OUTCOME,
    Phase.EXPLAIN: Station.EXPLANATION,
    Phase.CHALLENGE: Station.CHALLENGE,
}
"""The first station of every phase."""


class _StagePlace(NamedTuple):
    """Where the plenary's lesson is, as far as it decides what the projector shows."""

    step: tuple[str, str] | None = None
    phase: Phase | None = None
    showing: bool = False
    revealed: bool = False


class ShownWork(NamedTuple):
    """What one student has done alone, without a name.

    Attributes:
        step: where, by the names of lesson and step; ("", "") outside the lessons.
        done: there.
        run: whether the student's run is replayed on the stage.
    """

    step: tuple[str, str]
    done: StepProgress
    run: bool = False


class Presenter:
    """What every projector of a lecture shows. Belongs to the plenary's thread.

    Args:
        clock: returns the time [s].

    Attributes:
        station: what of the step is shown.
        blank: whether the projectors are black.
        frozen: whether they keep their picture while the plenary goes on.
        panels: whether they show the panels beside the scene, as students see them.
        screens: how many there are.
        inviting: which pages show the address.
        expected: how many students are expected; 0 for no number.
        quotes: reasons that students give, as the teacher has picked them.
        work: what one student has done, in place of the station; None to show the station.
    """

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock = clock
        self.station = Station.SCENE
        self.blank = self.frozen = self.panels = False
        self.screens = self.expected = 0
        self.inviting: InvitedPages = ""
        self.work: ShownWork | None = None
        self.quotes: tuple[str, ...] = ()
        self._place = _StagePlace()
        self._asked_at: float | None = None
        self._ends_at: float | None = None

    # ---- the stations ------------------------------------------------------------------------------------------------------

    def follow(self, walk: Walkthrough | None, revealed: bool, running: bool) -> None:
        """Show what fits where the lesson is, if it has moved on since the last call.

        Args:
            walk: the plenary's; None while no lesson is open.
            revealed: whether everybody sees the class's answers.
            running: whether the run is going on.
        """
        place = _StagePlace() if walk is None else _StagePlace((walk.lesson.id, walk.step.id), walk.phase, walk.showing, revealed)
        if place != self._place:
            before, self._place, self.work = self._place, place, None
            self.show(self._station_at(place, before))
            if place.step != before.step or (before.revealed and not revealed):
                # Another question, or this one once more.
                self.quotes = ()
            if place.step != before.step or revealed != before.revealed:
                # Another question, or this one is answered, or asked again.
                self._ends_at = None
                self._asked_at = self._clock() if self.station is Station.QUESTION else None
        if running and place.phase is Phase.DO and self.station in (Station.SCENE, Station.QUESTION, Station.ANSWERS):
            self.show(Station.RUN)

    def _station_at(self, place: _StagePlace, before: _StagePlace) -> Station:
        if place.phase is None:
            return Station.SCENE
        if place.showing:
            return Station.RUN
        if place.phase in (Phase.PREDICT, Phase.DO) and place.step == before.step:
            if place.revealed and not before.revealed:
                return Station.ANSWERS
            if place.phase is Phase.PREDICT and before.revealed:
                return Station.QUESTION
        return _OF_PHASE[place.phase]

    def show(self, station: Station) -> None:
        """Show a station of the present step."""
        if station is Station.QUESTION and self._asked_at is None:
            self._asked_at = self._clock()
        self.station = station

    @property
    def covered(self) -> bool:
        """Whether the projectors are blank, frozen or show the address or what one student has done."""
        return self.blank or self.frozen or self.inviting != "" or self.work is not None

    def uncover(self) -> bool:
        """Show the present picture again, and the address nowhere; return whether the projectors were covered."""
        covered = self.covered
        self.blank, self.frozen, self.inviting, self.work = False, False, "", None
        return covered

    def following(self, walk: Walkthrough) -> Station | None:
        """Return the next station of the step; None if the next step comes next."""
        stations = stations_of(walk)
        place = stations.index(self.station) + 1 if self.station in stations else 0
        return stations[place] if place < len(stations) else None

    # ---- the timer ---------------------------------------------------------------------------------------------------------

    def start_timer(self, seconds: int) -> None:
        """Set the class's timer for answers, from now on; 0 ends it."""
        self._ends_at = self._clock() + seconds if seconds else None

    @property
    def left(self) -> int | None:
        """Seconds that the class still has, 0 once the time is up; None without a timer."""
        return None if self._ends_at is None else max(ceil(self._ends_at - self._clock()), 0)

    @property
    def asked_for(self) -> int | None:
        """Seconds since the question came up; None before it has."""
        return None if self._asked_at is None else int(self._clock() - self._asked_at)


def stations_of(walk: Walkthrough) -> tuple[Station, ...]:
    """Return the stations of the present step, in their order."""
    stations: list[Station] = []
    for phase in phases_of(walk.step):
        stations.append(_OF_PHASE[phase])
        if phase is Phase.PREDICT:
            stations += [Station.QUESTION, Station.ANSWERS]
        if phase is Phase.CHALLENGE:
            stations.append(Station.TRY)
    return tuple(stations)


def clock_text(seconds: int) -> str:
    """Return seconds as minutes and seconds: 1:05."""
    return f"{seconds // 60}:{seconds % 60:02d}"
