"""A small book with every kind of step, and its student, for the state machine of the lessons."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from app.features.lessons.lesson import LAST, Lesson, LessonBook, Step
from app.features.lessons.loading import load_lessons
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.step_view import StepView
from app.hosting.visitor import record_of, run_again
from app.session.frame import make_frame
from app.session.session import Session
from app.settings import Settings
from tests.app.features.lessons.helpers import SMALL, lessons_in
from tests.app.features.store.test_session_store import again, tab

Place = tuple[str, str]
"""Lesson id and step id."""

SETTINGS = """
```duet
settings = { scene = "ball", point = "hand", pairs = "single", dt = 0.02, n = 2.0 }
```
"""

NUMBERS = f"""# Numbers

Say them beforehand.
{SETTINGS}
## Forecasts

```duet
id = "forecasts"
input = "none"
seconds = 1.0

[[measure]]
name = "smallest_distance"

[challenge]

[[challenge.forecast]]
id = "four"
name = "smallest_distance"
settings = {{ n = 4.0 }}
within = 0.05

[[challenge.forecast]]
id = "six"
name = "smallest_distance"
settings = {{ n = 6.0 }}
within = 0.05

[[attempt]]
name = "too small"
forecasts = [0.001, 0.001]
fails = ["four", "six"]
```

### Goal

To say it.

### Do

Run.

### Observe

It was {{measured:smallest_distance}}.

### Challenge

Say both.

### Hints

1. One.
2. Two.
3. Three.
"""

TEST = f"""# A test

What do you think?
{SETTINGS}
## Nearer

```duet
id = "nearer"
concept = true
input = "none"
seconds = 1.0
right = 2

[[measure]]
id = "d"
name = "smallest_distance"
```

### Predict

Which one?

1. This.
   > No: {{measured:d}}.
2. That.
   > Yes: {{measured:d}}.
"""


@cache
def small_book() -> LessonBook:
    """A test, two lessons, and the test again."""
    with TemporaryDirectory() as folder:
        for name, text in (("01-small", SMALL), ("02-numbers", NUMBERS), ("03-test", TEST)):
            (Path(folder) / f"{name}.md").write_text(text, encoding="utf-8")
        book = load_lessons(Path(folder))
    assert not book.problems, book.problems
    small, numbers, test = book.lessons
    first, last = (
        replace(test, id=test.id + end, steps=tuple(replace(step, asked=asked) for step in test.steps))
        for asked, end in (("first", ""), ("last", LAST))
    )
    return LessonBook((first, small, numbers, last), ())


PLACES: tuple[Place, ...] = tuple(
    (lesson.id, step.id) for lesson in small_book().lessons for step in lesson.steps
)


def step_at(place: Place) -> tuple[Lesson, Step]:
    lesson = next(one for one in small_book().lessons if one.id == place[0])
    return lesson, next(one for one in lesson.steps if one.id == place[1])


class Student:
    """A session with lessons, without a page."""

    def __init__(self, settings: Settings | None = None) -> None:
        self.session = Session(settings or Settings())
        self.lessons: LessonSession = lessons_in(self.session, small_book())
        self._time = 0.0

    @property
    def place(self) -> Place:
        walk = self.lessons.walk
        return walk.lesson.id, walk.step.id

    @property
    def view(self) -> StepView:
        return self.lessons.walk.view()

    def frames(self, until: Callable[[], object], most: int = 400) -> None:
        """Make frames until a condition holds, at most `most`."""
        for _ in range(most):
            if until():
                return
            # Further runs are simulated in a separate thread.
            self.lessons.runner.further.result()
            self._time += 0.05
            make_frame(self.session, self._time, 0.05, 60.0)

    def reload(self) -> "Student":
        """The student restored from the bytes of the store."""
        query = {"resume": tab(1)}
        record = again(record_of(query, self.session))
        other = Student(record.settings)
        other.session.parts.restore(record.parts, record.recordings)
        if other.lessons.left is not None:
            other.lessons.resume(other.lessons.left, reopen=True)
        for _ in run_again(other.session, record):
            pass
        self.session.close()
        return other
