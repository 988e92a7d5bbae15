"""State machine of a class: answers, curves, hand-ins, teacher's actions, and crashes at any moment."""

from dataclasses import replace
from time import time

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from app.features.classroom.class_record import NAME, class_of, last_class_of, with_class
from app.features.classroom.class_summary import AskedQuestion, ClassSummary
from app.features.classroom.classroom import Poll
from app.features.lecture.class_messages import Progressed, Reported
from app.features.lecture.leader import HOLD
from app.features.lecture.teacher_control import Answer, Because, Teach, TeacherAction
from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import LAST
from app.features.lessons.progress import Progress, SavedLesson, StepProgress, Try, from_json, to_json
from app.features.lessons.session.lesson_actions import GoTo, Press
from app.features.lessons.tally import Ballot, QuestionId, switches_between, tally_of
from app.hosting.parking import AWAY
from app.hosting.visitor_record import VisitorRecord
from app.plots.curve_chart import COLUMNS
from tests.app.features.lecture.class_model import MOST_PLACES, BytesStore, ClassModel, Lecture, origin
from tests.app.features.lessons.helpers import lesson_in, our_book

BOOK = our_book()
PLACES: tuple[tuple[int, int], ...] = ((0, 0), (0, 1), (3, 1))
"""Steps with questions (lesson, step), 0-based; the last one also asks for a curve."""

TABS = tuple(f"{name:x<16}" for name in ("teacher", "ann", "bo", "cy", "di"))
ANYBODY, STUDENTS = st.sampled_from(TABS), st.sampled_from(TABS[1:])
QUESTIONS = tuple((BOOK.lessons[i].id, BOOK.lessons[i].steps[j].id) for i, j in PLACES)
ASKED = st.sampled_from(QUESTIONS)

CURVES = {"none": (), "half": (0.5,) * COLUMNS, "full": (1.0,) * COLUMNS, "beyond": (2.0,) * COLUMNS}
NAMES = {
    "none": ("", ""),
    "Ann": ("Ann", "Ann"),
    "lines": (" Bo\n\u202eB ", "Bo B"),
    "long": ("x" * 100, "x" * 60),
}
"""Typed name → name in the report."""

REASONS = {"none": "", "short": "it halves", "lines": " two\nlines "}
OWN = {
    "an answer": (QUESTIONS[0], StepProgress(choice=1)),
    "a challenge": (QUESTIONS[2], StepProgress(choice=0, attempts=1, passed=True)),
    "a duel": (("smooth", "rest"), StepProgress(tries=(Try(0.2, 0.03, True), Try(0.3, 0.01, False)))),
}
"""A student's work in a breakout session."""


def progress_with(own: str) -> str:
    return to_json(Progress("smooth", "rest", "do", dict([OWN[own]])))


def opened_lesson(record: VisitorRecord) -> tuple[SavedLesson, Progress]:
    """The teacher's lesson and progress, for comparison in any order of steps."""
    saved = lesson_in(record)
    assert saved is not None
    return replace(saved, progress=""), from_json(saved.progress)


class ClassMachine(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.store = BytesStore()
        self.clients = 0
        self.begin_class()
        self.resumed()

    def begin_class(self) -> None:
        self.model = ClassModel()
        self.names: dict[str, str] = {}
        self.worked: dict[str, str] = {}
        self.passed: dict[QuestionId, set[str]] = {}
        self.nearest: dict[QuestionId, float] = {}
        self.leads, self.watching = "", set[str]()

    def resumed(self) -> None:
        """Start a server without connections."""
        self.lecture = Lecture(self.store, BOOK, lambda: self.now)
        self.model.here.clear()
        self.pages: dict[int, bool] = {}
        self.leading: set[int] = set()
        self.left_at = self.now

    @initialize()
    def teacher_opens_a_lesson(self) -> None:
        self.connects(TABS[0], True)
        self.teacher_goes_to((0, 0))

    # ---- helpers -----------------------------------------------------------------------------------------------------------

    def poll(self) -> Poll | None:
        poll = self.lecture.control.poll()
        if poll is not None and poll.question in self.model.asked:
            walk, asked = self.lecture.lessons.walk, self.model.asked[poll.question]
            if asked.revealed and walk.phase is Phase.PREDICT and walk.done.untouched:
                # A restarted step asks its question again.
                self.asks_again(poll.question)
        return poll

    def asks_again(self, question: QuestionId) -> None:
        asked = self.model.asked.get(question)
        if asked is not None:
            asked.revealed = False
            if asked.rounds[-1]:
                asked.rounds.append({})

    def teach(self, what: TeacherAction, value: str = "") -> None:
        self.lecture.session.handlers.do(Teach(what, value))
        self.lecture.control.present()

    def put(self, question: QuestionId, student: str, ballot: Ballot) -> None:
        newest = self.model.ask(question).rounds[-1]
        if ballot._replace(reason="") == Ballot():
            newest.pop(student, None)
        else:
            newest[student] = ballot

    def ballot(self, question: QuestionId, student: str) -> Ballot:
        asked = self.model.asked.get(question)
        return Ballot() if asked is None else asked.rounds[-1].get(student, Ballot())

    @property
    def ballots_of(self) -> dict[str, list[QuestionId]]:
        found: dict[str, list[QuestionId]] = {}
        for question, asked in self.model.asked.items():
            for student in {student for given in asked.rounds for student in given}:
                found.setdefault(student, []).append(question)
        return found

    # ---- connections -------------------------------------------------------------------------------------------------------

    @rule(tab=ANYBODY, is_page=st.booleans())
    def connects(self, tab: str, is_page: bool) -> None:
        """The first tab leads, also when it reconnects; after a long absence a tab new in the class leads."""
        self.clients += 1
        leads = self.lecture.leader.admits(self.clients, {"resume": tab})
        vacant = not self.leading and self.now - self.left_at > HOLD
        assert leads == (self.leads in ("", tab) or (vacant and tab not in self.watching))
        if leads:
            self.leads = tab
            self.leading.add(self.clients)
            return
        self.watching.add(tab)
        self.lecture.classroom.enter(self.clients, tab, origin(self.clients, is_page))
        self.model.here[self.clients], self.pages[self.clients] = tab, is_page
        self.note_origin(tab, is_page)

    @precondition(lambda self: self.leading)
    @rule()
    def teacher_disconnects(self) -> None:
        for client in self.leading:
            self.lecture.leader.gone(client)
        self.leading.clear()
        self.left_at = self.now

    @precondition(lambda self: self.model.here)
    @rule(place=st.integers(0, 20))
    def student_disconnects(self, place: int) -> None:
        client = list(self.model.here)[place % len(self.model.here)]
        self.lecture.classroom.leave(client)
        del self.model.here[client]

    def note_origin(self, student: str, is_page: bool) -> None:
        if is_page:
            self.model.pageless.discard(student)
        else:
            self.model.pageless.add(student)

    def look_at_origin(self, student: str) -> None:
        """An answer checks the student's connections again; the last connection decides."""
        for client, one in self.model.here.items():
            if one == student:
                self.note_origin(student, self.pages[client])

    # ---- students ----------------------------------------------------------------------------------------------------------

    @rule(student=STUDENTS, choice=st.integers(-1, 4))
    def answers(self, student: str, choice: int) -> None:
        poll = self.poll()
        self.lecture.post(Answer(student, choice))
        if poll is not None and poll.open and 0 <= choice < len(poll.choices):
            self.look_at_origin(student)
            self.put(poll.question, student, self.ballot(poll.question, student)._replace(choice=choice))

    @rule(
        place=st.sampled_from(PLACES),
        choices=st.dictionaries(STUDENTS, st.integers(0, 3), min_size=1),
        ends=st.sampled_from(("open", "revealed", "asked again")),
    )
    def class_answers(self, place: tuple[int, int], choices: dict[str, int], ends: str) -> None:
        """A typical round of a question."""
        self.teacher_goes_to(place)
        for student, choice in choices.items():
            self.connects(student, True)
            self.answers(student, choice)
        if ends == "revealed":
            self.teacher_reveals()
        elif ends == "asked again":
            self.teacher_asks_again()

    @rule(student=STUDENTS, typed=st.sampled_from(tuple(REASONS)), question=ASKED)
    def gives_a_reason(self, student: str, typed: str, question: QuestionId) -> None:
        poll, reason = self.poll(), REASONS[typed]
        self.lecture.post(Because(student, question, reason))
        ballot = self.ballot(question, student)
        if poll is not None and poll.open and poll.question == question and ballot != Ballot():
            self.put(question, student, ballot._replace(reason=" ".join(reason.split())))

    @rule(student=STUDENTS, drawn=st.sampled_from(tuple(CURVES)), question=ASKED)
    def draws(self, student: str, drawn: str, question: QuestionId) -> None:
        poll, curve = self.poll(), CURVES[drawn]
        self.lecture.control.draw(student, question, curve)
        asks = poll is not None and poll.open and poll.question == question and poll.drawing is not None
        if asks:
            self.look_at_origin(student)
            if drawn != "beyond":
                self.put(question, student, self.ballot(question, student)._replace(curve=curve))

    @rule(student=STUDENTS, own=st.sampled_from(tuple(OWN)))
    def works_in_an_own_session(self, student: str, own: str) -> None:
        """All members of the group have the session's progress."""
        members = self.lecture.classroom.places.members(student) or (student,)
        self.lecture.post(Progressed(student, progress_with(own)))
        for one in members:
            self.works(one, progress_with(own))

    def works(self, student: str, progress: str) -> None:
        self.worked[student] = progress
        for question, done in from_json(progress).steps.items():
            if done.passed:
                self.passed.setdefault(question, set()).add(student)
            for one in done.tries:
                self.nearest[question] = min(one.measured, self.nearest.get(question, one.measured))

    @rule(student=STUDENTS, name=st.sampled_from(tuple(NAMES)), own=st.none() | st.sampled_from(tuple(OWN)))
    def hands_in(self, student: str, name: str, own: str | None) -> None:
        typed, shown = NAMES[name]
        progress = "" if own is None else progress_with(own)
        self.lecture.post(Reported(student, typed, progress))
        if progress:
            self.works(student, progress)
        questions = self.ballots_of.get(student, [])
        if student not in self.worked and not questions:
            return
        self.model.given[student] = shown
        report = self.lecture.classroom.work.hand_ins[student]
        rounds = {question: self.model.asked[question].rounds for question in questions}
        assert report.answers == {
            question: tuple(given.get(student, Ballot()).choice for given in rounds[question])
            for question in questions
        }
        steps = from_json(report.progress).steps
        assert from_json(self.worked.get(student, "")).steps.keys() <= steps.keys(), (
            "the hand-in has the breakout work"
        )
        for question in questions:
            newest = [given[student] for given in rounds[question] if student in given][-1]
            assert newest.choice in (None, steps[question].choice)
            assert steps[question].because == newest.reason and steps[question].drawing == newest.curve

    @rule(student=STUDENTS)
    def takes_back(self, student: str) -> None:
        self.lecture.post(Reported(student, None))
        self.model.given.pop(student, None)

    # ---- the teacher -------------------------------------------------------------------------------------------------------

    @rule(place=st.sampled_from(PLACES))
    def teacher_goes_to(self, place: tuple[int, int]) -> None:
        lessons = self.lecture.lessons
        if lessons.open:
            lessons.act(GoTo(*place))
        else:
            lessons.enter(*place)

    @rule(what=st.sampled_from(("next", "back", "reset", "leave", "hint")))
    def teacher_presses(self, what: str) -> None:
        walk, lessons = self.lecture.lessons.walk, self.lecture.lessons
        if what == "next" and lessons.open and walk.phase is Phase.DO:
            # Replaces the end of a run, which this test does not simulate.
            walk.next()
        lessons.act(Press("hint" if what == "next" and walk.phase is Phase.DO else what))  # pyright: ignore[reportArgumentType]

    @rule()
    def teacher_reveals(self) -> None:
        poll, walk = self.poll(), self.lecture.lessons.walk
        before = None if poll is None else walk.done.choice
        locked = self.lecture.lessons.locked
        self.teach("reveal")
        if poll is None or poll.revealed:
            return
        newest = self.model.counted(poll.question)[-1]
        if newest:
            self.model.ask(poll.question).revealed = True
        votes = [ballot.choice for ballot in newest.values() if ballot.choice is not None]
        if votes and locked:
            chosen = walk.done.choice
            assert chosen is not None, "the class has a prediction"
            assert votes.count(chosen) == max(map(votes.count, votes))
        else:
            assert walk.done.choice == before

    @rule()
    def teacher_asks_again(self) -> None:
        poll = self.poll()
        self.teach("again")
        if poll is not None:
            self.asks_again(poll.question)

    @rule(what=st.sampled_from(("on", "back", "pages", "free", "follow", "pause", "blank", "freeze")))
    def teacher_does(self, what: TeacherAction) -> None:
        """A station of the projector may reveal, like the action *reveal*."""
        poll = self.poll()
        self.teach(what)
        if what == "on" and poll is not None and poll.question in self.lecture.classroom.ballots.revealed:
            assert self.model.counted(poll.question)[-1] or poll.revealed, "a reveal needs an answer"
            self.model.ask(poll.question).revealed = True
        self.model.pages_only ^= what == "pages"
        self.model.free = what == "free" or (self.model.free and what != "follow")

    @precondition(lambda self: self.lecture.lessons.open)
    @rule(text=st.sampled_from(("", "1", "1-2", "nonsense", "9")))
    def teacher_opens_steps(self, text: str) -> None:
        before, lessons = self.lecture.classroom.pace, len(self.lecture.lessons.walk.lesson.steps)
        self.teach("pace", text)
        pace = self.lecture.classroom.pace
        if text in ("nonsense", "9"):
            assert pace == before and self.lecture.control.refused
        else:
            assert (pace is None) == (text == "") and not self.lecture.control.refused
            assert pace is None or (pace.first, pace.last) == (0, min(int(text[-1]), lessons) - 1)

    @rule(seconds=st.sampled_from((1.0, 61.0)))
    def places_are_given(self, seconds: float) -> None:
        self.now += seconds
        classroom = self.lecture.classroom
        before = {
            student: classroom.places.groups[student]
            for student in classroom.here
            if classroom.places.holds(student)
        }
        classroom.settle(classroom.here, self.now)
        places = classroom.places
        assert len(places.sizes) <= MOST_PLACES
        for student in classroom.here:
            assert places.holds(student) == self.model.free
            assert places.groups.get(student) == before.get(student, places.groups.get(student)), (
                "a student keeps the place"
            )
            if self.model.free:
                group = places.groups[student]
                name = classroom.board.name_of(group)
                assert self.names.setdefault(group, name) == name, "a group keeps its name"

    # ---- endings -----------------------------------------------------------------------------------------------------------

    @rule()
    def server_breaks_off_and_starts(self) -> None:
        room = self.lecture.save()
        # Breakout sessions have separate records; the class keeps only their handed-in work.
        self.worked = {student: report.progress for student, report in room.hand_ins.items()}
        before = self.store.named_records[NAME]
        self.lecture.close()
        self.resumed()
        again = self.lecture.save()
        assert replace(again, saved=room.saved) == room, "the class is loaded unchanged"
        assert list(again.ballots) == list(room.ballots), "the order of questions is the same"
        after = self.store.named_records[NAME]
        assert opened_lesson(after) == opened_lesson(before) and after.settings == before.settings

    @rule(late=st.booleans())
    def class_ends(self, late: bool) -> None:
        """The next class starts empty and has this report, also after a crash with a late restart."""
        expected = self.summary()
        before = self.lecture.last_class
        if late:
            room = self.lecture.save()
            record, ago = self.store.named_records[NAME], time() - AWAY - 1.0
            self.store.save_named(NAME, with_class(record, replace(room, saved=ago), last_class_of(record)))
        else:
            self.lecture.end()
            assert class_of(self.store.named_records[NAME]) is None
        self.lecture.close()
        self.begin_class()
        self.resumed()
        last = self.lecture.last_class
        if expected.empty:
            assert last == before
        else:
            assert last is not None and replace(last, saved=0.0) == expected
        fresh = self.lecture.classroom.summary(BOOK, 0.0)
        assert fresh.empty and not self.lecture.lessons.open
        self.teacher_opens_a_lesson()

    # ---- what holds at any time --------------------------------------------------------------------------------------------

    def summary(self) -> ClassSummary:
        """Report of the class, with time 0."""
        made = self.lecture.classroom.summary(BOOK, 0.0)
        rounds = {
            question: [one for one in self.model.counted(question) if one] for question in self.model.asked
        }
        asked: list[AskedQuestion] = []
        for question in (question for question, asked in self.model.asked.items() if any(asked.rounds)):
            choices = len(self.choices(question))
            given = rounds[question]
            switches = switches_between(given[0], given[-1]) if len(given) > 1 else ()
            asked.append(AskedQuestion(question, tuple(tally_of(one, choices) for one in given), switches))
        assert made.asked == tuple(asked)
        assert made.students == len(
            {student for given in rounds.values() for one in given for student in one}
        )
        assert made.passed == {question: len(students) for question, students in self.passed.items()}
        assert sorted(one.name for one in made.hand_ins) == sorted(self.model.given.values())
        return made

    @staticmethod
    def choices(question: QuestionId) -> tuple[object, ...]:
        lesson, step = question
        found = BOOK.lessons[BOOK.index(lesson)]
        asked = next(one for one in found.steps if one.id == step).question
        assert asked is not None and not lesson.endswith(LAST)
        return asked.choices

    @invariant()
    def everybody_counts_once_with_the_newest_answer(self) -> None:
        poll, walk = self.poll(), self.lecture.lessons.walk
        if poll is None:
            return
        asked = self.model.asked.get(poll.question)
        rounds = self.model.counted(poll.question) if asked is not None else [{}]
        absent = self.model.pageless if self.model.pages_only else set[str]()
        answered = set() if asked is None else asked.rounds[-1].keys()
        waiting = len(set(self.model.here.values()) - answered - absent)
        assert poll.tally == tally_of(rounds[-1], len(poll.choices))._replace(waiting=waiting)
        assert poll.round == len(rounds)
        several = len(rounds) > 1
        assert poll.first == (tally_of(rounds[0], len(poll.choices)) if several else None)
        assert poll.switches == (switches_between(rounds[0], rounds[-1]) if several else ())
        revealed = asked is not None and asked.revealed
        assert poll.revealed == revealed and poll.open == (walk.done.outcome is None and not revealed)
        told = walk.done.outcome is not None and walk.phase not in (Phase.PREDICT, Phase.DO)
        assert (poll.right is not None) == bool(poll.verdicts) == told, (
            "the right answer is shown with the outcome"
        )

    @invariant()
    def all_rounds_are_kept(self) -> None:
        rounds = {
            question: given for question, given in self.lecture.classroom.ballots.rounds.items() if any(given)
        }
        expected = {
            question: tuple(asked.rounds) for question, asked in self.model.asked.items() if any(asked.rounds)
        }
        assert rounds == expected
        for question, given in rounds.items():
            assert [list(one) for one in given] == [list(one) for one in expected[question]], (
                "answers are in order of arrival"
            )

    @invariant()
    def work_is_kept_and_a_report_names_only_who_handed_in(self) -> None:
        work = self.lecture.classroom.work
        assert {student: report.name for student, report in work.hand_ins.items()} == self.model.given
        assert work.passed == self.passed and work.nearest == self.nearest
        report = self.summary()
        assert not any(tab in str(report) for tab in (*self.worked, *self.ballots_of))

    @invariant()
    def the_class_is_as_the_teacher_says(self) -> None:
        classroom = self.lecture.classroom
        assert classroom.free == self.model.free and classroom.ballots.pages_only == self.model.pages_only
        assert classroom.here == tuple(dict.fromkeys(self.model.here.values()))
        assert classroom.ballots.pageless == self.model.pageless
        assert self.lecture.leader.tabs[0] == (self.leads or None)

    def teardown(self) -> None:
        self.lecture.close()


TestClassMachine = ClassMachine.TestCase
ClassMachine.TestCase.settings = settings(max_examples=30, stateful_step_count=25)
