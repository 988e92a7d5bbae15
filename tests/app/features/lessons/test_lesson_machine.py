"""After any actions and reloads in lessons, nothing is skipped, lost, shown too early or stuck."""

from collections.abc import Collection
from dataclasses import replace

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from app.features.lessons.bookmark import Phase, phases_of
from app.features.lessons.lesson import AT_ONCE, LAST, Step
from app.features.lessons.progress import LONGEST_REASON, MOST_WORDS, StepProgress, from_json
from app.features.lessons.session import lesson_actions as actions
from app.features.lessons.walkthrough import Walkthrough
from tests.app.features.lessons.lesson_model import PLACES, Place, Student, small_book, step_at

ANY_PLACE = st.sampled_from(PLACES)
FORECASTS: Place = ("numbers", "forecasts")
CHALLENGES: tuple[Place, ...] = (("small", "first"), FORECASTS)
FRESH = StepProgress()


def text_of(step: Step, phase: Phase) -> str:
    question = "" if step.question is None else step.question.text
    challenge = "" if step.challenge is None else step.challenge.text
    return dict(zip(Phase, (question, step.do, step.observe, step.explain, challenge), strict=True))[phase]


class LessonMachine(RuleBasedStateMachine):
    """The model: expected words and numbers, and the progress before each action."""

    def __init__(self) -> None:
        super().__init__()
        self.student = Student()
        self.lessons.enter(1)
        self.words: dict[Place, str] = {}
        self.reasons: dict[Place, str] = {}
        self.said: dict[Place, dict[int, float]] = {}
        self.before = self.progress()

    @property
    def lessons(self):
        return self.student.lessons

    @property
    def walk(self) -> Walkthrough:
        return self.lessons.walk

    @property
    def here(self) -> tuple[Place, Phase]:
        return self.student.place, self.walk.phase

    def progress(self) -> dict[Place, StepProgress]:
        steps = from_json(self.walk.to_json()).steps
        return {place: steps.get(place, FRESH) for place in PLACES}

    def done(self, place: Place) -> StepProgress:
        return self.before[place]

    # ---- what an action may change -----------------------------------------------------------------------------------------

    def act(self, action: actions.LessonAction) -> None:
        self.lessons.act(action)
        self.student.frames(lambda: not self.lessons.computing)

    def compare(self, touched: Collection[Place], restarted: bool = False) -> None:
        """Compare the progress with what it was before an action."""
        before, self.before = self.before, self.progress()
        for place in PLACES:
            old, new = before[place], self.before[place]
            if place not in touched:
                assert new == old, f"the action does not concern {place}"
            elif not restarted:
                assert new.hints >= old.hints and new.attempts >= old.attempts
                assert new.passed >= old.passed, "a passed challenge stays passed"
                if old.outcome is not None:
                    assert new.choice == old.choice, "an answer is fixed after the outcome"
                    asked = step_at(place)[1].question is not None
                    assert new.outcome is not None
                    assert not asked or new.outcome.values == old.outcome.values

    @property
    def told(self) -> bool:
        """True if the test at the end has shown this step's right answer."""
        lesson, step = self.student.place
        asked = self.walk.step.asked
        later = lesson if asked == "last" else lesson + LAST
        return bool(asked) and self.done((later, step)).outcome is not None

    @property
    def answerable(self) -> bool:
        place, phase = self.here
        early = phase in (Phase.PREDICT, Phase.DO)
        return self.lessons.open and early and self.done(place).outcome is None and not self.told

    @initialize(place=ANY_PLACE, sees=st.booleans())
    def begins(self, place: Place, sees: bool) -> None:
        self.goes_to(place)
        if sees:
            self.answers_and_sees(1)

    # ---- answers -----------------------------------------------------------------------------------------------------------

    @rule(answer=st.integers(-1, 2))
    def chooses(self, answer: int) -> None:
        (place, phase), choice = self.here, self.done(self.student.place).choice
        question = self.walk.step.question
        taken = question is not None and self.answerable and 0 <= answer < len(question.choices)
        self.act(actions.Choose(answer))
        self.compare({place})
        assert self.done(place).choice == (answer if taken else choice)
        goes_on = taken and phase is Phase.PREDICT and not self.walk.step.concept
        assert self.here == (place, Phase.DO if goes_on else phase)

    @rule(distance=st.sampled_from((0.02, 0.2, 5.0)))
    def guesses(self, distance: float) -> None:
        place, done = self.student.place, self.done(self.student.place)
        taken = self.answerable and place == ("small", "first") and distance < 1.0
        self.act(actions.Guess(*place, distance))
        self.compare({place})
        assert self.done(place).guess == (distance if taken else done.guess)
        assert self.done(place).choice == (int(distance > 0.05) if taken else done.choice)

    @rule(answer=st.integers(0, 1), afterwards=st.none() | st.integers(0, 1))
    def answers_and_sees(self, answer: int, afterwards: int | None = None) -> None:
        """The usual way; some students then try to change the answer."""
        self.chooses(answer)
        self.goes_on()
        if afterwards is not None:
            self.goes_back()
            self.chooses(afterwards)

    @rule(index=st.integers(0, 1), number=st.none() | st.sampled_from((0.0, 222.0, 227.8)))
    def says_a_number(self, index: int, number: float | None) -> None:
        """None clears the number; a number may arrive late from an earlier step."""
        self.act(actions.SayNumber(*FORECASTS, index, number))
        said = self.said.setdefault(FORECASTS, {})
        said.pop(index, None)
        if number is not None:
            said[index] = number
        self.compare(())

    @rule(place=ANY_PLACE, text=st.sampled_from(("", "mine", "long " * 1000)), reason=st.booleans())
    def writes(self, place: Place, text: str, reason: bool) -> None:
        """Words about a step, or the reason for an answer; they may arrive late from another step."""
        if reason:
            self.act(actions.GiveReason(*place, text))
            self.reasons[place] = text[:LONGEST_REASON].strip()
        else:
            self.act(actions.Write(*place, text))
            self.words[place] = text[:MOST_WORDS]
        self.compare({place})

    # ---- ways --------------------------------------------------------------------------------------------------------------

    def after(self, place: Place) -> Place | None:
        number = PLACES.index(place) + 1
        return PLACES[number] if number < len(PLACES) else None

    @rule()
    def goes_on(self) -> None:
        (place, phase), showing, lessons = self.here, self.walk.showing, self.lessons
        phases, following = self.walk.phases, self.after(place)
        waits = self.walk.locked and not self.walk.done.predicted and self.walk.step.asked != "first"
        can = self.student.view.can_next
        self.act(actions.Press("next"))
        # A measured run first continues to its end.
        self.student.frames(lambda: lessons.over or self.here != (place, Phase.DO))
        self.student.frames(lambda: False, 1)
        self.compare({place})
        if not lessons.open:
            assert self.here == (place, phase)
        elif showing or waits:
            assert self.here == (place, phase) and not self.walk.showing and can == showing
        elif phase is not phases[-1]:
            assert self.here == (place, phases[phases.index(phase) + 1]) and can, "phases follow in order"
        elif following is None:
            assert self.here == (place, phase) and not can, "the last step has no next one"
        else:
            assert can and self.student.place == following, "steps follow in order"
            self.began(following)

    def began(self, place: Place) -> None:
        """A step begins with its question, or with its run if the question is answered."""
        done, step = self.done(place), step_at(place)[1]
        answered = done.choice is not None and not step.concept
        first = next(phase for phase in phases_of(step) if phase is not Phase.PREDICT or not answered)
        assert self.walk.phase is first

    @rule()
    def goes_back(self) -> None:
        (place, phase), showing = self.here, self.walk.showing
        phases, number = self.walk.phases, PLACES.index(place)
        can = self.student.view.can_back
        self.act(actions.Press("back"))
        self.compare(())
        known = self.done(place).outcome is not None
        before = phases[max(phases.index(phase) - 1, 0)]
        if not self.lessons.open or showing:
            assert self.here == (place, phase) and not (showing and self.lessons.open and self.walk.showing)
        elif before is not phase and not (known and before is Phase.PREDICT):
            assert self.here == (place, before) and can
        elif number == 0:
            assert self.here == (place, phase) and not can
        else:
            assert self.student.place == PLACES[number - 1] and can
            self.is_at_the_furthest(PLACES[number - 1])

    def is_at_the_furthest(self, place: Place) -> None:
        if self.done(place).outcome is not None:
            assert self.walk.phase is phases_of(step_at(place)[1])[-1]

    @rule(place=ANY_PLACE)
    def goes_to(self, place: Place) -> None:
        book = small_book()
        lesson = next(i for i, one in enumerate(book.lessons) if one.id == place[0])
        step = [one.id for one in book.lessons[lesson].steps].index(place[1])
        opens = self.lessons.open or self.lessons.listing
        before = self.here
        self.act(actions.GoTo(lesson, step))
        self.compare(())
        if opens:
            assert self.student.place == place and self.lessons.open
            self.is_at_the_furthest(place)
        else:
            assert self.here == before

    @rule(what=st.sampled_from(("list", "leave")))
    def closes(self, what: str) -> None:
        before = self.here
        self.act(actions.Press(what))  # pyright: ignore[reportArgumentType]
        self.compare(())
        assert self.here == before, "the place is kept"

    @precondition(lambda self: not self.lessons.open)
    @rule()
    def opens_again(self) -> None:
        before = self.here
        self.lessons.enter()
        self.compare(())
        assert self.here == before and self.lessons.open

    @rule()
    def restarts_the_step(self) -> None:
        place, told = self.student.place, self.told
        self.act(actions.Press("reset"))
        if not self.lessons.open:
            self.compare(())
            return
        self.said.pop(place, None)
        if told:
            self.compare({place})
            return
        self.compare({place}, restarted=True)
        self.reasons.pop(place, None)
        assert replace(self.done(place), words="") == FRESH, "a restart clears all but the student's words"
        fresh = Walkthrough(small_book())
        fresh.go(place[0], self.walk.step_index)
        assert replace(self.student.view, done=FRESH, can_back=False) == replace(
            fresh.view(), done=FRESH, can_back=False
        )

    # ---- runs --------------------------------------------------------------------------------------------------------------

    @rule(frames=st.sampled_from((3, 80)))
    def runs(self, frames: int) -> None:
        """A question's run is measured at its end, and then the outcome is shown."""
        (place, phase), session = self.here, self.student.session
        if not self.lessons.open:
            return
        locked = self.walk.locked and not self.walk.done.predicted
        self.act(actions.Press("run"))
        self.student.frames(lambda: session.paused and self.walk.phase is not Phase.PREDICT, frames)
        self.compare({place})
        if locked and not self.walk.step.concept:
            assert session.simulation.steps == 0 and session.paused, "there is no run before the prediction"
        if phase is Phase.DO and self.done(place).outcome is None:
            assert not self.lessons.over or self.walk.yours or not self.walk.step.measurements

    @rule(what=st.sampled_from(("again", "why", "hint", "check")))
    def presses(self, what: str) -> None:
        place, phase = self.here
        hints = self.done(place).hints + (what == "hint" and self.lessons.open)
        self.act(actions.Press(what))  # pyright: ignore[reportArgumentType]
        self.compare({place})
        assert self.here == (place, phase)
        assert self.student.view.hints == self.walk.step.hints[:hints], "hints follow in order"
        last = self.done(place).last
        if what != "check" or not self.lessons.open or phase is not Phase.CHALLENGE or last is None:
            return
        said = self.said.get(place, {})
        for number, judgement in enumerate(last.judgements if place == FORECASTS else ()):
            assert judgement.value is not None
            truth = self.walk.step.measurements[0].text(judgement.value)
            assert (truth in judgement.text) == (number in said), "the truth is shown only after a guess"
            assert judgement.passed <= (number in said)

    @precondition(lambda self: any(self.done(place).outcome is not None for place in CHALLENGES))
    @rule(tries=st.lists(st.booleans(), min_size=1, max_size=3), last=st.booleans())
    def tries_a_challenge(self, tries: list[bool], last: bool) -> None:
        """Try a challenge at the end of a step; the setting of the run, or the entered numbers, decide."""
        ready = [place for place in CHALLENGES if self.done(place).outcome is not None]
        place = ready[-last]
        if not self.lessons.open:
            self.opens_again()
        self.goes_to(place)
        for passes in tries:
            if place == FORECASTS:
                for index in range(2):
                    self.says_a_number(index, 227.8 if passes else None)
            else:
                self.changes_a_setting(("n", 6.0 if passes else 2.0))
            attempts, before = self.done(place).attempts, self.done(place).passed
            self.presses("again")
            self.runs(80)
            self.presses("check")
            done = self.done(place)
            assert done.passed == (passes or before) and done.last is not None
            assert done.last.passed == passes and done.attempts - attempts == 1, "a run counts as one attempt"

    @rule(
        setting=st.sampled_from(
            (("n", 6.0), ("n", 2.0), ("point", "elbow"), ("law", "unprotected"), ("scene", "solo"))
        )
    )
    def changes_a_setting(self, setting: tuple[str, object]) -> None:
        self.student.session.change(*setting)
        self.student.frames(lambda: False, 1)
        self.compare(())

    # ---- reloads -----------------------------------------------------------------------------------------------------------

    @rule()
    def page_is_loaded_again(self) -> None:
        view, text, seen = self.student.view, from_json(self.walk.to_json()), self.lessons.seen.keys()
        open_before, simulation = self.lessons.open, self.student.session.simulation
        self.student = self.student.reload()
        assert self.lessons.open == open_before and from_json(self.walk.to_json()) == text
        assert self.lessons.seen.keys() == seen
        self.compare(())
        if not view.showing:
            assert replace(self.student.view, stale=False) == replace(view, stale=False)
            after = self.student.session.simulation
            assert after.steps == simulation.steps
            assert after.positions.tobytes() == simulation.positions.tobytes()

    @rule()
    def anybody_gets_to_the_end(self) -> None:
        """From any place, answers and *next* lead to the end, and *back* to the beginning."""
        walk = Walkthrough(small_book(), self.walk.to_json())
        for _ in range(40):
            if walk.locked and not walk.done.predicted:
                assert walk.choose(0) or walk.step.asked == "first"
            if not walk.next():
                break
        assert (walk.lesson.id, walk.step.id) == PLACES[-1] and walk.phase is walk.phases[-1]
        while walk.back():
            pass
        assert (walk.lesson.id, walk.step.id) == PLACES[0]

    # ---- what holds at any time --------------------------------------------------------------------------------------------

    @invariant()
    def nothing_is_told_before_the_answer(self) -> None:
        view, step, done = self.student.view, self.walk.step, self.walk.done
        reached = view.phases[: view.phases.index(view.phase) + 1]
        assert [name for name, _ in view.texts] == ["goal", *(one for one in reached if text_of(step, one))]
        assert view.phase in view.phases
        assert view.locked == (view.phase is Phase.PREDICT and not done.predicted)
        if view.phase in (Phase.PREDICT, Phase.DO):
            assert view.verdict is None and not view.outcome and not view.why_outcome and not view.why
        elif step.measurements:
            assert done.outcome is not None, "this phase needs the outcome"
            assert step.question is None or done.predicted, "this phase needs an answer"
        if view.phase is Phase.PREDICT:
            assert not set(self.walk.plots) & set(AT_ONCE)
            assert not self.lessons.open or self.student.session.simulation.steps == 0

    @invariant()
    def own_entries_are_kept(self) -> None:
        for place in PLACES:
            done = self.done(place)
            assert done.words == self.words.get(place, "") and done.because == self.reasons.get(place, "")
        lesson = self.lessons.saved_lesson()
        assert lesson is not None
        said = {
            place: {i: x for i, x in enumerate(them) if x is not None} for place, them in lesson.said.items()
        }
        assert {place: them for place, them in said.items() if them} == {
            place: them for place, them in self.said.items() if them
        }

    @invariant()
    def the_list_says_what_is_finished(self) -> None:
        for entry in self.walk.entries():
            places = [(entry.lesson.id, step.id) for step in entry.lesson.steps]
            finished = tuple(map(self.is_finished, places))
            assert entry.finished == finished
            if not entry.here:
                assert entry.step == (finished.index(False) if False in finished else 0)
            else:
                assert self.student.place == places[entry.step]

    def is_finished(self, place: Place) -> bool:
        done, step = self.done(place), step_at(place)[1]
        if step.challenge is not None:
            return done.passed
        return done.choice is not None if step.asked == "first" else done.outcome is not None

    @invariant()
    def it_can_be_saved_at_any_time(self) -> None:
        text = self.walk.to_json()
        again = Walkthrough(small_book(), text)
        assert from_json(again.to_json()) == from_json(text)
        if not self.walk.showing:
            assert replace(again.view(), stale=False) == replace(self.student.view, stale=False)

    def teardown(self) -> None:
        self.student.session.close()


TestLessonMachine = LessonMachine.TestCase
LessonMachine.TestCase.settings = settings(max_examples=40, stateful_step_count=25)
