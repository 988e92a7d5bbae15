"""A lecture in several processes: the students explore in others than the stage's, and the teacher reaches all of them."""

import pickle
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from math import inf
from pathlib import Path
from time import monotonic

import pytest

from app.classroom.breakout_sessions import BreakoutWorkers
from app.classroom.class_messages import ClassState, Exploring, Present
from app.classroom.classroom import Classroom
from app.export.class_summary import HandIn
from app.hosting import visitor as visitor_module
from app.hosting.private_host import PrivateHost
from app.hosting.visitor_record import VisitorRecord
from app.hosting.worker_messages import ForTab, Replaced, WorkerLink
from app.page.panels.server_load import ServerLoad
from app.settings import Settings
from app.web.server import MOVED_CODE
from tests.app.classroom.lecture_room import choose, command, drawn_name, sees, sessions_of, tab_of
from tests.app.conftest import Made
from tests.app.hosting.test_workers import worker_of
from tests.app.page.helpers import bodies, buttons, click, open_lessons, shown
from tests.app.runtime.processes import until
from tests.app.served import Serve, Served, has_arms, kept
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

NAMES = ("ann", "bo", "cy")

Come = Callable[..., BlockingClient]


@pytest.fixture
def served(serve: Serve, request: pytest.FixtureRequest) -> Served:
    sessions = str(getattr(request, "param", 8))
    return serve("--lecture", "--workers", "2", "--key", "chalk-and-talk", "--sessions", sessions, "--students", "3")


@pytest.fixture
def come(served: Served) -> Iterator[Come]:
    """`come("ann")` is a student, `come(key=True)` a teacher, `come(screen=True)` a projector; the page is whole."""
    with ExitStack() as opened:

        def make(name: str = "", key: bool = False, screen: bool = False) -> BlockingClient:
            query = "key=chalk-and-talk" if key else "screen=1" if screen else f"resume={tab_of(name)}"
            return opened.enter_context(served.come(query, has_arms))

        yield make


def critical_distance(store: Path) -> float:
    """The one of ann's record in the store [m]."""
    record = kept(store, tab_of("ann"))
    return 0.0 if record is None else record.settings.run.law.critical_distance


def has_controls(visitor: BlockingClient) -> None:
    visitor.wait_for(lambda v: bodies(v, "GuiSliderMessage"), 60.0)


def look_after_those_who_explore(teacher: BlockingClient, students: list[BlockingClient], screen: BlockingClient) -> None:
    """The board knows all under drawn names, one of them is shown without one, and only the open step can be entered."""
    names = [drawn_name(student) for student in students]
    sees(teacher, "Every step is open.", *names)
    teacher.set_value("only steps", "2")
    for student in students:
        sees(student, "Lesson 1 · step 2", "Lesson 1: step 2 only.")
    choose(students[1], "1")
    click(students[1], "2 ")
    sees(students[1], "Your prediction", "Lesson 1 · step 2")
    click(students[1], "Run")
    teacher.wait_for(lambda v: names[1] in v.mirror.labelled("student")["options"], 60.0)
    teacher.set_value("student", names[1])
    work = ("One of you", "Lesson 1 · step 2", 'class="mine"')
    for _ in range(20):
        # What a student does reaches the teacher's process a moment later.
        click(teacher, "Show this one")
        with suppress(TimeoutError):
            screen.wait_for(lambda _: all(text in shown(screen) for text in work), 3.0)
            break
    sees(screen, *work)
    assert not any(name in shown(screen) for name in names)
    click(teacher, "Show this run")
    sees(screen, "scene at-run", "One of you")
    sees(teacher, "a student's run")
    click(teacher, "Next: the picture again")
    screen.wait_for(lambda _: "One of you" not in shown(screen), 60.0)
    teacher.set_value("only steps", "2-3")
    sees(teacher, "Lesson 1: steps 2 to 3 only.")


def share_a_duel(teacher: BlockingClient, students: list[BlockingClient], screen: BlockingClient) -> str:
    """Two students in two processes push, and the projector shows the nearer of the two, without a name; return it."""
    click(teacher, "All lessons")
    click(teacher, "6  ")
    choose(teacher, "3")
    sees(teacher, "Lesson 6 · step 3")
    teacher.set_value("only steps", "3")
    margins: list[float] = []
    for times, student in enumerate(students, 1):
        sees(student, "Lesson 6 · step 3")
        click(student, "Next: observe")
        click(student, "Next: challenge")
        sees(student, "You have five pushes")
        for _ in range(4 * times):
            command(student, "Hand or ball 2 cm to the left")
        click(student, "Count this push")
        sees(student, "Push 1 of 5")
        found = re.search(r"You came to ([\d.]+) mm above dₘ", shown(student))
        assert found is not None
        margins.append(float(found[1]))
    record = f"{min(margins):.1f} mm above dₘ"
    sees(screen, "Closest in the class:", record)
    sees(teacher, "Closest in the class:", record)
    return record


def test_students_explore_in_other_processes_and_the_teacher_reaches_them(served: Served, come: Come) -> None:
    teacher = come(key=True)
    open_lessons(teacher)
    sees(teacher, "Lesson 1 · step 1")
    students = [come(name) for name in NAMES]
    click(students[0], "2 ")
    sees(teacher, "1 answered", "students here: 3")
    stage = worker_of(served, teacher)
    assert {worker_of(served, one) for one in students} == {stage}
    # Explore freely: each has a session, in lesson and step of the stage and with an own answer, in another process.
    choose(teacher, "Explore freely")
    for one in students:
        assert ended(one)[0] == MOVED_CODE
    students = [come(name) for name in NAMES]
    for one in students:
        has_controls(one)
        sees(one, "this is your own session", "Lesson 1 · step 1")
    assert "Run" in buttons(students[0])
    sees(teacher, "students here: 3", "exploring: 3")
    places = [worker_of(served, one) for one in students]
    assert stage not in places and len(set(places)) == 2
    # The stage's session has a process of its own; the other two share the places.
    sees(teacher, "of 9", "load: ")
    # What a student hands in arrives.
    click(students[0], "Hand in")
    sees(teacher, "reports handed in: 1")
    sees(students[0], "Handed in without a name.")
    # Paused, and going on.
    click(teacher, "Pause everybody")
    for one in students:
        sees(one, "The teacher has paused everybody.")
    click(teacher, "Let everybody go on")
    for one in students:
        sees(one, "this is your own session")
    screen = come(screen=True)
    look_after_those_who_explore(teacher, students, screen)
    apart = next(one for one, place in zip(students, places, strict=True) if place != places[0])
    record = share_a_duel(teacher, [students[0], apart], screen)
    names = [drawn_name(student) for student in students]
    # A process that dies takes no session along.
    students[0].set_value("critical distance d_m [mm]", 70.0)
    until(lambda: critical_distance(served.store) == 0.07)
    lost = places[0]
    assert len(served.workers) == 3
    served.replace(lost)
    sees(teacher, "students here: " + str(3 - places.count(lost)))
    students = [come(name) if place == lost else one for name, place, one in zip(NAMES, places, students, strict=True)]
    for one in students:
        has_controls(one)
        sees(one, "this is your own session")
    assert students[0].mirror.labelled("critical distance d_m [mm]")["value"] == 70.0
    sees(teacher, "students here: 3", "exploring: 3")
    # The stage's process dies: the class goes on exploring, and the teacher finds all of them.
    served.replace(stage)
    teacher = come(key=True)
    sees(teacher, "students here: 3", "exploring: 3", "reports handed in: 1", "Lesson 6: step 3 only.", record, *names)
    assert all(one.closed is None for one in students)
    # Follow me: all are at the stage again.
    choose(teacher, "Follow me")
    for one in students:
        assert ended(one)[0] == MOVED_CODE
    students = [come(name) for name in NAMES]
    for one in students:
        sees(one, "You follow the teacher")
    assert {worker_of(served, one) for one in students} == {worker_of(served, teacher)}


def test_a_process_in_place_of_another_one_knows_what_was_handed_in_meanwhile() -> None:
    sent: list[object] = []
    link, classroom = WorkerLink(0, sent.append), Classroom(8)
    workers = BreakoutWorkers(link, classroom, link.to_plenary, lambda: None)

    def told(*messages: object) -> list[tuple[str, HandIn | None]]:
        """Students and their reports, as the plenary sends them to other processes after some messages."""
        sent.clear()
        for message in messages:
            link.put(message)
        workers.exchange()
        explorers = [pickle.loads(one.content) for one in sent if isinstance(one, ForTab)]
        return [(one.student, one.report) for one in explorers]

    classroom.explore()
    classroom.settle(("ann", "bo"), 0.0)
    for student in ("ann", "bo"):
        workers.send(student, VisitorRecord({}, Settings(), None))
    load, report = ServerLoad(20, 1, 8, 5), HandIn("Ann", "")
    assert told(Present(1, ("ann",), load), Present(2, ("bo",), load)) == []
    classroom.work.hand_in("ann", report)
    assert told(Replaced(1)) == [("ann", report)]
    # Who was called back at the same moment is not sent there again.
    assert told(Present(1, ("ann",), load)) == []
    classroom.follow()
    assert told(Replaced(1)) == []


@pytest.mark.parametrize("elsewhere", [False, True])
def test_what_a_student_did_last_is_kept_when_the_server_ends(
    by_hand: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, elsewhere: bool
) -> None:
    for period in ("SAVING", "SAVING_AT_REST"):
        monkeypatch.setattr(visitor_module, period, inf)
    ann, link = tab_of("ann"), WorkerLink(1, lambda message: None) if elsewhere else None
    opened = by_hand(lecture=True, key="chalk-and-talk", sessions=8, store=tmp_path / "store", link=link)
    host = opened.host
    assert not isinstance(host, PrivateHost)
    if link is not None:
        link.put(ClassState(True, False, None, ""))
        link.put(Exploring(ann, VisitorRecord({}, Settings(), None), False, None, "Ann", ann))
    else:
        host.classroom.explore()
        host.classroom.settle((ann,), monotonic())
    opened.let_in(f"resume={ann}")
    (session,) = sessions_of(host).values()
    session.change("dm", 0.07)
    opened.house.close()
    assert critical_distance(tmp_path / "store") == 0.07


@pytest.mark.parametrize("served", [1], indirect=True)
def test_a_group_has_one_session_in_another_process_and_outlives_it_and_the_lecture_sigterm(served: Served, come: Come) -> None:
    assert served.process.stdout is not None
    lines = [served.process.stdout.readline() for _ in range(2)]
    assert lines[1] == "3 students, room for 1: groups of 3.\n"
    teacher = come(key=True)
    open_lessons(teacher)
    pages = [come(name) for name in NAMES]
    sees(teacher, "students here: 3", "3 students, room for 1: groups of 3")
    choose(teacher, "Explore freely")
    assert {ended(one)[0] for one in pages} == {MOVED_CODE}

    def together(*names: str) -> dict[str, BlockingClient]:
        """The students come, of whom the first one operates; all are in the one process."""
        found: dict[str, BlockingClient] = {}
        for name in names:
            found[name] = come(name)
            if len(found) == 1:
                has_controls(found[name])
        for name, one in found.items():
            sees(one, "You are 3 at this robot", "You operate it." if name == names[0] else "Another one of you operates it.")
        assert len({worker_of(served, one) for one in found.values()}) == 1
        return found

    ann = together(*NAMES)["ann"]
    sees(teacher, f"{drawn_name(ann)} × 3")
    ann.set_value("critical distance d_m [mm]", 70.0)
    until(lambda: critical_distance(served.store) == 0.07)
    name = drawn_name(ann)
    assert len(served.workers) == 2 and served.said() == ""
    served.replace(worker_of(served, ann))
    pages = together("bo", "ann", "cy")
    bo = pages["bo"]
    assert bo.mirror.labelled("critical distance d_m [mm]")["value"] == 70.0 and drawn_name(bo) == name
    # The stage's process dies: the group stays, also the next time.
    served.replace(worker_of(served, teacher))
    teacher = come(key=True)
    sees(teacher, f"{name} × 3")
    choose(teacher, "Follow me")
    assert {ended(one)[0] for one in pages.values()} == {MOVED_CODE}
    followers = [come(one) for one in NAMES]
    sees(teacher, "students here: 3")
    choose(teacher, "Explore freely")
    assert {ended(one)[0] for one in followers} == {MOVED_CODE}
    assert drawn_name(together("cy", "ann", "bo")["cy"]) == name
    # A service that is ended may be started again, and the lecture goes on.
    assert served.terminate() == ""
    record = kept(served.store, "lecture")
    assert record is not None and record.lessons is not None and record.lessons.open
