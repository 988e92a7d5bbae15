"""Six scripted tests of a law; each reports the failed inequality and its margin.

d_m = 0.15 m, v = 0.30 m/s, and the hand never moves faster than 0.25 m/s. The paper's law passes if its
pseudo-inverse is damped, or its velocity clipped; as printed it asks for any speed where J_d is singular.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from app.features.custom_law import arena
from app.features.custom_law.arena import Candidate, TrialCurve, TrialResult
from app.i18n.speaking import N_
from controllers.errors import LazyText, NumberText
from scenes.experiments import BALL, HOLD, SOLO
from scenes.history import COLUMN

SLACK: Final = 0.002
"""Allowance for a switching law at 5 ms [m]."""
APPROACH: Final = 8.0
"""Run with an approaching hand [s]; without avoidance the arms overlap in it."""
REST: Final = 1.5
"""Initial rest of the hand beside a ball [s]."""
UNHARMED: Final = 0.010
"""Largest error beside a far obstacle [m]."""
UNTOUCHED: Final = 0.001
"""Largest error without an obstacle [m]."""
ESCAPE: Final = 2.0
"""Time to leave the overlap [s]; at v it takes 0.67 s."""
STAY: Final = 2.5
"""Time until which it must stay out [s]."""
PASSAGE: Final = 5.5
"""Time at which the hand has passed the ball [s]."""
HALVED: Final = 0.65
"""Largest ratio of q̇'s steps at half the time step: 1/2 if smooth, 1 at a jump."""
QUICK: Final = 1e-3
"""Longest call with transport [s]."""


def verdict_on(law: Candidate, name: str) -> TrialResult:
    try:
        passed, reason, curve = TRIALS[name](law)
    except arena.TrialStopped as stopped:
        return TrialResult(name, False, str(stopped), stopped.curve, stopped.line)
    return TrialResult(name, passed, reason, None if passed else curve)


TrialOutcome = tuple[bool, str, TrialCurve | None]
"""Passed, reason, curve."""


def _outcome(
    passed: bool, held: str, failed: str, curve: TrialCurve | None = None, **parts: object
) -> TrialOutcome:
    return passed, LazyText(held if passed else failed, **parts), curve


def keeps_its_distance(law: Candidate) -> TrialOutcome:
    """d ≥ d_m against a hand that is slower than v (Fig. 5)."""
    simulation = arena.enter(HOLD, law)
    source = simulation.source()
    table = arena.play(
        simulation, law, (source.target(i * arena.DT) for i in range(round(APPROACH / arena.DT)))
    )
    d = table[:, COLUMN["d"]]
    i = int(d.argmin())
    one, other = map(_body, simulation.detector.pair_names[int(table[i, COLUMN["pair"]])])
    pair = LazyText("{one} / {other}", one=one, other=other)
    parts = {
        "limit": _mm(arena.CRITICAL_DISTANCE),
        "d": _mm(d[i]),
        "time": float(table[i, COLUMN["t"]]),
        "pair": pair,
    }
    missing = arena.CRITICAL_DISTANCE - float(d[i])
    held = N_("d ≥ {limit} holds: the smallest d is {d}, at t = {time:.2f} s between {pair}.")
    failed = N_("d ≥ {limit} fails by {by}: d = {d} at t = {time:.2f} s between {pair}.")
    return _outcome(missing <= SLACK, held, failed, arena.distance_curve(table), by=_mm(missing), **parts)


def leaves_the_task_alone(law: Candidate) -> TrialOutcome:
    empty = arena.enter(SOLO, law, path="circle")
    table = arena.play(empty, law, [None] * round(2.0 / arena.DT))
    error = arena.largest_error(table)
    limit = arena.error_of_the_task_alone() + UNTOUCHED
    if error > limit:
        parts = {"limit": _mm(limit), "by": _mm(error - limit)}
        failed = N_("|e| ≤ {limit} in an empty room (d = ∞) fails by {by}.")
        return _outcome(False, "", failed, arena.error_curve(table, limit), **parts)
    beside = arena.enter(BALL, law)
    arena.put_the_ball_away(beside)
    table = arena.play(beside, law, [None] * round(REST / arena.DT))
    error, d = arena.largest_error(table), float(table[0, COLUMN["d"]])
    parts = {"limit": _mm(UNHARMED), "by": _mm(error - UNHARMED), "d": _mm(d), "error": _mm(error)}
    held = N_("|e| ≤ {limit} beside a ball that is {d} away holds: {error}.")
    failed = N_(
        "|e| ≤ {limit} beside a ball that is {d} away fails by {by}: the hand leaves its place by {error}."
    )
    return _outcome(error <= UNHARMED, held, failed, arena.error_curve(table, UNHARMED), **parts)


def gets_out(law: Candidate) -> TrialOutcome:
    """From 50 mm of overlap to d_m within 2 s, and it stays out."""
    simulation = arena.enter(HOLD, law)
    simulation.reset(np.array(arena.overlapping()))
    table = arena.play(simulation, law, [None] * round(STAY / arena.DT))
    d = table[:, COLUMN["d"]]
    least = float(d[round(ESCAPE / arena.DT) :].min())
    inside = np.flatnonzero(d < arena.CRITICAL_DISTANCE - SLACK)
    missing = arena.CRITICAL_DISTANCE - least
    parts = {
        "start": _mm(d[0]),
        "limit": _mm(arena.CRITICAL_DISTANCE),
        "after": ESCAPE,
        "by": _mm(missing),
        "time": (int(inside[-1]) + 1) * arena.DT if len(inside) else 0.0,
        "d": _mm(least),
    }
    held = N_("from d = {start}, d ≥ {limit} after {after:g} s holds: it takes {time:.2f} s.")
    failed = N_("from d = {start}, d ≥ {limit} after {after:g} s fails by {by}: d = {d}.")
    return _outcome(missing <= SLACK, held, failed, arena.distance_curve(table), **parts)


def is_smooth(law: Candidate) -> TrialOutcome:
    """Half the time step halves the largest step of q̇, past a ball with one control point (Fig. 1)."""
    largest: list[float] = []
    lines: dict[str, list[float | None]] = {}
    for dt in (2.0 * arena.DT, arena.DT):
        simulation = arena.enter(BALL, law, dt=dt)
        table = arena.play(simulation, law, [None] * round(PASSAGE / dt))
        velocities = simulation.history.velocities(table)[:, simulation.avoiding.joints]
        steps = np.abs(np.diff(velocities, axis=0)).max(axis=1)
        largest.append(float(steps.max()))
        lines[f"dt = {dt * 1e3:g} ms"] = arena.worst_values(steps)
    share = largest[1] / largest[0] if largest[0] > 0.0 else 0.0
    steps = LazyText(
        "{before:.3g} rad/s at dt = 10 ms, {after:.3g} at 5 ms", before=largest[0], after=largest[1]
    )
    word = LazyText("a jump stays, however small dt") if share > 0.85 else LazyText("a smooth q̇ leaves 50 %")
    held = N_("largest step of q̇ ≤ {limit:.0%} at half the dt holds: {share:.0%} is left ({steps}).")
    failed = N_(
        "largest step of q̇ ≤ {limit:.0%} at half the dt fails: {share:.0%} is left ({steps}); {word}."
    )
    curve = TrialCurve("dq_step", PASSAGE, None, lines)
    return _outcome(share <= HALVED, held, failed, curve, limit=HALVED, share=share, steps=steps, word=word)


def is_bounded(law: Candidate) -> TrialOutcome:
    """|q̇| within its bound in `arena.hard_situations`."""
    worst, where = 0.0, ""
    for situation in arena.hard_situations():
        velocities = law(situation)
        arena.stop_if_failed(law)
        speed = float(np.abs(velocities).max())
        if speed > worst:
            worst = speed
            where = NumberText(
                f"|J_d| = {float(np.linalg.norm(situation.row)):g} m/rad, d = {_mm(situation.distance)}"
            )
    parts = {"limit": arena.TOP_SPEED, "worst": worst, "by": worst - arena.TOP_SPEED, "where": where}
    held = N_("|q̇| ≤ {limit:g} rad/s near a singular J_d holds: the most is {worst:.3g} rad/s.")
    failed = N_(
        "|q̇| ≤ {limit:g} rad/s near a singular J_d fails by {by:.3g} rad/s: {worst:.3g} rad/s at {where}."
    )
    return _outcome(worst <= arena.TOP_SPEED * (1.0 + 1e-9), held, failed, **parts)


def is_quick(law: Candidate) -> TrialOutcome:
    situations = arena.hard_situations()
    taken: list[float] = []
    for i in range(300):
        law(situations[i % len(situations)])
        arena.stop_if_failed(law)
        taken.append(law.seconds)
    median = float(np.median(taken))
    if median > QUICK:
        return (
            False,
            LazyText("a call ≤ 1 ms fails: the median of 300 calls is {median:.3g} ms.", median=median * 1e3),
            None,
        )
    return (
        True,
        LazyText("a call ≤ 1 ms holds: the median of 300 calls is {median:.3g} µs.", median=median * 1e6),
        None,
    )


TRIALS: Final[dict[str, Callable[[Candidate], TrialOutcome]]] = {
    "keeps its distance": keeps_its_distance,
    "leaves the task alone": leaves_the_task_alone,
    "gets out": gets_out,
    "smooth": is_smooth,
    "bounded where J_d is singular": is_bounded,
    "quick": is_quick,
}

WHY: Final[dict[str, str]] = {
    N_("keeps its distance"): N_("That is what it is for."),
    N_("leaves the task alone"): N_("A hand that a distant obstacle moves cannot work."),
    N_("gets out"): N_("Distances are negative there, and a law that divides by d turns round."),
    N_("smooth"): N_("A jump of q̇ is an endless acceleration, and no motor can follow it."),
    N_("bounded where J_d is singular"): N_("A division by next to nothing asks for speeds that no arm has."),
    N_("quick"): N_("A tick lasts 5 ms, and there is more to be done in it."),
}

GATES: Final = ("keeps its distance", "gets out")
"""Other tests count only after these: an arm at rest is also smooth, bounded and quick."""

TRY: Final[dict[str, tuple[str, int]]] = {
    "keeps its distance": (
        N_(
            "Set λ to 1 at d_m and below, add λ (v + u) and not less, and check the sign: J_d @ q̇ > 0 leads away."
        ),
        6,
    ),
    "leaves the task alone": (
        N_("Decrease λ to 0 as d grows, and return situation.nominal if d is inf."),
        4,
    ),
    "gets out": (
        N_(
            "Keep λ = 1 for every d below d_m, also if d is negative: a quotient or a power of d changes its sign there."
        ),
        4,
    ),
    "smooth": (N_("Replace the `if` at a distance by a λ that changes with d without a jump."), 5),
    "bounded where J_d is singular": (
        N_("Damp more: add a larger μ² to `J_d @ J_d`, or clip q̇ to situation.lower and .upper."),
        10,
    ),
    "quick": (N_("Leave imports and loops outside of law(), and compute with whole arrays."), 10),
}


def advice(name: str) -> LazyText:
    what, lesson = TRY[name]
    return LazyText("{what} Lesson {lesson} shows it.", what=LazyText(what), lesson=lesson)


def _body(name: str) -> LazyText:
    side, _, body = name.partition(" ")
    template = N_("left {body}") if side == "left" else N_("right {body}")
    return LazyText(template, body=LazyText(body))


def _mm(metres: float) -> NumberText:
    return NumberText(f"{metres * 1e3:.1f} mm".replace("-", "−"))
