"""Six scripted tests that a controller of one's own has to pass, and what such a controller is.

A file `my_law.py` holds one function,

    def law(situation):
        return situation.nominal

that turns a `controllers.laws.situation.Situation` (q, q̇_n, J_d, d, w, the task's Jacobian, the bounds, all pairs) into joint velocities
(n,) [rad/s]. It is called once a tick. Whoever loads such a file, in a process of its own and with a time limit, hands the function over
as any other callable: nothing is loaded here. d_m = 0.15 m is what the tests ask for; everything else is the student's.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

import numpy as np

from app.lessons import FOLDER
from app.lessons.evidence import Evidence
from app.lessons.lesson import Criterion, Measurement
from app.lessons.measures import QUANTITIES, measure
from app.lessons.outcomes import Attempt, Judgement, judged
from app.lessons.places import Place, Start
from app.lessons.runs import Input, Pairs, Setup, merged
from app.lessons.trials import begin, person_of
from controllers.activation import activation
from controllers.errors import DuetError
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.lawbook import make_law
from scenes.settings import LawSettings
from scenes.simulation import Simulation

CRITICAL_DISTANCE: Final = 0.15
"""d_m of all six tests [m]."""

TOO_FAST: Final = 5.0
"""Nobody needs a joint faster than this [rad/s]; the fastest of the LWR does 3.6."""


class LawBroke(DuetError):
    """A controller of one's own did not give joint velocities; the message says what it did instead."""


class FunctionLaw:
    """A function as a law.

    Args:
        function: (situation) → q̇ (n,) [rad/s].
        settings: whose d_m and n make the λ that is shown; the function need not have any.

    Attributes:
        fastest: largest |q̇| of a joint that it has asked for [rad/s].
    """

    wants_all_pairs: ClassVar[bool] = True
    wants_task: ClassVar[bool] = True

    def __init__(self, function: Callable[[Situation], Any], settings: LawSettings | None = None) -> None:
        self._function, self._settings = function, settings or LawSettings()
        self.fastest = 0.0

    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s].

        Raises:
            LawBroke: the function raised, or returned something else than n finite numbers.
        """
        try:
            given = self._function(situation)
        except Exception as error:
            raise LawBroke(f"law raised {type(error).__name__}: {error}") from error
        n = len(situation.nominal)
        try:
            velocities = np.array(given, np.float64)
        except (TypeError, ValueError):
            raise LawBroke(f"law returned {type(given).__name__}, not {n} numbers.") from None
        if velocities.shape != (n,):
            raise LawBroke(f"law returned an array of shape {velocities.shape}; it must be ({n},).")
        if not np.isfinite(velocities).all():
            raise LawBroke(f"law returned {velocities[~np.isfinite(velocities)][0]} for a joint; every number must be finite.")
        self.fastest = max(self.fastest, float(np.abs(velocities).max()))
        return velocities

    def activation(self, distance: float) -> float:
        """Return λ(d) of eq. (31), for the page: how near the obstacle is."""
        return activation(distance, self._settings.critical_distance, self._settings.order)

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """Return nan: what a function does along the line of contact is only known where it is called."""
        del distance, pull, approach, square
        return float("nan")


@dataclass(frozen=True)
class OwnTest:
    """One of the six.

    Attributes:
        title: what the controller has to do.
        reason: why that is asked for.
        setup: the run.
        criterion: None where it is enough that the law answers.
        slow: whether it must not ask for more than `TOO_FAST`.
    """

    title: str
    reason: str
    setup: Setup
    criterion: Criterion | None
    slow: bool = False


def _setup(seconds: float, given: Input, start: Start | None, **changes: object) -> Setup:
    common: Pairs = (("dm", CRITICAL_DISTANCE), ("pairs", "single"), ("k", 2.0), ("dt", 0.01))
    return Setup(merged(common, tuple(changes.items())), given, start, seconds, FOLDER)


def _criterion(name: str, low: float | None = None, high: float | None = None, **parameters: float) -> Criterion:
    found = QUANTITIES[name]
    return Criterion(Measurement(name, name, tuple(parameters.items()), found.shown, found.digits), low, high)


_NOBODY: Final = Input("nobody")
_UP: Final = (0.0, 0.0, 1.0)

TESTS: Final[dict[str, OwnTest]] = {
    "answers": OwnTest(
        "It answers with joint velocities, in an experiment with two arms",
        "Whatever happens, a controller has to return n finite numbers in every tick.",
        _setup(3.0, Input("autopilot"), None, scene="imitation", clip="clap"),
        None,
    ),
    "leaves_alone": OwnTest(
        "It leaves the task alone while the ball is far away",
        "λ should be next to nothing there: a hand that is pushed about by something far off cannot work.",
        _setup(8.0, _NOBODY, Start(Place("goal", _UP, 0.6)), scene="ball"),
        _criterion("hand_error_at", None, 0.002, time=7.9),
    ),
    "keeps_clear": OwnTest(
        "It keeps d_m while your hand comes at 0.2 m/s",
        "That is what it is for. 1 mm is forgiven.",
        _setup(3.5, Input("script", "push", (("speed", 0.2),)), None, scene="hold", rig="table", wmax=0.2),
        _criterion("distance_margin", -0.001),
    ),
    "comes_back": OwnTest(
        "It comes back when your hand has gone",
        "Avoidance is no task of its own; when there is nothing to avoid, the hand belongs in its place.",
        _setup(10.0, Input("script", "push_and_back", (("share", 0.6),)), None, scene="hold", rig="table", wmax=0.3),
        _criterion("hand_error_at", None, 0.005, time=9.9),
    ),
    "no_jump": OwnTest(
        "It never jumps while the closest point stays the same",
        "A jump of q̇ is an endless acceleration: a real motor cannot follow it.",
        _setup(8.0, _NOBODY, None, scene="ball", dt=0.005),
        _criterion("velocity_step", None, 0.15),
    ),
    "short_lever": OwnTest(
        "It stays slow where no joint can move the point away",
        "Dividing by a J_d near zero asks for speeds that no arm has.",
        _setup(1.4, _NOBODY, Start(Place("elbow", "upper_arm", 0.1, float(np.radians(1.0)))), scene="ball", point="elbow"),
        None,
        slow=True,
    ),
}
"""By name, in their order."""


def examine(make: Callable[[LawSettings], Law], language: str = "en", only: tuple[str, ...] = tuple(TESTS)) -> Attempt:
    """Return how a controller does in the six tests. What it breaks is its own failure: nothing is raised.

    Args:
        make: settings → the law, anew for each test; see `FunctionLaw` for a function.
        language: of the texts.
        only: names of the tests to be made.
    """
    judgements = tuple(_examined(name, TESTS[name], make, language) for name in only)
    return Attempt(all(j.passed for j in judgements), judgements)


def _examined(name: str, test: OwnTest, make: Callable[[LawSettings], Law], language: str) -> Judgement:
    run = test.setup.run
    steps = round(test.setup.seconds / run.dt)
    simulation = Simulation(run, steps)
    made = make(run.law)
    watched = made if isinstance(made, FunctionLaw) else _Watched(made)
    simulation.law = watched
    begin(simulation, test.setup)
    person = person_of(simulation, test.setup)
    for _ in range(steps):
        try:
            simulation.step(person.target(simulation.time))
        except LawBroke as error:
            return Judgement(name, False, f"{test.title}: after {simulation.time:.2f} s {error}", None)
    if test.slow and watched.fastest > TOO_FAST:
        text = f"{test.title}: it asked a joint for {watched.fastest:.1f} rad/s; at most {TOO_FAST:g} rad/s make sense."
        return Judgement(name, False, f"{text} {test.reason}", watched.fastest)
    if test.criterion is None:
        return Judgement(
            name, True, f"{test.title}: yes, and no joint was asked for more than {watched.fastest:.1f} rad/s.", None
        )
    m = test.criterion.measurement
    found = judged(test.criterion, measure(Evidence(simulation), m.name, m.parameters), test.setup.seconds, language)
    reason = "" if found.passed else f" {test.reason}"
    return Judgement(name, found.passed, f"{test.title}: {found.text}{reason}", found.value)


class _Watched(FunctionLaw):
    """A law of ours, examined as if it were a student's."""

    def __init__(self, law: Law) -> None:
        super().__init__(law)
        self._law = law

    def activation(self, distance: float) -> float:
        return self._law.activation(distance)


def stand_in(name: str) -> Callable[[LawSettings], Law]:
    """Return a law of ours, by name, as `examine` wants it."""

    def make(settings: LawSettings) -> Law:
        return make_law(replace(settings, law=name))  # pyright: ignore[reportArgumentType]

    return make
