"""What students have done in sessions of their own, and the reports that they have handed in, by the id of each student's tab."""

from typing import Final

from app.export.class_summary import HandIn
from app.hosting.visitor_record import ClassRecord
from app.lessons.progress import from_json
from app.lessons.tally import QuestionId
from app.web.traffic_limits import remember

LONGEST_NAME: Final = 60
"""Characters of a name."""

MOST: Final = 1000
"""Students of whom the newest work is kept; the one that was kept longest makes room."""


class StudentWork:
    """Progress, passed challenges and handed-in reports. What a student has done is in a report only if the student hands it in.

    Attributes:
        hand_ins: all reports, by student; see `hand_in`.
        nearest: lesson and step of a duel → the smallest d less d_m of all students' pushes [m].
    """

    def __init__(self) -> None:
        self._progress: dict[str, str] = {}
        self._passed: dict[QuestionId, set[str]] = {}
        self.hand_ins: dict[str, HandIn] = {}
        self.nearest: dict[QuestionId, float] = {}

    def note(self, student: str, progress: str) -> None:
        """Take a student's progress, as JSON, in place of an earlier one; a challenge once passed stays passed, and a record is kept."""
        remember(self._progress, student, progress, MOST)
        for question, done in from_json(progress).steps.items():
            if done.passed:
                self._passed.setdefault(question, set()).add(student)
            if done.tries:
                nearest = min(one.measured for one in done.tries)
                self.nearest[question] = min(nearest, self.nearest.get(question, nearest))

    def progress_of(self, student: str) -> str:
        """Return a student's newest progress as JSON; "" for none."""
        return self._progress.get(student, "")

    @property
    def choices(self) -> dict[QuestionId, dict[str, int]]:
        """Return the answers of all students in sessions of their own, by question and student."""
        found: dict[QuestionId, dict[str, int]] = {}
        for student, progress in self._progress.items():
            for question, done in from_json(progress).steps.items():
                if done.choice is not None:
                    found.setdefault(question, {})[student] = done.choice
        return found

    def hand_in(self, student: str, report: HandIn) -> None:
        """Take a report in place of the student's earlier one."""
        remember(self.hand_ins, student, report, MOST)

    @property
    def passed(self) -> dict[QuestionId, tuple[str, ...]]:
        """Return the students who have passed each challenge."""
        return {question: tuple(sorted(students)) for question, students in self._passed.items()}

    def restore(self, record: ClassRecord) -> None:
        """Take up what `passed` has returned, `hand_ins` and `nearest`."""
        self.nearest = dict(record.nearest)
        self._passed = {question: set(students) for question, students in record.passed.items()}
        self.hand_ins = dict(record.hand_ins)
        # What is handed in again is no less than before.
        self._progress = {student: report.progress for student, report in record.hand_ins.items()}


def clean_name(text: str, longest: int = LONGEST_NAME) -> str:
    """Return a name, or another text of at most so many characters, on one line, without characters that are not seen."""
    line = " ".join(text.split())
    return "".join(character for character in line if character.isprintable())[:longest].strip()
