"""The class without a page: answers are counted once and without names; groups share the places fairly."""

import re
from dataclasses import replace
from typing import NoReturn

from hypothesis import given
from hypothesis import strategies as st

from app.features.classroom.ballots import Ballots
from app.features.classroom.breakout_places import HOLD, BreakoutPlaces, group_size
from app.features.classroom.class_record import ClassRecord
from app.features.classroom.class_summary import HandIn
from app.features.classroom.classroom import Classroom
from app.features.classroom.classroom_html import heads_html, mine_html, poll_html
from app.features.lessons.bookmark import Phase
from app.features.lessons.library import Library
from app.features.lessons.outcomes import reference
from app.features.lessons.progress import StepProgress, from_json
from app.features.lessons.tally import Ballot, QuestionId, Tally
from app.features.lessons.walkthrough import Walkthrough
from app.hosting.teacher_key import is_mistaken, is_teacher
from app.plots.curve_chart import COLUMNS
from tests.app.features.lessons.helpers import our_book
from tests.app.html_reader import HtmlReader
from tests.approved import Approve, shown_text

BOOK = our_book()


def fail() -> NoReturn:
    raise AssertionError("there is no poll")


PLACE: QuestionId = ("redundancy", "one")
WHO = st.sampled_from(("ann", "bo", "cy", "di", "ed"))


@given(st.lists(st.tuples(WHO, st.integers(0, 3))), st.sets(WHO))
def test_only_the_newest_answer_of_each_student_counts_until_the_reveal(
    answers: list[tuple[str, int]], here: set[str]
) -> None:
    ballots = Ballots()
    assert all(ballots.answer(PLACE, who, choice) for who, choice in answers)
    newest = dict(answers)
    tally = ballots.counts(PLACE, 4, here).newest
    assert tally.counts == tuple(sum(c == i for c in newest.values()) for i in range(4))
    assert tally.waiting == len(here - set(newest)) and tally.answered == len(newest)
    assert tally.counts[tally.favourite] == max(tally.counts) if tally.favourite is not None else not newest
    ballots.reveal(PLACE)
    assert (
        not any(ballots.answer(PLACE, who, 0) for who in here)
        and ballots.counts(PLACE, 4, here).newest == tally
    )
    assert ballots.answer(("redundancy", "two"), "ann", 2), "another question is still open"
    ballots.ask_again(PLACE)
    assert PLACE not in ballots.revealed and ballots.counts(PLACE, 4, here).newest.answered == 0
    assert ballots.ballots_of("ann").get(("redundancy", "two")) == Ballot(2) and ballots.answer(
        PLACE, "ann", 1
    )


ROUND = st.dictionaries(WHO, st.integers(0, 3), min_size=1)


@given(st.lists(ROUND, min_size=2, max_size=4), st.booleans())
def test_a_round_is_never_changed_by_a_later_one(rounds: list[dict[str, int]], revealed: bool) -> None:
    ballots = Ballots()
    for number, answers in enumerate(rounds):
        before = ballots.rounds_of(PLACE)[:-1] if number else ()
        for student, choice in answers.items():
            assert ballots.answer(PLACE, student, choice)
        assert ballots.rounds_of(PLACE)[:-1] == before
        if number + 1 < len(rounds):
            if revealed:
                ballots.reveal(PLACE)
            ballots.ask_again(PLACE)
            # A second call without an answer adds no round.
            ballots.ask_again(PLACE)
    assert [{who: ballot.choice for who, ballot in one.items()} for one in ballots.rounds_of(PLACE)] == rounds
    first, last = rounds[0], rounds[-1]
    _, tally, switches = ballots.counts(PLACE, 4, ())
    assert tally is not None and sum(tally.counts) == tally.answered == len(first)
    assert sum(one.students for one in switches) == len(first.keys() & last.keys())
    for i in range(4):
        stayed_or_left = sum(one.students for one in switches if one.before == i)
        assert stayed_or_left == sum(first[who] == i for who in first.keys() & last.keys())
    for student in first:
        assert ballots.first_ballot_of(PLACE, student).choice == first[student]
    *earlier, newest = ballots.rounds[PLACE]
    again = Ballots(ClassRecord(ballots={PLACE: newest}, earlier={PLACE: tuple(earlier)}))
    assert again.rounds_of(PLACE) == ballots.rounds_of(PLACE) and again.ballots_of(
        "ann"
    ) == ballots.ballots_of("ann")


def test_a_resumed_class_keeps_questions_in_order_of_first_answers() -> None:
    ballots, first, second = Ballots(), ("redundancy", "two"), PLACE
    ballots.ask_again(second)
    for question in (first, second):
        ballots.answer(question, "ann", 0)
    ballots.ask_again(second)
    rounds = ballots.rounds
    newest, earlier = {q: given[-1] for q, given in rounds.items()}, {second: rounds[second][:-1]}
    again = Ballots(ClassRecord(ballots=newest, earlier=earlier))
    assert ballots.questions == again.questions == (first, second) and again.rounds == rounds


def test_a_students_text_has_no_double_full_stop_and_no_keys_on_a_phone() -> None:
    classroom, walk = Classroom(8), Walkthrough(BOOK)
    for lesson in BOOK.lessons:
        walk.go(lesson.id, 0)
        poll = classroom.poll(walk)
        for choice in range(len(poll.choices) if poll is not None else 0):
            assert ".." not in re.sub("<[^>]*>", "", str(mine_html(poll or fail(), Ballot(choice))))
        if poll is not None:
            assert "with the keys 1 to" in mine_html(poll, Ballot()) and "keys" not in mine_html(
                poll, Ballot(), keys=False
            )


def test_a_student_reads_instructions_and_the_state_of_the_answer(approve: Approve) -> None:
    classroom, walk = Classroom(8), Walkthrough(BOOK)
    asked = classroom.poll(walk) or fail()
    closed, again = replace(asked, open=False, revealed=True), replace(asked, round=2)
    said = {
        "asked": mine_html(asked, Ballot()),
        "asked, on a phone": mine_html(asked, Ballot(), keys=False),
        "answered": mine_html(asked, Ballot(1)),
        "revealed": mine_html(closed, Ballot(1)),
        "revealed, without an answer": mine_html(closed, Ballot()),
        "asked again": mine_html(again, Ballot(), Ballot(1)),
        "answered again": mine_html(again, Ballot(2), Ballot(1)),
    }
    approve("what a student reads.txt", "".join(f"# {when}\n{shown_text(one)}" for when, one in said.items()))


def test_the_teacher_reads_the_number_of_followers_and_explorers(approve: Approve) -> None:
    classroom = Classroom(2)
    said = [heads_html(classroom, 3)]
    for number, who in enumerate(("ann", "bo", "cy")):
        classroom.enter(number, who)
    said.append(heads_html(classroom))
    classroom.free, classroom.paused = True, True
    classroom.settle(classroom.here[:2], 0.0)
    classroom.work.hand_in("ann", HandIn("Ann", ""))
    said.append(heads_html(classroom, 60))
    approve("how many are where.txt", "\n".join(map(shown_text, said)))


def test_both_rounds_are_shown_side_by_side_and_a_tie_is_named(approve: Approve) -> None:
    classroom, walk = Classroom(8), Walkthrough(BOOK)
    walk.go("lambda", 1)
    question = (walk.lesson.id, walk.step.id)
    assert walk.step.question is not None and walk.step.question.right == 0
    for student, choice in (("ann", 1), ("bo", 1), ("cy", 0), ("di", 2)):
        assert classroom.answer(walk, student, choice)
    assert classroom.draw(walk, "ann", question, HALF)
    shown = poll_html(classroom.poll(walk) or fail())
    assert "Round" not in shown and "A tie" not in shown
    classroom.ballots.ask_again(question)
    for student, choice in (("ann", 0), ("bo", 1), ("cy", 1), ("ed", 0)):
        assert classroom.answer(walk, student, choice)
    assert classroom.draw(walk, "ann", question, FULL) and classroom.draw(walk, "ed", question, FULL)
    poll = classroom.poll(walk) or fail()
    shown = poll_html(poll, live=True)
    HtmlReader(str(shown).replace("/>", "></path>"))
    assert (
        shown.count(">Round 1<") == shown.count(">Round 2<") == 4
        and "width:25%" in shown
        and "width:50%" in shown
    )
    approve("poll asked twice.txt", shown_text(shown))
    assert shown.count('class="first"') == 2, "the curve of the first round, and its median"
    mine = mine_html(poll, Ballot(), Ballot(1))
    assert "Your first answer: <b>" in mine and "Asked again" in mine
    classroom.ballots.reveal(question)
    walk.choose(0)
    walk.next()
    shown = poll_html(classroom.poll(walk) or fail())
    approve("poll asked twice, after the run.txt", shown_text(shown))
    assert "The run" not in poll_html(replace(classroom.poll(walk) or fail(), runs=False)), (
        "the question has no run"
    )
    walk = Walkthrough(Library().book)
    walk.go("beliefs", 1)
    assert walk.step.concept and walk.step.measurements and not (classroom.poll(walk) or fail()).runs


def test_a_hand_in_has_the_work_of_the_shared_and_the_breakout_session() -> None:
    classroom, walk, own = Classroom(8), Walkthrough(BOOK), Walkthrough(BOOK)
    first = (walk.lesson.id, walk.step.id)
    assert not classroom.hand_in(walk, "ann", "Ann", "") and not classroom.work.hand_ins, (
        "there is no work yet"
    )
    assert classroom.answer(walk, "ann", 1)
    classroom.ballots.ask_again(first)
    assert classroom.answer(walk, "ann", 2)
    walk.done.outcome = reference(walk.step, walk.step.setup)
    # In a breakout session she opens another lesson, and is then called back.
    own.go("lambda", 1)
    own.choose(0)
    own.give_reason("it halves", "lambda", own.step.id)
    own.done.passed = True
    classroom.work.note("ann", own.to_json())
    assert classroom.hand_in(walk, "ann", "  Ann\n\u202eB ", "")
    report = classroom.work.hand_ins["ann"]
    assert report.name == "Ann B" and report.answers == {first: (1, 2)}
    steps = from_json(report.progress).steps
    assert steps[first] == StepProgress(choice=2, outcome=walk.done.outcome)
    assert steps["lambda", own.step.id].because == "it halves" and steps["lambda", own.step.id].choice == 0
    summary = classroom.summary(BOOK, 5.0)
    assert (
        summary.students == 1
        and summary.hand_ins == (report,)
        and summary.passed == {("lambda", own.step.id): 1}
    )
    assert [tally.counts[:3] for tally in summary.asked[0].rounds] == [(0, 1, 0), (0, 0, 1)]
    # After the hand-in is withdrawn, only her counts remain.
    del classroom.work.hand_ins["ann"]
    assert (
        "halves" not in str(classroom.summary(BOOK, 5.0))
        and classroom.summary(BOOK, 5.0).asked == summary.asked
    )


def test_the_poll_opens_with_the_question_and_closes_with_the_outcome() -> None:
    classroom, walk = Classroom(8), Walkthrough(BOOK)
    assert classroom.poll(None) is None and not classroom.answer(None, "ann", 0)
    walk.go(0, 0)
    question = walk.step.question
    assert question is not None and walk.phase is Phase.PREDICT
    classroom.enter(1, "ann")
    classroom.enter(2, "bo")
    classroom.enter(3, "bo")
    assert (
        classroom.answer(walk, "ann", question.right)
        and not classroom.answer(walk, "ann", 99)
        and not classroom.answer(walk, "ann", -1)
    )
    poll = classroom.poll(walk)
    assert (
        poll is not None
        and poll.open
        and not poll.revealed
        and poll.tally.waiting == 1
        and poll.right is None
    )
    assert not poll.verdicts and not poll.outcome and len(poll.choices) == len(question.choices)
    # Answers may change during the run, but not after the outcome is shown.
    walk.choose(0)
    assert classroom.answer(walk, "bo", (question.right + 1) % len(question.choices))
    walk.done.outcome = reference(walk.step, walk.step.setup)
    walk.next()
    assert walk.phase is Phase.OBSERVE and not classroom.answer(walk, "bo", question.right)
    poll = classroom.poll(walk)
    assert (
        poll is not None
        and not poll.open
        and poll.right == question.right
        and poll.outcome
        and poll.tally.answered == 2
    )
    assert [v is not None and v.right for v in poll.verdicts] == [
        i == question.right for i in range(len(poll.choices))
    ]
    # Going back shows the question again, still closed.
    walk.back()
    poll = classroom.poll(walk)
    assert poll is not None and not poll.open and poll.right is None and not poll.verdicts


def test_a_restarted_step_asks_its_question_again() -> None:
    classroom, walk = Classroom(8), Walkthrough(BOOK)
    classroom.enter(1, "ann")
    assert classroom.answer(walk, "ann", 1)
    classroom.ballots.reveal((walk.lesson.id, walk.step.id))
    walk.choose(1)
    assert not classroom.answer(walk, "ann", 2)
    walk.reset()
    assert (
        classroom.answer(walk, "ann", 2)
        and classroom.ballots.ballot_of((walk.lesson.id, walk.step.id), "ann").choice == 2
    )


HALF = (0.5,) * COLUMNS
FULL = (1.0,) * COLUMNS


def test_a_curve_is_counted_with_the_answers_and_shown_without_a_name(approve: Approve) -> None:
    classroom, walk = Classroom(8), Walkthrough(BOOK)
    walk.go("lambda", 1)
    question = (walk.lesson.id, walk.step.id)
    for number, student in enumerate(("ann", "bo", "cy"), 1):
        classroom.enter(number, student)
    assert (
        classroom.draw(walk, "ann", question, HALF)
        and classroom.draw(walk, "bo", question, FULL)
        and classroom.answer(walk, "bo", 0)
    )
    assert not classroom.draw(walk, "cy", ("lambda", "tail"), HALF), "the curve is for another step"
    assert not classroom.draw(walk, "cy", question, (2.0,) * COLUMNS), "the curve leaves the axis"
    poll = classroom.poll(walk)
    assert poll is not None and poll.tally == Tally((1, 0, 0, 0), 1, 2, (HALF, FULL)) and poll.truth == ()
    assert (
        classroom.draw(walk, "ann", question, ())
        and classroom.ballots.counts(question, 4, classroom.here).newest.waiting == 2
    ), "a withdrawn curve does not count"
    assert classroom.draw(walk, "ann", question, HALF)
    shown = poll_html(classroom.poll(walk) or poll, live=True)
    # A curve alone is not an answer.
    approve("poll with curves.txt", shown_text(shown))
    assert "ann" not in shown and shown.count('stroke-opacity="0.3"') == 2
    # A student who explores finds his or her curve in the breakout session.
    assert from_json(classroom.progress_of("ann", walk)).steps[question] == StepProgress(drawing=HALF)
    walk.draw(HALF)
    classroom.ballots.reveal(question)
    assert not classroom.draw(walk, "cy", question, HALF)
    walk.choose(0)
    walk.next()
    poll = classroom.poll(walk)
    assert (
        poll is not None
        and poll.truth == reference(walk.step, walk.step.setup).curve
        and "by the formula" in poll_html(poll)
    )
    approve("own curve after the run.txt", shown_text(mine_html(poll, Ballot(None, HALF))))


def test_students_without_a_place_are_put_into_lasting_groups() -> None:
    assert [group_size(*one) for one in ((60, 22), (22, 22), (23, 22), (0, 22), (3, 0))] == [3, 1, 2, 1, 3]
    places, class_of_60 = BreakoutPlaces(22), [f"student {i}" for i in range(60)]
    places.give(class_of_60, 0.0)
    assert len(places.sizes) == 20 and {len(places.members(one)) for one in places.groups.values()} == {3}
    before = dict(places.groups)
    # Late students get new groups while there are places, and then join the smallest group.
    late = [f"late {i}" for i in range(7)]
    places.give([*class_of_60, *late[:6]], 1.0)
    assert len(places.sizes) == 22 and {len(places.members(one)) for one in places.groups.values()} == {3}
    places.give([*class_of_60, *late], 1.0)
    assert len(places.sizes) == 22 and len(places.members(places.groups[late[6]])) == 4
    # A student returns to the same group after a reload or longer, and so do all the next time, in any order.
    places.give(class_of_60[1:], HOLD)
    assert places.holds(class_of_60[0]), "an absence within HOLD, like a reload, keeps the place"
    places.give(class_of_60[1:], HOLD + 2.0)
    assert not places.holds(class_of_60[0]) and places.holds(class_of_60[1])
    places.take_all()
    assert len(places.sizes) == 0
    places.give(class_of_60[::-1], 100.0)
    assert {one: places.groups[one] for one in class_of_60} == before
    # With a place for each student there are no groups.
    few = BreakoutPlaces(3)
    few.give(("ann", "bo", "cy", "ann"), 0.0)
    assert few.groups == {"ann": "ann", "bo": "bo", "cy": "cy"}
    few.give(("ann", "bo", "cy", "di"), 1.0)
    assert few.groups["di"] == "ann" and len(few.sizes) == 3


@given(st.lists(st.lists(st.integers(0, 12), max_size=14), max_size=8), st.integers(1, 5))
def test_every_student_has_a_group_and_sessions_never_exceed_places(
    rounds: list[list[int]], most: int
) -> None:
    places = BreakoutPlaces(most)
    for now, here in enumerate(rounds):
        places.give(map(str, here), 20.0 * now)
        assert all(places.holds(str(one)) for one in here) and len(places.sizes) <= most


def test_a_following_student_holds_no_place() -> None:
    classroom = Classroom(1)
    for number, who in enumerate(("ann", "bo", "bo")):
        classroom.enter(number, who)
    classroom.settle(classroom.here, 0.0)
    assert classroom.heads == (2, 0)
    classroom.free = True
    classroom.settle(classroom.here, 0.0)
    assert classroom.heads == (2, 2) and classroom.groups == {"ann": 2}
    # After a recall they explore together again; with a place for each student there are no groups.
    classroom.note("ann", '{"version": 1}', 0.0)
    assert classroom.has_work("bo") and classroom.has_work("ann")
    classroom.follow()
    classroom.explore()
    classroom.settle(classroom.here, 0.0)
    assert classroom.groups == {"ann": 2}
    classroom.follow()
    classroom.places.most = 2
    classroom.explore()
    classroom.settle(classroom.here, 0.0)
    assert classroom.groups == {"ann": 1, "bo": 1}
    classroom.wanted = "ann"
    classroom.follow()
    assert not classroom.wanted, "a requested run is not shown when they explore again"
    classroom.leave(0)
    classroom.leave(99)
    assert classroom.heads == (1, 0) and not classroom.free


@given(st.text(max_size=40), st.text(max_size=40))
def test_only_the_exact_key_opens(key: str, given_key: str) -> None:
    assert is_teacher(key, {"key": given_key}) == (key == given_key)
    assert is_mistaken(key, {"key": given_key}) == (key != given_key and given_key != "")
    assert is_teacher(key, {}) == (key == "") and not is_mistaken(key, {})
    assert not is_teacher(None, {"key": given_key}) and not is_mistaken(None, {"key": given_key})
