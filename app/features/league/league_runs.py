"""The league's runs."""

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal, NamedTuple

import numpy as np

from app.features.studies.law_knobs import LawKnob, knob_range, sought
from controllers.laws.situation import Law
from scenes.experiments import BALL, HOLD, MASTER_SLAVE
from scenes.headless import Run, run
from scenes.history import COLUMN
from scenes.laws import LAWS
from scenes.promise import fallen
from scenes.roles import paced
from scenes.settings import HardwareSettings, LawSettings, RunSettings
from scenes.simulation import Simulation

EDITION: Final = "2026"
"""Change it with anything below, or a default: figures of two editions are not compared."""

SCENES: Final = (HOLD, BALL, MASTER_SLAVE)
RobotKind = Literal["ideal", "delayed"]
ROBOTS: Final[dict[RobotKind, HardwareSettings]] = {
    "ideal": HardwareSettings(),
    "delayed": HardwareSettings(dead_time=0.02, lag=0.03),
}
NATURAL_SPEED: Final = 0.2
"""Approximate top speed of the experiments' own persons [m/s]."""

Level = Literal["default", "equal"]
LEVELS: Final[dict[Level, str]] = {"default": "With its own settings", "equal": "At equal safety"}
"""A law's defaults, or settings that keep d_m on average over the public persons."""

CRITICAL_DISTANCE: Final = 0.15
NOMINAL_VELOCITY: Final = 0.30
"""d_m [m] and v [m/s] of all figures."""


Half = Literal["public", "hidden"]


class Person(NamedTuple):
    """A moving person.

    Attributes:
        half: "hidden" if the seed is in no file.
        number: in that half, from 1.
        speed: largest [m/s].
    """

    half: Half
    number: int
    seed: int
    speed: float


@dataclass(frozen=True)
class Schedule:
    """Persons and length of the runs.

    Attributes:
        seconds: length of a run at `NATURAL_SPEED` [s]; slower persons take longer.
        speeds: [m/s]; every seed at every speed.
        seeds: of the public half.
        word: source of the hidden half's seeds; "" for no such half.
    """

    seconds: float
    speeds: tuple[float, ...]
    seeds: tuple[int, ...]
    word: str = ""

    def persons(self) -> list[Person]:
        hidden = [
            int.from_bytes(hashlib.sha256(f"{self.word} {i}".encode()).digest()[:4]) % 10_000
            for i in self.seeds
        ]
        halves: tuple[tuple[Half, list[int]], ...] = (
            ("public", list(self.seeds)),
            ("hidden", hidden if self.word else []),
        )
        return [
            Person(half, number, seed, speed)
            for half, seeds in halves
            for number, seed in enumerate(seeds, 1)
            for speed in self.speeds
        ]


FULL: Final = Schedule(8.0, (0.1, 0.2, 0.3, 0.5), (2, 4))
QUICK: Final = Schedule(8.0, (0.2, 0.5), (2,))


class Event(NamedTuple):
    """Runs with one value of a law's knob."""

    scene: str
    robot: RobotKind
    level: Level

    def settings(self, person: Person) -> RunSettings:
        law = LawSettings(critical_distance=CRITICAL_DISTANCE, nominal_velocity=NOMINAL_VELOCITY)
        hardware = ROBOTS[self.robot]
        # The ball crosses the path of the hand by itself, and the whole arm avoids it.
        own = RunSettings(scene=self.scene, ball="cross", point="arm")
        return replace(own, seed=person.seed, hand_speed=person.speed, law=law, hardware=hardware)


def events() -> Iterator[Event]:
    for level in LEVELS:
        for robot in ROBOTS:
            for scene in SCENES:
                yield Event(scene, robot, level)


class LeagueRun(NamedTuple):
    """Result of one run; SI units.

    Attributes:
        lost: fall of d below d_m while w ≤ v [m], see `fallen`.
        dq_step: largest change of one joint's velocity in a step [rad/s].
        at_bounds: time during which joint bounds, or a row that was too short, reduced q̇ [s].
    """

    half: Half
    number: int
    speed: float
    lost: float
    d_min: float
    e2_max: float
    dq_step: float
    at_bounds: float


@dataclass(frozen=True)
class Outcome:
    """Outcome of an event for one entrant.

    Attributes:
        value: of its knob, SI; None with its own settings, or if no value keeps the distance.
        reached: nearest mean smallest distance of the public persons [m]; None with its own settings.
        runs: one per person; () if no value keeps the distance, or without a knob.
        step_us: median wall time of a step of both arms [µs]; None without a run.
        problem: why there is no run, or "".
        given_up: time allowed for a file that did not finish [s], or 0.
    """

    value: float | None
    reached: float | None
    runs: tuple[LeagueRun, ...]
    step_us: float | None
    problem: str = ""
    given_up: float = 0.0


Applied = Callable[[RunSettings, float | None], tuple[RunSettings, Law | None]]
"""Applies a law and knob value (None: its own settings) to settings, or returns a law that settings cannot
name.
"""


NO_KNOB: Final = "no setting of it chooses a distance"
OUT_OF_REACH: Final = "no value of its knob keeps d_m on average"


def held(schedule: Schedule, event: Event, applied: Applied, ends: tuple[float, float] | None) -> Outcome:
    """Outcome of an event. `ends`: of the knob's range, SI; None without a knob."""

    def simulated(person: Person, value: float | None) -> Run:
        settings, law = applied(event.settings(person), value)
        factor = person.speed / NATURAL_SPEED
        return run(
            settings, schedule.seconds / factor, paced(Simulation(settings, 1).source(), factor), law=law
        )

    value, reached = None, None
    if event.level == "equal":
        if ends is None:
            return Outcome(None, None, (), None, NO_KNOB)
        public = replace(schedule, word="").persons()

        def nearest(value: float) -> float:
            return float(np.mean([simulated(person, value).summary.d_min for person in public]))

        value, reached = sought(nearest, ends, CRITICAL_DISTANCE)
        if value is None:
            return Outcome(None, reached, (), None, OUT_OF_REACH)
    runs: list[LeagueRun] = []
    steps: list[float] = []
    for person in schedule.persons():
        done = simulated(person, value)
        d, w, summary = done.table[:, COLUMN["d"]], done.table[:, COLUMN["w"]], done.summary
        lost = fallen(d - CRITICAL_DISTANCE, w <= NOMINAL_VELOCITY)
        numbers = lost, summary.d_min, summary.e2_max, summary.dq_step_max, summary.out_of_authority_s
        runs.append(LeagueRun(person.half, person.number, person.speed, *map(float, numbers)))
        steps.append(summary.step_us_median)
    return Outcome(value, reached, tuple(runs), float(np.median(steps)))


def law_held(law: str, schedule: Schedule, event: Event) -> Outcome:
    knob = LAWS[law].distance_knob

    def applied(settings: RunSettings, value: float | None) -> tuple[RunSettings, None]:
        if value is None or knob is None:
            return replace(settings, law=replace(settings.law, law=law)), None
        return LawKnob(law, knob).at(settings, value), None

    return held(schedule, event, applied, None if knob is None else knob_range(knob))
