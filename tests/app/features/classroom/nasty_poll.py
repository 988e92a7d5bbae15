"""A poll with hostile texts in every field."""

from app.features.classroom.classroom import Poll
from app.features.lessons.outcomes import AnswerVerdict
from app.features.lessons.tally import Tally
from tests.app.features.test_templates import NASTY, nasty_lesson


def poll() -> Poll:
    lesson = nasty_lesson()
    verdict = AnswerVerdict(True, NASTY, NASTY, (NASTY,))
    tally = Tally((1, 1), 1, 2)
    return Poll(
        question=(lesson.id, "a"),
        choices=(NASTY, NASTY),
        tally=tally,
        open=False,
        revealed=True,
        outcome=(NASTY,),
        right=0,
        verdicts=(verdict, verdict),
        staged=(0, 1),
    )
