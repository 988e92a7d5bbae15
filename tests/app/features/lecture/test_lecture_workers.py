"""A lecture in several processes: breakout sessions in others than the shared session's."""

import pickle
from collections.abc import Iterator
from contextlib import closing
from math import inf
from pathlib import Path
from time import monotonic

import pytest

from app.features.classroom.class_record import NAME, class_of
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
from tests.app.conftest import Made
from tests.app.features.lecture.lecture_room import choose, drawn_name, sees, sessions_of, tab_of
from tests.app.features.lecture.served_class import (
    D_M,
    NAMES,
    OPTIONS,
    ServedClass,
    critical_distance,
    push,
    show_work,
)
from tests.app.features.lessons.helpers import opens_lesson
from tests.app.features.store.kept import kept
from tests.app.features.workers.served import Serve, Served
from tests.app.features.workers.test_workers import worker_of
from tests.app.page.helpers import buttons, click, shown
from tests.app.runtime.processes import until
from tests.approved import Approve


@pytest.fixture(scope="module")
def lasting_class(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedClass]:
    """One class for the tests that end no process."""
    served = Served(tmp_path_factory.mktemp("class"), *OPTIONS)
    with closing(served), closing(ServedClass(served)) as made:
        yield made


@pytest.fixture
def explorers(lasting_class: ServedClass) -> ServedClass:
    lasting_class.begin()
    return lasting_class


@pytest.fixture
def mortal(serve: Serve) -> Iterator[ServedClass]:
    """A class for one test, which may kill its processes."""
    with closing(ServedClass(serve(*OPTIONS))) as made:
        yield made


@pytest.mark.thorough
def test_students_follow_in_the_shared_process_and_explore_in_others(
    explorers: ServedClass, approve: Approve
) -> None:
    approve("places of a served class.txt", explorers.places)
    assert explorers.followed_in == {explorers.shared}
    for name in NAMES:
        sees(explorers.students[name], "this is your own session", "Lesson 1 · step")
    assert "Run" in buttons(explorers.students["ann"]), "her answer is in the breakout session"
    ann, bo, cy = (explorers.process_of(name) for name in NAMES)
    assert ann == bo and len({explorers.shared, ann, cy}) == 3
    # The shared session has a separate process; the others share the places.
    sees(explorers.teacher, "students here: 3", "exploring: 3", "of 4", "load: ")


@pytest.mark.thorough
def test_a_hand_in_and_a_pause_reach_the_other_processes(explorers: ServedClass) -> None:
    teacher, ann = explorers.teacher, explorers.students["ann"]
    click(ann, "Hand in")
    sees(teacher, "reports handed in: 1")
    sees(ann, "Handed in without a name.")
    click(ann, "Take it back")
    for one, said in ((teacher, "reports handed in"), (ann, "Handed in without a name.")):
        one.wait_for(lambda _, one=one, said=said: said not in shown(one), 60.0)
    click(teacher, "Pause everybody")
    for name in NAMES:
        sees(explorers.students[name], "paused everybody")
    click(teacher, "Continue for everybody")
    for name in NAMES:
        sees(explorers.students[name], "this is your own session")


@pytest.mark.thorough
def test_the_teacher_sees_drawn_names_opens_steps_and_shows_work(
    explorers: ServedClass,
) -> None:
    teacher, screen, students = explorers.teacher, explorers.screen, explorers.students
    names = [drawn_name(students[name]) for name in NAMES]
    sees(teacher, "Every step is open.", *names)
    teacher.set_value("only steps", "2")
    for name in NAMES:
        sees(students[name], "Lesson 1 · step 2", "Lesson 1: step 2 only.")
    bo = students["bo"]
    choose(bo, "1")
    click(bo, "2 ")
    sees(bo, "Your prediction", "Lesson 1 · step 2")
    click(bo, "Run")
    show_work(teacher, screen, names[1], "One of you", "Lesson 1 · step 2", 'class="mine"')
    assert not any(name in shown(screen) for name in names)
    click(teacher, "Show this run")
    sees(screen, "scene at-run", "One of you")
    sees(teacher, "a student's run")
    click(teacher, "Next: the picture again")
    screen.wait_for(lambda _: "One of you" not in shown(screen), 60.0)
    teacher.set_value("only steps", "2-3")
    sees(teacher, "steps 2 to 3 only")


@pytest.mark.thorough
def test_the_projector_shows_the_nearest_push_of_all_processes(
    explorers: ServedClass,
) -> None:
    teacher = explorers.teacher
    click(teacher, "All lessons")
    click(teacher, "6  ")
    choose(teacher, "3")
    sees(teacher, "Lesson 6 · step 3")
    teacher.set_value("only steps", "3")
    margins = [push(explorers.students[name], times) for times, name in enumerate(("ann", "cy"), 1)]
    for one in (explorers.screen, teacher):
        sees(one, "Closest in the class:", f"{min(margins):.1f} mm above dₘ")


@pytest.mark.thorough
def test_a_group_survives_the_loss_of_its_process_and_a_recall(
    mortal: ServedClass,
) -> None:
    served, teacher, students = mortal.served, mortal.teacher, mortal.students
    mortal.come_late("di")
    mortal.are_together("ann", "di")
    name, lost = drawn_name(students["ann"]), mortal.process_of("ann")
    sees(teacher, f"{name} × 2")
    students["ann"].set_value(D_M, 70.0)
    until(lambda: mortal.critical_distance("ann") == 0.07)
    assert len(served.workers) == 3 and served.said() == ""
    served.replace(lost)
    sees(teacher, "students here: 1")
    # The order of reconnection does not matter.
    mortal.come("di", "bo")
    mortal.has_controls("di")
    mortal.come("ann")
    mortal.are_together("di", "ann")
    mortal.has_controls("bo")
    sees(students["bo"], "this is your own session")
    assert students["di"].mirror.labelled(D_M)["value"] == 70.0 and drawn_name(students["di"]) == name
    sees(teacher, "students here: 4", "exploring: 4", f"{name} × 2")
    mortal.send("Follow me", *NAMES, "di")
    for one in students.values():
        sees(one, "You follow the teacher")
    assert {worker_of(served, one) for one in students.values()} == {worker_of(served, teacher)}
    mortal.send("Explore freely", "ann", "di")
    mortal.has_controls("ann")
    mortal.are_together("ann", "di")
    assert drawn_name(students["ann"]) == name


@pytest.mark.thorough
def test_exploring_continues_when_the_shared_process_dies(
    mortal: ServedClass,
) -> None:
    served, students = mortal.served, mortal.students
    names = [drawn_name(students[name]) for name in NAMES]
    click(students["ann"], "Hand in")
    mortal.teacher.set_value("only steps", "2")
    sees(mortal.teacher, "reports handed in: 1", "Lesson 1: step 2 only.", *names)

    def is_stored() -> bool:
        record = kept(served.store, NAME)
        room = None if record is None else class_of(record)
        return room is not None and bool(room.hand_ins) and room.pace is not None

    until(is_stored)
    served.replace(mortal.shared)
    teacher = mortal.come_as_teacher()
    sees(
        teacher, "students here: 3", "exploring: 3", "reports handed in: 1", "Lesson 1: step 2 only.", *names
    )
    assert all(students[name].closed is None for name in NAMES)
    # A terminated service keeps the lecture for its next start.
    assert served.terminate() == ""
    assert opens_lesson(kept(served.store, NAME))


def test_a_replacement_process_gets_the_hand_ins() -> None:
    sent: list[object] = []
    link, classroom = WorkerLink(0, sent.append), Classroom(8)
    workers = BreakoutWorkers(link, classroom, link.to_first)

    def told(*messages: object) -> list[tuple[str, HandIn | None]]:
        """Students and reports that the shared session sends to other processes after these messages."""
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
    # A recalled student is not sent to the new process.
    assert told(Present(1, ("ann",), load)) == []
    classroom.follow()
    assert told(Replaced(1)) == []


@pytest.mark.thorough
@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_students_last_change_is_saved_when_the_server_ends(
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
    assert critical_distance(tmp_path / "store", "ann") == 0.07
