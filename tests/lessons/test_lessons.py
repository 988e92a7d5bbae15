"""Our eleven lessons: every path goes as declared, and what they say comes out of closed forms or of runs, here once more."""

from functools import cache

import numpy as np
import pytest

from app.lessons.check import Walk, check_lesson, table_text
from app.lessons.lesson import Lesson, Step
from app.lessons.measures.quantity import Value
from app.lessons.outcomes import reference
from app.lessons.reference_runs import measured
from app.lessons.runs import Setup
from app.lessons.step_view import fill
from app.lessons.texts import placeholder_problems
from app.settings import Language
from controllers import budget
from controllers.activation import activation
from tests.lessons.helpers import our_book

LESSONS = our_book().lessons


@cache
def walks(id: str) -> tuple[Walk, ...]:
    return check_lesson(our_book(), LESSONS[our_book().index(id)])


def step_of(lesson: str, step: str) -> Step:
    (found,) = [s for s in LESSONS[our_book().index(lesson)].steps if s.id == step]
    return found


def values(lesson: str, step: str, id: str) -> tuple[float, ...]:
    at = step_of(lesson, step)
    found = reference(at, at.setup).known(at)[id]
    assert all(value is not None for value in found)
    return tuple(float(value) for value in found if value is not None)


def value_with(setup: Setup, name: str, **changes: object) -> Value:
    return measured(setup.with_changes(tuple(changes.items())), ((name, ()),))[0]


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.id)
def test_the_right_path_passes_and_wrong_ones_fail_for_the_right_reason(lesson: Lesson) -> None:
    found = walks(lesson.id)
    assert [walk for walk in found if not walk.ok] == []
    assert sum(walk.wrong for walk in found) >= 3
    assert sum(walk.kind == "attempt" and walk.wrong for walk in found) >= 3
    for step in lesson.steps:
        if step.challenge is not None:
            assert sum(bool(trial.fails) for trial in step.trials) >= 3
            assert sum(not trial.fails for trial in step.trials) >= 1


def test_every_inequality_of_every_challenge_can_fail() -> None:
    loopholes = {"hold": {"authority", "speed"}, "strict-priority": set(), "limits": {"start", "avoid"}}
    for lesson in LESSONS:
        for step in lesson.steps:
            if step.challenge is None or step.challenge.custom_law:
                continue
            missed = {id for trial in step.trials for id in trial.fails}
            asked = {c.measurement.id for c in step.challenge.criteria} | {f.measurement.id for f in step.challenge.forecasts}
            shut = {"dm", "law"} | loopholes.get(lesson.id, set())
            assert asked - missed <= shut, (lesson.id, step.id)


def test_a_path_that_goes_otherwise_fails_in_the_table() -> None:
    text = table_text([Walk("x", "y", "attempt", "z", True, False, "why", 0.0)])
    assert text.startswith("FAIL x") and "1 not as declared" in text


@pytest.mark.parametrize(
    ("language", "above", "below"), [("en", "above", "below"), ("de", "über", "unter"), ("sl", "nad", "pod")]
)
def test_a_difference_is_read_without_its_sign(language: Language, above: str, below: str) -> None:
    step = step_of("imitation", "both")
    both, one = (fill(step, f"{{measured:margin{name}:side}}", None, language) for name in ("", ":1"))
    assert both == f"8.7 mm {above}" and one == f"55 mm {below}"
    assert list(placeholder_problems("{measured:margin:9:side}", step)) and not list(
        placeholder_problems("{measured:margin:side}", step)
    )


def test_lesson_1_counts_four_ways_and_one() -> None:
    assert values("redundancy", "freedom", "freedom")[0] == pytest.approx(7 - 3, abs=1e-9)
    assert values("redundancy", "pose", "freedom") == pytest.approx((7 - 6, 7 - 3), abs=1e-9)
    assert values("redundancy", "freedom", "travel")[0] > 0.2
    assert values("redundancy", "freedom", "error")[0] < 1e-3


def test_lesson_2_drift_is_in_proportion_to_the_step_and_the_joints_do_not_close() -> None:
    """Half, a quarter and double; the joints' drift is the same at any step and any K; K dt > 2 grows."""
    own, double, four, half = values("drift", "open_loop", "drift")
    assert own / double == pytest.approx(0.5, abs=0.03)
    assert four / double == pytest.approx(2.0, rel=0.02)
    assert half / own == pytest.approx(0.5, abs=0.06)
    joints = values("drift", "closed_loop", "joints")
    assert joints == pytest.approx((joints[0],) * 3, rel=0.01) and np.degrees(joints[0]) > 0.5
    closed, open_loop = values("drift", "closed_loop", "tip")
    assert closed < 1e-6 < 1e-4 < open_loop
    wild, calm, edge = values("drift", "overdone", "error")
    assert wild > 100.0 * max(calm, edge)


def test_lesson_3_nothing_of_the_way_and_a_jump_that_stays() -> None:
    """The distance is kept to a millimetre in 640; the jump is the formula's at every step."""
    strict, alone, smooth = values("strict-priority", "always_first", "way")
    assert abs(strict) < 1e-3 and alone == pytest.approx(0.64, abs=2e-3) and smooth == pytest.approx(0.64, abs=2e-3)
    jumps = values("strict-priority", "switch", "jump")
    assert jumps == pytest.approx((values("strict-priority", "switch", "formula")[0],) * 4, rel=0.01)


def test_lesson_4_lambda_at_twice_the_distance_and_its_tail() -> None:
    """2⁻ⁿ; the tail within a tenth of the straight formula, or half a millimetre; chatter from n λ (v + u) dt / d > 2 on."""
    met, formula = values("lambda", "curve", "met"), values("lambda", "curve", "formula")
    assert formula == pytest.approx([activation(0.2, 0.1, n) for n in (10.0, 2.0, 1.0)])
    assert formula == pytest.approx([2.0**-n for n in (10.0, 2.0, 1.0)])
    assert met == pytest.approx(formula, abs=2e-3)
    bias, straight = values("lambda", "tail", "bias"), values("lambda", "tail", "formula")
    assert bias == pytest.approx(straight, rel=0.1, abs=5e-4)
    assert bias[0] > 0.05 > bias[1] > bias[2] > bias[3]
    zigzag, euler = values("lambda", "steep", "zigzag"), values("lambda", "steep", "euler")
    assert zigzag[0] > 1e-3 and euler[0] > 2.0 and max(zigzag[1:]) < 5e-4 and max(euler[1:]) < 2.0


def test_lesson_5_stands_off_where_the_line_says_and_is_smooth() -> None:
    """Within 1 % of λ v = (1 − λ) K (d − 0.1 m); the step of q̇ halves with dt, the switch's does not."""
    rest, steep, alone = values("smooth", "rest", "rest")
    formula = values("smooth", "rest", "formula")
    assert (rest, steep) == pytest.approx(formula, rel=0.01)
    assert rest == pytest.approx(budget.resting_distance(0.15, 2.0, 0.3, 2.0 * (formula[0] - 0.1)), rel=0.02)
    assert alone == pytest.approx(0.1, abs=1e-3)
    step, double, four, switch = values("smooth", "smooth", "step")
    assert step / double == pytest.approx(0.5, abs=0.05) and double / four == pytest.approx(0.5, abs=0.1)
    assert switch > 50.0 * step


@pytest.mark.parametrize("n", [1.0, 2.0, 6.0, 20.0])
@pytest.mark.parametrize("K", [0.2, 2.0, 10.0])
def test_lesson_6_the_threshold_is_v_whatever_n_and_K(n: float, K: float) -> None:
    """Pushed at 0.2 m/s, d_m is kept; at 0.45 m/s it is lost (positive control). v = 0.3 m/s."""
    step, faster = step_of("hold", "push"), step_of("hold", "faster")
    assert (value_with(step.setup, "distance_margin", n=n, k=K) or -1.0) > 0.0
    if n > 1.0 and K > 0.2:
        assert (value_with(faster.setup, "distance_margin", n=n, k=K) or 1.0) < 0.0


def test_lesson_6_loses_the_difference() -> None:
    assert values("hold", "faster", "loss")[0] == pytest.approx(values("hold", "faster", "formula")[0], abs=2e-3)


def test_lesson_7_the_copy_pays_for_lambda() -> None:
    """λ = (3/5)ⁿ at 25 cm; the error there is degrees at n = 2 and next to nothing at n = 10; without avoidance they collide."""
    assert values("master-slave", "copy", "activation") == pytest.approx((0.6**2, 0.6**10), rel=1e-6)
    error, steep = values("master-slave", "copy", "error")
    assert np.radians(3.0) < error < np.radians(20.0) and steep < np.radians(0.5)
    alone, kept = values("master-slave", "needed", "smallest")
    assert alone < 0.0 and kept > 0.15


def test_lesson_8_the_bound_on_v_is_little_above_the_smallest_that_will_do() -> None:
    """By bisection: one arm needs between 0.30 and 0.36 m/s for this clap; both are content with 0.02."""
    step = step_of("imitation", "one")
    low, high = 0.05, 0.6
    for _ in range(6):
        v = (low + high) / 2.0
        low, high = (low, v) if (value_with(step.setup, "distance_margin", v=v) or -1.0) >= 0.0 else (v, high)
    assert step.challenge is not None
    (bound,) = [c.high for c in step.challenge.criteria if c.measurement.id == "v"]
    assert bound is not None and high <= bound < 1.15 * high
    both, one, slow = values("imitation", "both", "margin")
    assert both > 0.0 and slow > 0.0 and one < -0.01


def test_lesson_9_independent_tasks_come_back() -> None:
    assert values("stability", "elbow_or_hand", "rank") == (4.0, 3.0)
    elbow, hand = values("stability", "elbow_or_hand", "error")
    assert elbow < 0.1 * hand
    assert values("stability", "needed", "eigenvalue")[0] < -1.0
    assert values("stability", "needed", "error")[0] < 0.1 * values("stability", "needed", "worst")[0]


def test_lesson_10_what_helps_and_what_does_not() -> None:
    fed, plain, fine, steep = values("limits", "fast", "margin")
    assert fed > 0.0 > max(plain, fine, steep) and fine == pytest.approx(plain, abs=1e-3)
    asked = values("limits", "lever", "textbook")
    assert asked == pytest.approx([0.3 / (0.4 * np.sin(np.radians(a))) for a in (5.0, 20.0, 10.0, 1.0)], rel=1e-4)
    assert values("limits", "lever", "reached")[0] < 2.0
    own, double, soft, qp = values("limits", "switching", "step")
    assert own / double > 0.9 and max(soft, qp) < 0.05 * own
    switches = values("limits", "switching", "switches")
    assert switches[0] > 1.5 * switches[1]
