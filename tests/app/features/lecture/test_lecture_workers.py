"""A lecture in several processes: the students explore in others than the stage's, and the teacher reaches all of them."""

import pickle
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, suppress
from math import inf
from pathlib import Path
from time import monotonic

import pytest

from app.features.classroom.class_summary import HandIn
from app.features.classroom.classroom import Classroom
from app.features.lecture.breakout_host import BreakoutHost
from app.features.lecture.breakout_sessions import BreakoutWorkers
from app.features.lecture.class_messages import ClassState, Exploring, Present
from app.features.lecture.lecture import LectureHost
from app.features.workers.worker_messages import ForTab, Replaced, WorkerLink
from app.hosting import visitor as visitor_module
from app.hosting.visitor_record import VisitorRecord
from app.page.panels.server_load import ServerLoad
from app.settings import Settings
from app.web.server import MOVED_CODE
from tests.app.conftest import Made
from tests.app.features.lecture.lecture_room import choose, command, drawn_name, sees, sessions_of, tab_of
from tests.app.features.lessons.helpers import opens_lesson
from tests.app.features.store.kept import kept
from tests.app.features.workers.served import Serve, Served
from tests.app.features.workers.test_workers import worker_of
from tests.app.page.helpers import bodies, buttons, click, open_lessons, shown
from tests.app.runtime.processes import until
from tests.app.served import has_arms
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

NAMES = ("ann", "bo", "cy")
"""Each has a session of their own; di, who comes late, shares ann's."""

Come = Callable[..., BlockingClient]


@pytest.fixture
def served(serve: Serve) -> Served:
    return serve(
        "--lecture", "--workers", "2", "--key", "chalk-and-talk", "--sessions", "3", "--students", "4"
    )


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


def sent_away(students: Iterable[BlockingClient]) -> None:
    """Wait until all are asked to come again."""
    assert {ended(one)[0] for one in students} == {MOVED_CODE}


def comes_late(come: Come, name: str) -> BlockingClient:
    """A student who sees the stage until there is a place in a group."""
    one = come(name)
    one.wait_for(lambda v: v.closed or "at this robot" in shown(v))
    return one if one.closed is None else come(name)


def are_together(served: Served, operator: BlockingClient, watcher: BlockingClient) -> None:
    """Both see their group's session, in one process."""
    sees(operator, "You are 2 at this robot", "You operate it.")
    sees(watcher, "You are 2 at this robot", "Another member of your group has control.")
    assert worker_of(served, operator) == worker_of(served, watcher)


def look_after_those_who_explore(
    teacher: BlockingClient, students: list[BlockingClient], screen: BlockingClient
) -> None:
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
        found = re.search(r"You came to ([\d.]+)\smm above dₘ", shown(student))
        assert found is not None
        margins.append(float(found[1]))
    record = f"{min(margins):.1f} mm above dₘ"
    sees(screen, "Closest in the class:", record)
    sees(teacher, "Closest in the class:", record)
    return record


@pytest.mark.thorough
def test_students_and_a_group_explore_in_other_processes_and_the_teacher_reaches_them(
    served: Served, come: Come
) -> None:
    assert served.process.stdout is not None
    lines = [served.process.stdout.readline() for _ in range(2)]
    assert lines[1] == "4 students, room for 3: groups of 2.\n"
    teacher = come(key=True)
    open_lessons(teacher)
    sees(teacher, "Lesson 1 · step 1", "4 students, room for 3: groups of 2")
    students = [come(name) for name in NAMES]
    click(students[0], "2 ")
    sees(teacher, "1 answered", "students here: 3")
    stage = worker_of(served, teacher)
    assert {worker_of(served, one) for one in students} == {stage}
    # Explore freely: each has a session, in lesson and step of the stage and with an own answer, in another process.
    choose(teacher, "Explore freely")
    sent_away(students)
    ann, bo, cy = (come(name) for name in NAMES)
    for one in (ann, bo, cy):
        has_controls(one)
        sees(one, "this is your own session", "Lesson 1 · step 1")
    assert "Run" in buttons(ann)
    lost = worker_of(served, ann)
    assert worker_of(served, bo) == lost and len({stage, lost, worker_of(served, cy)}) == 3
    # The stage's session has a process of its own; the others share the places.
    sees(teacher, "students here: 3", "exploring: 3", "of 4", "load: ")
    # What a student hands in arrives, and what is taken back is gone.
    click(ann, "Hand in")
    sees(teacher, "reports handed in: 1")
    sees(ann, "Handed in without a name.")
    click(ann, "Take it back")
    for one, said in ((teacher, "reports handed in"), (ann, "Handed in without a name.")):
        one.wait_for(lambda _, one=one, said=said: said not in shown(one), 60.0)
    click(ann, "Hand in")
    sees(teacher, "reports handed in: 1")
    sees(ann, "Handed in without a name.")
    # Paused, and going on.
    click(teacher, "Pause everybody")
    for one in (ann, bo, cy):
        sees(one, "The teacher has paused everybody.")
    click(teacher, "Let everybody go on")
    for one in (ann, bo, cy):
        sees(one, "this is your own session")
    screen = come(screen=True)
    look_after_those_who_explore(teacher, [ann, bo, cy], screen)
    record = share_a_duel(teacher, [ann, cy], screen)
    # For one more there is no place; and a process that dies takes no session along, in any order of the group.
    di = comes_late(come, "di")
    are_together(served, ann, di)
    sees(teacher, f"{drawn_name(ann)} × 2")
    ann.set_value("critical distance d_m [mm]", 70.0)
    until(lambda: critical_distance(served.store) == 0.07)
    name, others = drawn_name(ann), [drawn_name(bo), drawn_name(cy)]
    assert len(served.workers) == 3 and served.said() == ""
    served.replace(lost)
    sees(teacher, "students here: 1")
    di, bo = come("di"), come("bo")
    has_controls(di)
    ann = come("ann")
    are_together(served, di, ann)
    has_controls(bo)
    sees(bo, "this is your own session")
    assert di.mirror.labelled("critical distance d_m [mm]")["value"] == 70.0 and drawn_name(di) == name
    sees(teacher, "students here: 4", "exploring: 4", f"{name} × 2")
    # The stage's process dies: the class goes on exploring, and the teacher finds all of them.
    served.replace(stage)
    teacher = come(key=True)
    sees(
        teacher, "students here: 4", "exploring: 4", "reports handed in: 1", "Lesson 6: step 3 only.", record
    )
    sees(teacher, f"{name} × 2", *others)
    assert all(one.closed is None for one in (ann, bo, cy, di))
    # Follow me: all are at the stage again; and the group is one again the next time.
    choose(teacher, "Follow me")
    sent_away((ann, bo, cy, di))
    students = [come(name) for name in (*NAMES, "di")]
    for one in students:
        sees(one, "You follow the teacher")
    assert {worker_of(served, one) for one in students} == {worker_of(served, teacher)}
    choose(teacher, "Explore freely")
    sent_away(students)
    ann = come("ann")
    has_controls(ann)
    are_together(served, ann, come("di"))
    assert drawn_name(ann) == name
    # A service that is ended may be started again, and the lecture goes on.
    assert served.terminate() == ""
    left = kept(served.store, "lecture")
    assert opens_lesson(left)


def test_a_process_in_place_of_another_one_knows_what_was_handed_in_meanwhile() -> None:
    sent: list[object] = []
    link, classroom = WorkerLink(0, sent.append), Classroom(8)
    workers = BreakoutWorkers(link, classroom, link.to_first)

    def told(*messages: object) -> list[tuple[str, HandIn | None]]:
        """Students and their reports, as the shared session sends them to other processes after some messages."""
        sent.clear()
        for message in messages:
            link.put(message)
        workers.exchange()
        explorers = [pickle.loads(one.content) for one in sent if isinstance(one, ForTab)]
        return [(one.student, one.report) for one in explorers]

    classroom.explore()
    classroom.settle(("ann", "bo"), 0.0)
    for student in ("ann", "bo"):
        workers.send(student, VisitorRecord({}, Settings()))
    load, report = ServerLoad(20, 1, 8, 5), HandIn("Ann", "")
    assert told(Present(1, ("ann",), load), Present(2, ("bo",), load)) == []
    classroom.work.hand_in("ann", report)
    assert told(Replaced(1)) == [("ann", report)]
    # Who was called back at the same moment is not sent there again.
    assert told(Present(1, ("ann",), load)) == []
    classroom.follow()
    assert told(Replaced(1)) == []


@pytest.mark.thorough
@pytest.mark.parametrize("elsewhere", [False, True])
def test_what_a_student_did_last_is_kept_when_the_server_ends(
    by_hand: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, elsewhere: bool
) -> None:
    for period in ("SAVING", "SAVING_AT_REST"):
        monkeypatch.setattr(visitor_module, period, inf)
    ann, link = tab_of("ann"), WorkerLink(1, lambda message: None) if elsewhere else None
    opened = by_hand(
        lecture=True,
        key="chalk-and-talk",
        sessions=8,
        store=tmp_path / "store",
        started_with=() if link is None else (link,),
    )
    host = opened.host
    assert isinstance(host, LectureHost | BreakoutHost)
    if link is not None:
        link.put(ClassState(True, False, None, ""))
        link.put(Exploring(ann, VisitorRecord({}, Settings()), False, None, "Ann", ann))
    else:
        assert isinstance(host, LectureHost)
        host.classroom.explore()
        host.classroom.settle((ann,), monotonic())
    opened.let_in(f"resume={ann}")
    (session,) = sessions_of(host).values()
    session.change("dm", 0.07)
    opened.house.close()
    assert critical_distance(tmp_path / "store") == 0.07
