"""The test before and after the lessons: its answers hold on the model, the first time without solutions."""

import json
import re
from collections.abc import Sequence

import numpy as np
import pytest

from app.features.handout.handout_html import handout_html
from app.features.handout.moodle_xml import moodle_xml
from app.features.lab_report.gain import gains, own_pairs, whole
from app.features.lab_report.lab_report import done_in, lab_bytes
from app.features.lessons.bookmark import Phase
from app.features.lessons.check import check_lesson
from app.features.lessons.lesson import LAST, Lesson
from app.features.lessons.library import Library
from app.features.lessons.panel.lesson_html import blocks_html
from app.features.lessons.reference_runs import simulated
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.walkthrough import Walkthrough
from app.features.measures.evidence import Evidence
from app.session.session import Session
from app.settings import LANGUAGES, Settings
from controllers.kinematics import Array, null_space_projector
from tests.app.html_reader import HtmlReader

pytestmark = pytest.mark.slow

BOOK = Library().book
FIRST, LAST_TEST = BOOK.lessons[0], BOOK.lessons[-1]


def right(lesson: Lesson, index: int) -> int:
    question = lesson.steps[index].question
    assert question is not None
    return question.right


def replies(lesson: Lesson) -> list[str]:
    return [
        choice.reply[:20]
        for step in lesson.steps
        if step.question is not None
        for choice in step.question.choices
    ]


@pytest.mark.thorough
def test_thirteen_questions_with_one_belief_each_in_every_language() -> None:
    assert (FIRST.asked, LAST_TEST.asked, FIRST.id + LAST) == ("first", "last", LAST_TEST.id)
    beliefs = set[str]()
    for language in LANGUAGES:
        lesson = BOOK.in_language(language).lessons[0]
        assert not re.search(r"\d", lesson.goal), "no lesson numbers: they differ in a playlist"
        assert (
            lesson.language == language
            and len(lesson.steps) == 13
            and all(step.concept for step in lesson.steps)
        )
        beliefs |= {step.belief.partition("\n")[0] for step in lesson.steps}
    assert len(beliefs) == 13 * len(LANGUAGES)
    for lesson in (FIRST, LAST_TEST):
        walks = check_lesson(BOOK, lesson)
        assert [walk for walk in walks if not walk.ok] == [] and len(walks) > 20
    derived = [step.id for step in FIRST.steps if step.question is not None and not step.question.expects]
    assert derived == ["null_space", "priority", "clipping"], "the next test checks these on the model"


def jacobians(step: str) -> tuple[Array, Array]:
    """Jacobian of the hand (6, 7) and row of the distance (7,) at the end of a step's run."""
    evidence = Evidence(simulated(next(one for one in FIRST.steps if one.id == step).setup))
    row = evidence.lever(evidence.rows - 1) if step != "null_space" else np.zeros(7)
    # Away from the symmetric start posture.
    evidence.kinematics.update(evidence.positions[-1] + np.linspace(0.1, 0.4, evidence.positions.shape[1]))
    return evidence.kinematics.hand_jacobian(evidence.arm).copy(), row.copy()


def test_answers_without_a_number_of_a_run_hold_on_the_model() -> None:
    J, _ = jacobians("null_space")
    projector = null_space_projector(J)
    assert np.trace(projector) == pytest.approx(1.0)
    motion = np.linalg.svd(projector)[0][:, 0]
    # A single motion, of all joints except the elbow.
    assert np.sum(np.abs(motion) > 0.01) == 6 and abs(motion[3]) < 1e-6
    J, row = jacobians("priority")
    for size in (0.1, 10.0):
        # For any request, the first task is fully done; the second loses only its part along the first.
        wanted, second = 0.3, size * np.array([0.3, -0.2, 0.1, 0.0, 0.0, 0.0])
        free = np.eye(7) - np.outer(row, row) / (row @ row)
        alone = np.linalg.pinv(J) @ second
        velocities = row * wanted / (row @ row) + free @ alone
        assert row @ velocities == pytest.approx(wanted)
        lost = alone - (velocities - row * wanted / (row @ row))
        assert np.linalg.norm(lost) > 1e-3 * size
        assert np.linalg.norm(lost - row * (row @ lost) / (row @ row)) < 1e-12 * size
    # One of seven velocities is halved: the hand deviates, and the distance may shrink instead of grow.
    random = np.random.default_rng(1)
    turned, signs = list[float](), set[bool]()
    for _ in range(200):
        # The others are near the limit of 2 rad/s.
        velocities = random.uniform(1.2, 2.0, 7) * random.choice((-1.0, 1.0), 7)
        velocities[random.integers(7)] = random.choice((-4.0, 4.0))
        cut = np.where(np.abs(velocities) > 2.0, velocities / 2.0, velocities)
        before, after = (J @ velocities)[:3], (J @ cut)[:3]
        turned.append(float(before @ after / np.linalg.norm(before) / np.linalg.norm(after)))
        signs.add(bool((row @ velocities) * (row @ cut) < 0.0))
    assert np.median(turned) < np.cos(np.deg2rad(10.0)) and min(turned) < 0.9 and True in signs


def shown(walk: Walkthrough) -> str:
    return "".join(blocks_html(walk.view(), (), False, True).values())


def test_first_answers_get_no_solutions_and_are_locked_by_the_last_test() -> None:
    walk, wrong = Walkthrough(BOOK), 0
    assert walk.lesson.id == "redundancy", "a student must begin with lesson 1"
    walk.go("beliefs")
    for index in range(13):
        assert walk.phases == (Phase.PREDICT,) and walk.choose(wrong if index % 2 else right(FIRST, index))
        assert (
            walk.view().verdict is None
            and walk.view().can_next
            and not any(text in shown(walk) for text in replies(FIRST))
        )
        assert walk.next()
    assert walk.lesson.id == "redundancy"
    student = json.loads(walk.to_json())
    assert "right" not in str(student["steps"])
    walk.go("beliefs" + LAST, 1)
    assert not walk.next() and walk.choose(right(FIRST, 1)) and walk.next()
    verdict = walk.view().verdict
    assert (
        verdict is not None
        and verdict.right
        and verdict.reply
        and "That is right" in shown(walk)
        and "0.98°" in shown(walk)
    )
    walk.reset()
    assert walk.done.choice == right(FIRST, 1), "an answer must stay after its solution is shown"
    walk.go("beliefs", 1)
    assert not walk.choose(right(FIRST, 1)) and walk.done.choice == wrong
    walk.reset()
    assert walk.done.choice == wrong
    walk.go("beliefs", 2)
    assert walk.choose(0), "the other questions must still be open"


def test_documents_taken_before_the_last_test_have_no_solutions() -> None:
    walk = Walkthrough(BOOK)
    walk.go("beliefs")
    assert walk.choose(0)
    report = lab_bytes(done_in(BOOK.lessons, walk.done_in, {}), "en").decode()
    taken = (report, handout_html(FIRST), moodle_xml(FIRST).decode())
    assert all("seven joints holds its hand still" in text for text in taken)
    assert [
        text for text in replies(FIRST) for page in taken if text in page
    ] == [] and "Before and after" not in report
    assert "cancel" in handout_html(FIRST, "") and "cancel" in moodle_xml(LAST_TEST).decode()


def test_a_session_without_a_run_continues_by_button_and_key() -> None:
    session = Session(Settings())
    run = LessonSession(session, BOOK)
    run.enter("beliefs" + LAST, 9)
    run.runner.further.result(60.0)
    for key in (do.Press("run"), do.Press("next")):
        run.act(key)
        assert run.walk.phase is Phase.PREDICT and session.paused
    run.act(do.Choose(2))
    run.act(do.Press("run"))
    assert run.walk.phase is Phase.OBSERVE and run.walk.done.outcome is not None and session.paused
    run.decide()
    run.act(do.Press("reset"))
    assert run.walk.done.choice == 2 and session.simulation.steps == 0 and not session.notices


def pairs_of(first: Sequence[int], last: Sequence[int]) -> dict[tuple[str, str], tuple[tuple[int, int], ...]]:
    return {("beliefs", "delay"): tuple(zip(first, last, strict=True))}


def test_the_gain_is_hakes_and_the_matrix_counts_every_student() -> None:
    delay = next(i for i, step in enumerate(FIRST.steps) if step.id == "delay")
    assert right(FIRST, delay) == 2
    (one,) = gains(pairs_of((0, 0, 1, 2, 2), (2, 1, 2, 2, 0)), BOOK.lessons)
    assert one.moved == ((0, 1, 1), (0, 0, 1), (1, 0, 1)) and one.belief == "Delay only slows."
    # Two of five right before, three after: one third of the possible gain.
    assert (one.gain.students, one.gain.before, one.gain.after) == (
        5,
        2,
        3,
    ) and one.gain.normalised == pytest.approx(1 / 3)
    assert one.gain.cells == ("5", "40 %", "60 %", "0.33")
    (all_right,) = gains(pairs_of((2, 2), (2, 0)), BOOK.lessons)
    assert all_right.gain.normalised is None and all_right.gain.cells[3] == "–"
    assert (
        whole([one, all_right]).normalised == pytest.approx(0.0)
        and gains(pairs_of((9,), (0,)), BOOK.lessons) == []
    )
    assert gains({("drift", "x"): ((0, 0),)}, BOOK.lessons) == []


def test_a_students_report_has_both_answers_after_the_last_test() -> None:
    walk = Walkthrough(BOOK)
    for lesson, answers in (("beliefs", (0, 0)), ("beliefs" + LAST, (2, 0))):
        for index, answer in enumerate(answers):
            walk.go(lesson, index)
            assert walk.choose(answer)
            walk.next()
    assert len(own_pairs(BOOK.lessons, walk.done_in)) == 2
    page = lab_bytes(done_in(BOOK.lessons, walk.done_in, {}, "beliefs" + LAST), "en").decode()
    text = " ".join(HtmlReader(page).text.split())
    assert (
        "Before and after" in text
        and "1 → 3" in text
        and "1 → 1" in text
        and "⟨g⟩ = 0.50" in text
        and "not validated" in text
    )
    assert "The null space is the rest of the joints." in text and "duet-report" not in page, (
        "the report must have no data for marks"
    )
