"""A class's answers to a test that is asked before the lessons and after them, from votes and from sessions of their own."""

from app.classroom.ballots import Ballots
from app.classroom.student_work import StudentWork
from app.lessons.lesson import LAST, LessonBook
from app.lessons.tally import QuestionId


def paired_answers(book: LessonBook, ballots: Ballots, work: StudentWork) -> dict[QuestionId, tuple[tuple[int, int], ...]]:
    """Return question → answers before and after of every student who gave both, without names and in no one's order.

    What counts is a student's first vote, and without one the answer in a session of their own.
    """
    own, paired = work.choices, dict[QuestionId, tuple[tuple[int, int], ...]]()

    def answers(question: QuestionId) -> dict[str, int]:
        voted = {student: ballot.choice for student, ballot in ballots.counted_rounds_of(question)[0].items()}
        return own.get(question, {}) | {student: choice for student, choice in voted.items() if choice is not None}

    for lesson in book.lessons:
        for step in lesson.steps if lesson.asked == "first" else ():
            before, after = answers((lesson.id, step.id)), answers((lesson.id + LAST, step.id))
            both = sorted((before[student], after[student]) for student in before.keys() & after.keys())
            if both:
                paired[lesson.id, step.id] = tuple(both)
    return paired
