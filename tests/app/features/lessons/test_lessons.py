"""Our twelve lessons: every path has its declared result; closed forms or runs confirm other claims."""

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from _pytest.mark import ParameterSet

from app.features.lessons import check, reference_runs
from app.features.lessons.check import Walk, check_lesson, table_text
from app.features.lessons.labels import contrast_of
from app.features.lessons.lesson import Lesson, Step
from app.features.lessons.outcomes import AT_END, StepOutcome, decisive_moment, reference
from app.features.lessons.reference_runs import measured, simulated
from app.features.lessons.runs import Setup
from app.features.lessons.texts import fill, placeholder_problems, told_in
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import Value, measure, moment
from app.plots.time_series import DRIVEN
from app.settings import LANGUAGES, Language
from app.text.lesson_text import lesson_html
from controllers import budget
from controllers.activation import activation
from controllers.kinematics import Kinematics
from tests.app.features.lessons.helpers import our_book
from tests.approved import Approve

pytestmark = pytest.mark.slow

LESSONS = our_book().lessons
ROOT = Path(__file__).parents[4]


@pytest.fixture(scope="module", autouse=True)
def room_for_the_runs_of_a_lesson() -> Iterator[None]:
    """Larger cache of runs than a server's, because the walks through a lesson use all its runs again."""
    kept = lru_cache(maxsize=32)(simulated.__wrapped__)
    with pytest.MonkeyPatch.context() as patch:
        for module in (check, reference_runs):
            patch.setattr(module, "simulated", kept)
        yield


def step_of(lesson: str, step: str) -> Step:
    (found,) = [s for s in LESSONS[our_book().index(lesson)].steps if s.id == step]
    return found


def values(lesson: str, step: str, id: str) -> tuple[float, ...]:
    at = step_of(lesson, step)
    found = reference(at, at.setup).known(at)[id]
    assert all(value is not None for value in found)
    return tuple(float(value) for value in found if value is not None)


def value_with(setup: Setup, name: str, **changes: object) -> Value:
    return measured(setup.with_changes(tuple(changes.items())), name)


LONGEST = ("lambda", "limits", "redundancy")
"""Lessons with the slowest walks, in the thorough part."""


def with_mark(lesson: Lesson) -> ParameterSet:
    return pytest.param(lesson, id=lesson.id, marks=[pytest.mark.thorough] if lesson.id in LONGEST else [])


@pytest.mark.parametrize("lesson", [with_mark(lesson) for lesson in LESSONS])
def test_right_paths_pass_and_wrong_paths_fail_for_the_right_reason(lesson: Lesson) -> None:
    assert [walk for walk in check_lesson(our_book(), lesson) if not walk.ok] == []
    for step in lesson.steps:
        if step.challenge is not None:
            assert sum(bool(trial.fails) for trial in step.trials) >= 3
            assert sum(not trial.fails for trial in step.trials) >= 1
        if step.setup.input.kind not in ("yours", "kept"):
            check_moment(step, f"{lesson.id}.{step.id}" in AT_THE_END)


AT_THE_END = {
    *(
        "drift.open_loop",
        "drift.closed_loop",
        "strict-priority.always_first",
        "lambda.tail",
        "smooth.rest",
        "smooth.stand_off",
    ),
    *("stability.elbow_or_hand", "stability.needed", "stability.without", "limits.fast", "limits.tie"),
    *("first-tasks.wall", "first-tasks.tip"),
}
"""Steps with a question about a run's end; others have a moment, unless the student moves the robot."""


def check_moment(step: Step, at_end: bool) -> None:
    run = reference_runs.simulated(step.setup)
    evidence = Evidence(run, step.setup.seconds)
    mark = decisive_moment(step.measurements, evidence)
    assert (mark is None) == at_end, (step.id, mark)
    if mark is None:
        return
    assert 0.0 < mark.time < step.setup.seconds - AT_END
    # For extremes and crossings, a run cut off right after the moment has the same value.
    named = next(m for m in step.measurements if moment(evidence, m.name, m.parameters) is not None)
    if named.name in (
        "smallest_distance",
        "distance_margin",
        "velocity_step",
        "first_jump",
        "switch_pull",
        "loss_rate",
    ):
        half = 1.5 * evidence.settings.dt
        value = measure(evidence, named.name, named.parameters)
        for time, same in ((mark.time + half, True), (mark.time - half, False)):
            assert (measure(Evidence(run, time), named.name, named.parameters) == value) is same, (
                step.id,
                named.name,
            )


def test_texts_have_the_right_number_of_lessons() -> None:
    numbers = ("ten", "eleven", "twelve", "thirteen")
    text = "".join(
        (ROOT / name).read_text(encoding="utf-8")
        for name in ("README.md", "app/features/lessons/files/README.md", "app/cli/serve.py")
    )
    found = re.findall(r"(\w+) lessons\b|\bour (?:own )?(\w+)", text)
    said = [word for words in found for word in words if word in numbers]
    assert len(said) == 2 and {numbers.index(word) + 10 for word in said} == {len(LESSONS)}


def test_no_reply_contains_a_negative_depth(approve: Approve) -> None:
    step = next(s for s in LESSONS[6].steps if s.measurements[0].id == "smallest")
    assert step.question is not None
    replies = [
        fill(step, choice.reply, reference(step, step.setup), "en") for choice in step.question.choices
    ]
    assert not any(re.search(r"−\d+ mm into", reply) for reply in replies)
    approve("depth.txt", f"{replies[0]}\n")


def test_every_inequality_of_every_challenge_can_fail() -> None:
    loopholes = {"hold": {"authority", "speed"}, "strict-priority": set(), "limits": {"start", "avoid"}}
    for lesson in LESSONS:
        for step in lesson.steps:
            if step.challenge is None or step.challenge.custom_law:
                continue
            missed = {id for trial in step.trials for id in trial.fails}
            asked = {c.measurement.id for c in step.challenge.criteria} | {
                f.measurement.id for f in step.challenge.forecasts
            }
            shut = {"dm", "law"} | loopholes.get(lesson.id, set())
            assert asked - missed <= shut, (lesson.id, step.id)


def test_a_path_with_another_result_fails_in_the_table() -> None:
    text = table_text([Walk("x", "y", "attempt", "z", True, False, "why", 0.0)])
    assert text.startswith("FAIL x") and "1 not as declared" in text


@pytest.mark.parametrize(
    ("language", "above", "below"), [("en", "above", "below"), ("de", "über", "unter"), ("sl", "nad", "pod")]
)
def test_a_difference_is_shown_as_above_or_below_without_a_sign(
    language: Language, above: str, below: str
) -> None:
    step = step_of("imitation", "both")
    both, one = (fill(step, f"{{measured:margin{name}:side}}", None, language) for name in ("", ":1"))
    assert both == f"{'8.7' if language == 'en' else '8,7'} mm {above}" and one == f"55 mm {below}"
    problems = [list(placeholder_problems(f"{{measured:margin:{way}}}", step)) for way in ("9:side", "side")]
    assert problems[0] and not problems[1]


def test_lesson_2_drift_is_proportional_to_dt_and_the_joints_do_not_close() -> None:
    """dt: half, a quarter, double. The joints' drift depends on neither dt nor K; K dt > 2 is unstable."""
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


def test_lesson_4_lambda_at_twice_the_distance_and_its_tail() -> None:
    """λ = 2⁻ⁿ; tail within 10 % or 0.5 mm of the linear formula; chatter for n λ (v + u) dt / d > 2."""
    met, formula = values("lambda", "curve", "met"), values("lambda", "curve", "formula")
    assert formula == pytest.approx([activation(0.2, 0.1, n) for n in (10.0, 2.0, 1.0)])
    assert formula == pytest.approx([2.0**-n for n in (10.0, 2.0, 1.0)])
    assert met == pytest.approx(formula, abs=2e-3)
    bias, straight = values("lambda", "tail", "bias"), values("lambda", "tail", "formula")
    assert bias == pytest.approx(straight, rel=0.1, abs=5e-4)
    assert bias[0] > 0.05 > bias[1] > bias[2] > bias[3]
    zigzag, euler = values("lambda", "steep", "zigzag"), values("lambda", "steep", "euler")
    assert zigzag[0] > 1e-3 and euler[0] > 2.0 and max(zigzag[1:]) < 5e-4 and max(euler[1:]) < 2.0


def test_lesson_5_rests_at_the_formulas_distance_and_is_smooth() -> None:
    """Rest within 1 % of λ v = (1 − λ) K (d − 0.1 m); q̇'s jump halves with dt, except for the switch."""
    rest, steep, alone = values("smooth", "rest", "rest")
    formula = values("smooth", "rest", "formula")
    assert (rest, steep) == pytest.approx(formula, rel=0.01)
    assert rest == pytest.approx(budget.resting_distance(0.15, 2.0, 0.3, 2.0 * (formula[0] - 0.1)), rel=0.02)
    assert alone == pytest.approx(0.1, abs=1e-3)
    step, double, four, switch = values("smooth", "smooth", "step")
    assert step / double == pytest.approx(0.5, abs=0.05) and double / four == pytest.approx(0.5, abs=0.1)
    assert switch > 50.0 * step


def test_lesson_8_the_bound_on_v_is_slightly_above_the_smallest_safe_v() -> None:
    """By bisection: for this clap one arm needs 0.30 to 0.36 m/s; for two arms 0.02 m/s is enough."""
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


def steps_in(language: Language) -> dict[tuple[str, str], Step]:
    return {(lesson.id, step.id): step for lesson in our_book(language).lessons for step in lesson.steps}


@pytest.mark.parametrize("language", LANGUAGES)
def test_explanations_use_the_cards_symbols_u_1_and_u_2(language: Language) -> None:
    book, steps = our_book(language), steps_in(language)
    learned = "".join(lesson.learned for lesson in book.lessons)
    assert not re.search(r"u_[LR]", learned + "".join(step.explain for step in steps.values()))
    for place in (("master-slave", "needed"), ("imitation", "both")):
        assert "(u_1 + u_2)" in steps[place].explain and "$u_1$" in steps[place].explain


@pytest.mark.parametrize("language", LANGUAGES)
def test_joint_numbers_match_the_plot_and_q_d_and_rho_are_explained(language: Language) -> None:
    steps = steps_in(language)
    copy = steps["master-slave", "copy"]
    assert re.search(rf"\b1 \w+ {DRIVEN}\b", copy.do) and "$q_d$" in copy.explain
    assert r"$\rho$" in steps["stability", "elbow_or_hand"].explain


def test_lesson_8_hands_are_about_15_times_faster_than_the_retreat() -> None:
    step = step_of("imitation", "both")
    assert step.question is not None and "fifteen times faster" in step.question.text
    simulation = simulated(step.setup.with_changes((("law", "unprotected"),)))
    table, kinematics = simulation.history.table(), Kinematics(simulation.room.model, simulation.room.arms)
    places = []
    for q in simulation.history.positions(table):
        kinematics.update(np.ascontiguousarray(q))
        places.append(kinematics.hand_pose(simulation.guided).translation.copy())
    fastest = np.linalg.norm(np.diff(places, axis=0), axis=1).max() / simulation.settings.dt
    assert fastest / simulation.settings.law.nominal_velocity == pytest.approx(15.0, abs=1.0)


def test_lesson_10_remedies_work_as_the_text_claims() -> None:
    fed, plain, fine, steep = values("limits", "fast", "margin")
    assert fed > 0.0 > max(plain, fine, steep) and fine == pytest.approx(plain, abs=1e-3)
    asked = values("limits", "lever", "textbook")
    assert asked == pytest.approx(
        [0.3 / (0.4 * np.sin(np.radians(a))) for a in (5.0, 20.0, 10.0, 1.0)], rel=1e-4
    )
    assert values("limits", "lever", "reached")[0] < 2.0
    own, double, soft, qp = values("limits", "switching", "step")
    assert own / double > 0.9 and max(soft, qp) < 0.05 * own
    switches = values("limits", "switching", "switches")
    assert switches[0] > 1.5 * switches[1]


def test_lesson_10_a_smooth_distance_avoids_the_loss_between_two_pairs() -> None:
    """Without it the loss is over 100 mm, although the obstacle rests and all other conditions hold."""
    single, finer, smooth, soft, faster = values("limits", "tie", "margin")
    assert max(single, finer) < -0.1 and abs(finer - single) < 2e-3
    assert min(smooth, soft, faster) > 0.0
    assert values("limits", "tie", "approach") == (0.0,)
    assert values("limits", "tie", "authority") == (0.0,)


def test_a_series_is_a_table_sorted_by_the_varied_setting() -> None:
    step = step_of("lambda", "tail")
    outcome = reference(step, step.setup)
    text = fill(step, "{table:bias,formula}", outcome, "en").strip().splitlines()
    assert [line.split(" | ")[0] for line in text] == ["| n", "| ---", "| 1", "| 2", "| 5", "| 10"]
    assert all(step.measurements[i].text(outcome.values[i][2]) in text[4] for i in (0, 1))
    assert lesson_html(fill(step, step.observe, outcome, "en")).count("<td") == 12
    assert (
        "with n = 2" in outcome.lines(step, "en")[0]
        and "with n = 2" not in outcome.lines(step, "en", ["bias"])[0]
    )


def test_the_number_for_another_dead_time_is_only_in_the_text() -> None:
    for id in ("swing", "camera"):
        step = step_of("robot", id)
        (number,) = (m for m in step.measurements if m.name == "dead_time_number")
        outcome = reference(step, step.setup)
        assert "a T" not in " ".join(outcome.lines(step, "en"))
        assert number.text(outcome.known(step)[number.id][1]) in fill(step, step.explain, outcome, "en")


def test_the_contrast_of_a_swinging_elbow_is_an_elbow_at_rest(approve: Approve) -> None:
    step = our_book().lessons[0].steps[0]
    answer = step.question.choices[0] if step.question else None
    assert answer is not None and answer.why is not None
    made = contrast_of(step.setup, answer.why, answer, "en")
    approve("swing.txt", f"{made.headline}\n")


def test_runs_that_differ_in_more_than_a_number_have_names(approve: Approve) -> None:
    """In the lever's table they have the names of the plots."""
    tables = ((4, 1, "step"), (3, 0, "lost,error,step"), (9, 1, "textbook"))
    made = [
        fill(our_book().lessons[lesson].steps[step], f"{{table:{names}}}", None, "en")
        for lesson, step, names in tables
    ]
    approve("tables.txt", "\n\n".join(text.strip() for text in made) + "\n")


def test_a_verdict_omits_measurements_that_the_reply_contains() -> None:
    """A line is omitted if the reply has all its numbers and it is not the only line."""
    left_out = 0
    for lesson in our_book().lessons:
        for step in lesson.steps:
            if step.question is None or step.concept:
                continue
            values = tuple((1.0, *(2.0 for _ in m.compare)) for m in step.measurements)
            outcome = StepOutcome(values, True)
            shown = len(outcome.lines(step, "en"))
            for choice in step.question.choices:
                told = told_in(step, choice.reply)
                lines = outcome.lines(step, "en", (), told)
                expected = sum(not m.text_only and m.id not in told for m in step.measurements) or shown
                assert len(lines) == expected >= min(shown, 1)
                left_out += shown - expected
    assert left_out > 10
