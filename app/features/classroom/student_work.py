"""Students' own progress and hand-ins, and the teacher's board."""

from collections.abc import Mapping
from random import SystemRandom
from typing import Final, NamedTuple

from app.features.classroom.class_record import NEW_CLASS, ClassRecord
from app.features.classroom.class_summary import HandIn
from app.features.lessons.bookmark import Bookmark, is_finished
from app.features.lessons.progress import Progress, StepProgress, from_json
from app.features.lessons.tally import QuestionId
from app.web.traffic_limits import remember

LONGEST_NAME: Final = 60
"""Longest name [characters]."""

MOST: Final = 1000
"""Most students with kept work; the oldest is dropped."""


class StudentWork:
    """Progress, passed challenges and hand-ins; a report has only handed-in work.

    `nearest`: smallest d − d_m of all pushes in a duel [m].
    """

    def __init__(self, record: ClassRecord = NEW_CLASS) -> None:
        self.passed = {question: set(students) for question, students in record.passed.items()}
        self.hand_ins, self.nearest = dict(record.hand_ins), dict(record.nearest)
        # A repeated hand-in has at least the earlier work.
        self._progress = {student: report.progress for student, report in record.hand_ins.items()}

    def note(self, student: str, progress: str) -> None:
        """Record a student's progress (JSON): passed challenges and smallest distances are kept."""
        remember(self._progress, student, progress, MOST)
        for question, done in from_json(progress).steps.items():
            if done.passed:
                self.passed.setdefault(question, set()).add(student)
            if done.tries:
                nearest = min(one.measured for one in done.tries)
                self.nearest[question] = min(nearest, self.nearest.get(question, nearest))

    def progress_of(self, student: str) -> str:
        return self._progress.get(student, "")

    @property
    def choices(self) -> dict[QuestionId, dict[str, int]]:
        found: dict[QuestionId, dict[str, int]] = {}
        for student, progress in self._progress.items():
            for question, done in from_json(progress).steps.items():
                if done.choice is not None:
                    found.setdefault(question, {})[student] = done.choice
        return found

    def hand_in(self, student: str, report: HandIn | None) -> None:
        """None withdraws the report."""
        if report is None:
            self.hand_ins.pop(student, None)
        else:
            remember(self.hand_ins, student, report, MOST)


def clean_name(text: str, longest: int = LONGEST_NAME) -> str:
    """One line of at most `longest` visible characters."""
    line = " ".join(text.split())
    return "".join(character for character in line if character.isprintable())[:longest].strip()


NAMES: Final = tuple(
    "Abel Agnesi Apollonius Archimedes Aryabhata Banach Bernoulli Bhaskara Bolzano Brahmagupta Cantor Cartwright Cauchy Cayley Châtelet "  # noqa: SIM905
    "Chebyshev Clairaut Descartes Diophantus Dirichlet Eratosthenes Erdős Euclid Euler Fermat Fibonacci Fourier Galois Gauss Germain Gödel "
    "Grassmann Green Hamilton Heron Hilbert Hopper Hypatia Jacobi Kepler Khayyam Klein Kovalevskaya Lagrange Laplace Legendre Leibniz Liu "
    "Lovelace Madhava Menger Mirzakhani Möbius Napier Newton Noether Pascal Peano Plemelj Poincaré Ptolemy Pythagoras Ramanujan Riemann "
    "Robinson Seki Somerville Stokes Sylvester Thales Turing Vega Viète Weierstrass Wronski Zu".split()
)
"""Mathematicians: enough that a lecture hall's names need no numbers."""

STUCK: Final = 180.0
"""Time at one place after which a student is stuck [s]."""


class Cell(NamedTuple):
    """One student's step. `tries`: at its challenge; `minutes`: stuck time, or 0."""

    finished: bool = False
    tries: int = 0
    here: bool = False
    minutes: int = 0


class BoardRow(NamedTuple):
    """One student, or a group of `members`. `lesson`: number of their lesson, 0 for the board's."""

    name: str
    cells: tuple[Cell, ...]
    lesson: int = 0
    members: int = 1


class ProgressBoard:
    """Belongs to the shared session's thread. `names`: invented names by student."""

    def __init__(self) -> None:
        self.names: dict[str, str] = {}
        self._drawn: list[str] = []
        self._seen: dict[str, tuple[Progress, object, float]] = {}

    # ---- invented names ----------------------------------------------------------------------------------------------------

    def name_of(self, student: str) -> str:
        """Invented name, drawn once."""
        if student not in self.names:
            turn, taken = 0, set(self.names.values())
            while not self._drawn:
                turn += 1
                names = (
                    name if turn == 1 else f"{name} {turn}"
                    for name in SystemRandom().sample(NAMES, len(NAMES))
                )
                self._drawn = [name for name in names if name not in taken]
            self.names[student] = self._drawn.pop()
        return self.names[student]

    def student_of(self, name: str) -> str | None:
        return next((student for student, own in self.names.items() if own == name), None)

    # ---- progress ----------------------------------------------------------------------------------------------------------

    def note(self, student: str, progress: str, now: float) -> None:
        """Record a student's progress (JSON). `now`: time [s]."""
        self.name_of(student)
        seen = from_json(progress)
        place = seen.lesson, seen.step, seen.phase, seen.at(seen.lesson, seen.step).passed
        before = self._seen.get(student)
        self._seen[student] = seen, place, before[2] if before is not None and before[1] == place else now

    def progress_of(self, student: str) -> Progress:
        return self._seen[student][0] if student in self._seen else Progress()

    def rows(self, groups: Mapping[str, int], at: Bookmark, now: float) -> tuple[BoardRow, ...]:
        """Rows of the exploring students, by name.

        `groups`: number of students in each; `at`: the board's lesson, and the first step; `now`: time
        [s].
        """
        return tuple(
            sorted(self._row(group, at, now)._replace(members=members) for group, members in groups.items())
        )

    def _row(self, student: str, at: Bookmark, now: float) -> BoardRow:
        lesson, begin = at.lesson, (at.lesson.id, at.step.id)
        seen, _, since = self._seen.setdefault(student, (Progress(*begin), None, now))
        minutes = int((now - since) // 60.0) if now - since >= STUCK else 0
        cells: list[Cell] = []
        for step in lesson.steps:
            done = seen.steps.get((lesson.id, step.id), StepProgress())
            finished, here = is_finished(step, done), (seen.lesson, seen.step) == (lesson.id, step.id)
            cells.append(Cell(finished, done.attempts, here, minutes if here and not finished else 0))
        elsewhere = next((one.number for one in at.book.lessons if one.id == seen.lesson != lesson.id), 0)
        return BoardRow(self.name_of(student), tuple(cells), elsewhere)
