"""A lecture in several processes: three students in breakout sessions; a fourth joins ann's session."""

import re
from contextlib import suppress
from pathlib import Path

from app.web.headless_client import HeadlessClient
from app.web.server import MOVED_CODE
from tests.app.features.lecture.lecture_room import choose, command, sees, tab_of
from tests.app.features.store.kept import kept
from tests.app.features.workers.served import Served
from tests.app.features.workers.test_workers import worker_of
from tests.app.page.helpers import bodies, click, open_lessons, shown
from tests.app.served import has_arms
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

KEY = "chalk-and-talk"
OPTIONS = ("--lecture", "--workers", "2", "--key", KEY, "--sessions", "3", "--students", "4")
NAMES = ("ann", "bo", "cy")
D_M = "critical distance d_m [mm]"


class ServedClass:
    """A class whose students explore in lesson 1; ann has answered its first question.

    Attributes:
        places: the command's output about places.
        shared: process of the shared session.
        followed_in: processes of the students before they explored.
    """

    def __init__(self, served: Served) -> None:
        self.served, self._opened = served, list[BlockingClient]()
        assert served.process.stdout is not None
        self.places = [served.process.stdout.readline() for _ in range(2)][1]
        self.teacher = self.come_as_teacher()
        open_lessons(self.teacher)
        sees(self.teacher, "Lesson 1 · step 1", "groups of 2")
        self.students: dict[str, BlockingClient] = {}
        self.come(*NAMES)
        click(self.students["ann"], "2 ")
        sees(self.teacher, "1 answered", "students here: 3")
        self.shared = worker_of(served, self.teacher)
        self.followed_in = {worker_of(served, one) for one in self.students.values()}
        self.send("Explore freely", *NAMES)
        for name in NAMES:
            self.has_controls(name)
        self.screen = self._tab("screen=1")

    def _tab(self, query: str) -> BlockingClient:
        self._opened.append(self.served.come(query, has_arms))
        return self._opened[-1]

    def come_as_teacher(self) -> BlockingClient:
        return self._tab(f"key={KEY}")

    def come(self, *names: str) -> list[BlockingClient]:
        """Open a page for each student, in this order."""
        self.students |= {name: self._tab(f"resume={tab_of(name)}") for name in names}
        return [self.students[name] for name in names]

    def come_late(self, name: str) -> BlockingClient:
        """Page of a late student, who follows the shared session until a group has a place."""
        (one,) = self.come(name)
        one.wait_for(lambda v: v.closed or "at this robot" in shown(v))
        return one if one.closed is None else self.come(name)[0]

    def send(self, where: str, *names: str) -> None:
        """Choose, as the teacher, where the students work; their pages reconnect."""
        choose(self.teacher, where)
        assert {ended(self.students[name])[0] for name in names} == {MOVED_CODE}
        self.come(*names)

    def has_controls(self, name: str) -> None:
        self.students[name].wait_for(lambda v: bodies(v, "GuiSliderMessage"), 60.0)

    def process_of(self, name: str) -> int:
        return worker_of(self.served, self.students[name])

    def are_together(self, operator: str, watcher: str) -> None:
        """Check that both pages show their group's session, in one process."""
        sees(self.students[operator], "You are 2 at this robot", "You operate it.")
        sees(self.students[watcher], "You are 2 at this robot", "has control")
        assert self.process_of(operator) == self.process_of(watcher)

    def critical_distance(self, name: str) -> float:
        """Critical distance in a student's stored record [m]; 0 without a record."""
        return critical_distance(self.served.store, name)

    def begin(self) -> None:
        """Return to lesson 1 with all steps open and the scene on the projector."""
        if "Lesson 1" not in shown(self.teacher):
            click(self.teacher, "All lessons")
            click(self.teacher, "1  ")
        sees(self.teacher, "Lesson 1")
        self.teacher.set_value("only steps", "")
        sees(self.teacher, "Every step is open.")

    def close(self) -> None:
        for one in self._opened:
            one.close()


def critical_distance(store: Path, name: str) -> float:
    record = kept(store, tab_of(name))
    return 0.0 if record is None else record.settings.run.law.critical_distance


def show_work(teacher: BlockingClient, screen: BlockingClient, name: str, *work: str) -> None:
    """Show a student's work on the projector; retries, because work reaches the teacher with a delay."""
    teacher.wait_for(lambda v: name in v.mirror.labelled("student")["options"], 60.0)
    teacher.set_value("student", name)

    def shows(visitor: HeadlessClient) -> bool:
        return all(text in shown(visitor) for text in work)

    for _ in range(20):
        click(teacher, "Show this one")
        with suppress(TimeoutError):
            screen.wait_for(shows, 3.0)
            return
    sees(screen, *work)


def push(student: BlockingClient, times: int) -> float:
    """Push once in the duel of lesson 6. Smallest distance above d_m [mm]."""
    sees(student, "Lesson 6 · step 3")
    click(student, "Next: observe")
    click(student, "Next: challenge")
    sees(student, "You have five pushes")
    for _ in range(4 * times):
        command(student, "Hand or ball 2 cm to the left")
    click(student, "Count this push")
    sees(student, "Push 1 of 5")
    found = re.search(r"You came to ([\d.]+)\smm above dₘ", shown(student))
    assert found is not None
    return float(found[1])
