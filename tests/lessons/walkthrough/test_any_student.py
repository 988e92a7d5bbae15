"""Whatever a student does, nothing gets stuck."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.lessons.lesson import LessonBook
from app.lessons.phases import Phase
from app.lessons.walkthrough import Walkthrough
from scenes.settings import changed
from scenes.simulation import Simulation
from tests.lessons.walkthrough.conftest import two_lessons

SIMPLE = ("next", "back", "reset", "show_why", "hint", "run_again", "observe", "attempt", "run", "reload", "write")
ACTIONS = st.lists(
    st.one_of(
        st.sampled_from(SIMPLE),
        st.tuples(st.just("choose"), st.integers(-1, 3)),
        st.tuples(st.just("go"), st.integers(-1, 2), st.integers(-1, 2)),
        st.tuples(st.just("set"), st.sampled_from([("n", 6.0), ("point", "elbow"), ("scene", "solo"), ("law", "unprotected")])),
    ),
    max_size=25,
)


class Student:
    def __init__(self, book: LessonBook) -> None:
        self.walk = Walkthrough(book)
        self._turn = -1
        self._follow()

    def _follow(self) -> None:
        if self._turn != self.walk.run_id:
            self._turn = self.walk.run_id
            self.simulation = Simulation(self.walk.settings().run, 200)
            self.simulation.reset(self.walk.start(self.simulation))
            self._person = self.walk.target_source(self.simulation)

    def do(self, action: str | tuple[object, ...]) -> None:
        walk, simulation = self.walk, self.simulation
        match action:
            case "next":
                assert walk.view().can_next == walk.next()
            case "back":
                assert walk.view().can_back == walk.back()
            case "reset" | "show_why" | "hint" | "run_again":
                getattr(walk, action)()
            case "observe":
                walk.observe(simulation)
            case "attempt":
                walk.attempt(simulation, [0.5, None])
            case "write":
                walk.write("words " * 1000)
            case "run":
                for _ in range(120):
                    walk.watch(simulation)
                    simulation.step(self._person.target(simulation.time))
            case "reload":
                before = walk.view()
                self.walk = Walkthrough.from_json(walk.book, walk.to_json())
                if not before.showing:
                    assert self.walk.view() == before
                self._turn = -1
            case ("choose", int(answer)):
                walk.choose(answer)
            case ("go", int(lesson), int(step)):
                if 0 <= lesson < len(walk.book.lessons) and 0 <= step < len(walk.book.lessons[lesson].steps):
                    walk.go(lesson, step)
            case ("set", (str(key), value)):
                simulation.apply(changed(simulation.settings, key, value))
        self._follow()


@given(actions=ACTIONS)
@settings(max_examples=120)
def test_nothing_a_student_does_raises_or_gets_stuck(tmp_path_factory: pytest.TempPathFactory, actions: list[str]) -> None:
    book = two_lessons(tmp_path_factory.getbasetemp())
    student = Student(book)
    for action in actions:
        student.do(action)
        view = student.walk.view()
        assert view.locked == (view.phase is Phase.PREDICT)
        assert view.phase in view.phases
    walk = student.walk
    lesson, step = walk.lesson.id, walk.view().index
    walk.reset()
    fresh = Walkthrough(book)
    fresh.go(lesson, step)
    assert {**vars(walk.view()), "can_back": 0} == {**vars(fresh.view()), "can_back": 0}
    for _ in range(40):
        if walk.locked:
            assert walk.choose(0)
        elif not walk.next():
            break
    assert walk.lesson is book.lessons[-1] and walk.step is book.lessons[-1].steps[-1] and walk.phase is walk.phases[-1]
    for _ in range(40):
        if not walk.back():
            break
    assert walk.lesson is book.lessons[0] and walk.step is book.lessons[0].steps[0]
