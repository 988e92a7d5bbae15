"""The projector's stations of a step."""

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
    "on",
    "back",
    "live",
    "freeze",
    "blank",
    "stage",
    "panels",
    "timer 30",
    "timer 60",
    "timer 90",
    "timer off",
]
"""on: next station. stage: the 3-D view alone. panels: with panels."""

TIMERS: Final[dict[ScreenAction, int]] = {"timer 30": 30, "timer 60": 60, "timer 90": 90, "timer off": 0}
"""Time for answers [s]; 0 stops the timer."""

MOST_QUOTES: Final = 4

InvitedPages = Literal["", "screens", "teachers", "all"]
"""Pages that show the address: none, projectors, also teachers', also students'."""

INVITED: Final[tuple[InvitedPages, ...]] = get_args(InvitedPages)


class Station(StrEnum):
    """Part of a step on the projector."""

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
    Station.TRY: N_("the challenge, in the shared session"),
}

_OF_PHASE: Final = {
    Phase.PREDICT: Station.SCENE,
    Phase.DO: Station.RUN,
    Phase.OBSERVE: Station.OUTCOME,
    Phase.EXPLAIN: Station.EXPLANATION,
    Phase.CHALLENGE: Station.CHALLENGE,
}


class _StagePlace(NamedTuple):
    """State of a lesson that selects the station."""

    step: tuple[str, str] | None = None
    phase: Phase | None = None
    showing: bool = False
    revealed: bool = False


class ShownWork(NamedTuple):
    """A student's work, without a name. `step`: ids of lesson and step; ("", "") outside the lessons."""

    step: tuple[str, str]
    done: StepProgress
    run: bool = False


class Presenter:
    """Picture of all projectors. Belongs to the shared session's thread.

    Attributes:
        frozen: keep the picture.
        panels: show the panels, as students see them.
        expected: number of students; 0 if unknown.
        work: shown in the station's place.
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
        """Show the lesson's station after a change."""
        place = (
            _StagePlace()
            if walk is None
            else _StagePlace((walk.lesson.id, walk.step.id), walk.phase, walk.showing, revealed)
        )
        if place != self._place:
            before, self._place, self.work = self._place, place, None
            self.show(self._station_at(place, before))
            if place.step != before.step or (before.revealed and not revealed):
                # Another question, or the same one once more.
                self.quotes = ()
            if place.step != before.step or revealed != before.revealed:
                # Another question, or this one is answered, or asked again.
                self._ends_at = None
                self._asked_at = self._clock() if self.station is Station.QUESTION else None
        if (
            running
            and place.phase is Phase.DO
            and self.station in (Station.SCENE, Station.QUESTION, Station.ANSWERS)
        ):
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
        if station is Station.QUESTION and self._asked_at is None:
            self._asked_at = self._clock()
        self.station = station

    @property
    def covered(self) -> bool:
        return self.blank or self.frozen or self.inviting != "" or self.work is not None

    def uncover(self) -> bool:
        """Show the live picture; true if it was covered."""
        covered = self.covered
        self.blank, self.frozen, self.inviting, self.work = False, False, "", None
        return covered

    def following(self, walk: Walkthrough) -> Station | None:
        """None if the next step follows."""
        stations = stations_of(walk)
        place = stations.index(self.station) + 1 if self.station in stations else 0
        return stations[place] if place < len(stations) else None

    # ---- the timer ---------------------------------------------------------------------------------------------------------

    def start_timer(self, seconds: int) -> None:
        """Start the timer for answers [s]; 0 stops it."""
        self._ends_at = self._clock() + seconds if seconds else None

    @property
    def left(self) -> int | None:
        """Remaining time [s], 0 when it is up; None without a timer."""
        return None if self._ends_at is None else max(ceil(self._ends_at - self._clock()), 0)

    @property
    def asked_for(self) -> int | None:
        """Time since the question was shown [s]; None before."""
        return None if self._asked_at is None else int(self._clock() - self._asked_at)


def stations_of(walk: Walkthrough) -> tuple[Station, ...]:
    stations: list[Station] = []
    for phase in phases_of(walk.step):
        stations.append(_OF_PHASE[phase])
        if phase is Phase.PREDICT:
            stations += [Station.QUESTION, Station.ANSWERS]
        if phase is Phase.CHALLENGE:
            stations.append(Station.TRY)
    return tuple(stations)


def clock_text(seconds: int) -> str:
    """As "1:05"."""
    return f"{seconds // 60}:{seconds % 60:02d}"
