"""The class on the wire: a teacher and students who speak viser's protocol, together in one lecture."""

import html
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any
from urllib.parse import quote

import pytest

from app.bench.page_mirror import Mirror
from app.classroom.teacher_panel import COMMANDS
from app.lessons.loading import load_lessons, load_notes
from app.lessons.session.lesson_actions import Choose, GoOn, GoTo
from app.page.panels.choice_buttons import MARK
from app.start import App
from app.web.audiences import MOVED_CODE
from app.web.index_page import ROOM_IS_FULL
from scenes.settings import values
from tests.app.conftest import Join, OpenHouse, ask, lecture_of
from tests.app.page.helpers import bodies, buttons, click, open_lessons, shown
from tests.blocking_client import BlockingClient

BOOK, NOTES = load_lessons(), load_notes()
KEY = "chalk ü"
WAIT = 60.0
Come = Callable[..., BlockingClient]


@pytest.fixture(autouse=True)
def heard(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every page remembers all that it was ever sent."""
    take = Mirror.take

    def remember(mirror: Mirror, message: dict[str, Any]) -> None:
        vars(mirror).setdefault("heard", []).append(repr(message))
        take(mirror, message)

    monkeypatch.setattr(Mirror, "take", remember)


def everything(visitor: BlockingClient) -> str:
    return html.unescape("\n".join(list(vars(visitor.mirror).get("heard", []))))


@pytest.fixture
def come(join: Join) -> Come:
    """`come(house, "ann")` is a student whose tab has an id; `come(house, key=KEY)` a teacher."""

    def make(house: App, name: str = "", query: str = "", key: str = "") -> BlockingClient:
        tab = f"resume={name.encode().hex():0<32}" if name else ""
        return join(house, "&".join(part for part in (tab, query, key and f"key={quote(key)}") if part))

    return make


def sees(visitor: BlockingClient, *texts: str) -> None:
    try:
        visitor.wait_for(lambda _: all(text in shown(visitor) for text in texts), WAIT)
    except TimeoutError as error:
        raise AssertionError(f"{[t for t in texts if t not in shown(visitor)]} not in {shown(visitor)[-3000:]}") from error


def choose(visitor: BlockingClient, label: str) -> None:
    """Press one of a row of buttons."""

    def places(_: object) -> list[tuple[str, str]]:
        rows = bodies(visitor, "GuiButtonGroupMessage")
        return [(row["uuid"], o) for row in rows for o in row["options"] if str(o).removeprefix(MARK) == label]

    visitor.wait_for(places, WAIT)
    uuid, value = places(None)[0]
    visitor.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})


def command(visitor: BlockingClient, name: str) -> None:
    """Do something by its name, as the palette and the keys do."""
    visitor.wait_for(lambda v: any(c["label"] == name for c in list(v.mirror.commands.values())), WAIT)
    uuid = next(uuid for uuid, c in visitor.mirror.commands.items() if c["label"] == name)
    visitor.send({"type": "CommandTriggerMessage", "uuid": uuid})


class Class:
    """A lecture, whose teacher is in lesson 1, and its students by their names."""

    def __init__(self, house: OpenHouse, come: Come, **options: Any) -> None:
        self.opened, self._come = house(lecture=True, key=KEY, **options), come
        self.host = lecture_of(self.opened)
        self.teacher = come(self.opened, key=KEY)
        self.students: dict[str, BlockingClient] = {}
        open_lessons(self.teacher)
        sees(self.teacher, "Lesson 1 · step 1")

    def come(self, *names: str) -> list[BlockingClient]:
        self.students |= {name: self._come(self.opened, name) for name in names}
        return [self.students[name] for name in names]

    def send(self, label: str, *names: str) -> list[BlockingClient]:
        """The teacher chooses where the students work, and their pages are asked to come again, and do."""
        choose(self.teacher, label)
        for name in names:
            self.is_sent_away(name)
        return self.come(*names)

    def is_sent_away(self, name: str) -> None:
        """Wait until a student's page is asked to come again."""
        visitor = self.students[name]
        visitor.wait_for(lambda v: v.closed is not None, WAIT)
        assert visitor.closed is not None and visitor.closed.rcvd is not None and visitor.closed.rcvd.code == MOVED_CODE

    def number(self, name: str) -> int:
        """Wait until a student has a session of their own, and return its number."""
        visitor = self.students[name]
        visitor.wait_for(lambda v: bodies(v, "GuiSliderMessage"), WAIT)
        (owner,) = {str(node["owner"]) for node in list(visitor.mirror.nodes.values()) if node.get("owner")}
        visitor.wait_for(lambda _: int(owner) in self.host.sessions, WAIT)
        return int(owner)

    def critical_distance(self, name: str) -> float:
        return ask(self.host.sessions[self.number(name)], lambda s: s.settings.run.law.critical_distance)


def secrets_of(lesson: str) -> list[str]:
    """Words that stand in the notes to a lesson and in nothing that students read."""
    lines = [line.strip() for line in NOTES[lesson].splitlines() if len(line.split()) > 5]
    return [" ".join(line.split(" ")[1:5]) for line in lines if not set(line) & set("#*`$“”")] + ["Usually believed", "Watch out"]


def test_only_the_key_opens_the_notes_and_a_wrong_one_is_named(house: OpenHouse, come: Come) -> None:
    room = Class(house, come)
    opened, host, teacher = room.opened, room.host, room.teacher
    students = [*room.come("ann"), come(opened, "bo", "key=chal"), come(opened, query="screen=1")]
    students += room.send("Explore freely", "ann")
    some = [BOOK.lessons[i] for i in (5, 0)]
    for lesson in some:
        ask(host.session, lambda _, lesson=lesson: host.lessons.act(GoTo(BOOK.lessons.index(lesson), 0)))
        sees(teacher, secrets_of(lesson.id)[0])
        sees(students[2], f"Lesson {lesson.number} · step 1")
    sent, heard = everything(teacher), [everything(student) for student in students]
    for lesson in some:
        words = secrets_of(lesson.id)
        assert len(words) > 3 and any(word in sent for word in words)
        assert not [word for word in words if any(word in one for one in heard)], lesson.id
    assert ["not the teacher" in one for one in heard] == [False, True, False, False] and "not the teacher" not in sent
    # The key is the teacher's: it is on no page.
    assert not any("chalk" in one or quote(KEY) in one for one in (sent, *heard))
    with urllib.request.urlopen(opened.url, timeout=60) as page:
        assert "Usually believed" not in page.read().decode()


def test_alone_the_key_opens_the_notes_and_another_one_says_so(house: OpenHouse, come: Come) -> None:
    opened = house(key=KEY)
    visitors = come(opened, key=KEY), come(opened, "ann"), come(opened, "bo", "key=chal")
    for visitor in visitors:
        open_lessons(visitor)
        sees(visitor, "Lesson 1 · step 1")
    sees(visitors[0], "Usually believed")
    visitors[2].wait_for(lambda _: "This is not the teacher's key" in everything(visitors[2]).replace("\\'", "'"), WAIT)
    for words, whose in ("Usually believed", [True, False, False]), ("not the teacher", [False, False, True]):
        assert [words in everything(visitor) for visitor in visitors] == whose


def test_a_class_answers_on_its_own_devices(house: OpenHouse, come: Come) -> None:
    room = Class(house, come)
    host, teacher, (ann, bo, cy) = room.host, room.teacher, room.come("ann", "bo", "cy")
    screen = come(room.opened, query="screen=1")
    sees(ann, "Your prediction? Answer here")
    question = BOOK.lessons[0].steps[0].question
    assert question is not None
    right, wrong = question.right, (question.right + 1) % len(question.choices)
    sees(teacher, "0 answered · 3 not yet", "students here: 3")
    click(ann, f"{wrong + 1} ")
    sees(ann, "You may change it until the reveal.")
    command(bo, f"Answer {wrong + 1}")
    sees(teacher, "2 answered · 1 not yet")
    # Ann changes her mind, and comes back twice; bo's connection is lost.
    click(ann, f"{right + 1} ")
    ann.close()
    (ann,) = room.come("ann")
    sees(ann, "You may change it until the reveal.")
    bo.close()
    sees(teacher, "2 answered · 1 not yet", "students here: 2")
    (bo,) = room.come("bo")
    sees(teacher, "2 answered · 1 not yet", "students here: 3")
    assert not any("The class sa" in everything(one) for one in (ann, bo, cy, screen))
    assert not any(label.startswith("1 ") for label in buttons(screen))
    assert not host.session.paused or ask(host.session, lambda s: s.simulation.steps) == 0
    click(cy, f"{right + 1} ")
    sees(teacher, "3 answered · 0 not yet")
    # The class's favourite is what the run is compared with.
    click(teacher, "Reveal to everybody")
    for one in (ann, bo, cy, screen, teacher):
        sees(one, "The class said", "3 answered")
    sees(bo, "Answers are closed.")
    assert host.lessons.walk.done.choice == right and not host.lessons.locked
    sent = ask(host.session, lambda _: host.room.answer(host.lessons.walk, "bo", right))
    assert not sent and not [label for label in buttons(bo) if label.startswith(f"{right + 1} ")]
    # The outcome stands beside the answers, and everybody gets the verdict on their own one.
    ask(host.session, lambda _: host.lessons.act(GoOn()))
    for one in (ann, bo, cy):
        sees(one, "The class said", "Measured", "You said")
    sees(bo, "card wrong duet-say")
    # The stage's verdict is the class's; ann's own one stands beside it.
    ann.wait_for(lambda _: shown(ann).count("card right duet-say") == 2, WAIT)
    # Asked again, everybody answers again, and both rounds are shown.
    click(teacher, "Ask again")
    sees(teacher, "0 answered · 3 not yet", "Round 1", "Round 2")
    sees(bo, "Asked again", "Your first answer:")
    assert "Round 1" not in everything(bo)
    for one in (ann, bo, cy):
        click(one, f"{right + 1} ")
    sees(teacher, "another answer the second time: 1.")
    click(teacher, "Reveal to everybody")
    for one in (bo, screen):
        sees(one, "Round 1", "Round 2", "another answer the second time: 1.")
    # The teacher leaves the lessons: nothing is left of the question.
    click(teacher, "Leave the lessons")
    click(teacher, "Leave with the class")
    bo.wait_for(lambda v: not [c for c in list(v.mirror.commands.values()) if str(c["label"]).startswith("Answer")], WAIT)


def test_two_students_and_a_teacher_do_not_reach_each_other(house: OpenHouse, come: Come) -> None:
    room = Class(house, come)
    host, teacher = room.host, room.teacher
    click(teacher, "Leave the lessons")
    click(teacher, "Leave with the class")
    teacher.wait_for(lambda _: not host.lessons.open, WAIT)
    ask(host.session, lambda s: s.change("dm", 0.12))
    room.come("ann", "bo")
    ann, bo = room.send("Explore freely", "ann", "bo")
    a, b = room.number("ann"), room.number("bo")
    sees(teacher, "exploring: 2")
    sees(ann, "this is your own session")
    # They begin where the teacher is, and see nothing of the stage.
    assert room.critical_distance("ann") == room.critical_distance("bo") == 0.12
    assert all(node.get("owner") == str(a) for name, node in ann.mirror.nodes.items() if name.startswith("/arms/"))

    def state(number: int | None = None) -> tuple[Any, ...]:
        session = host.session if number is None else host.sessions[number]
        return ask(session, lambda s: (s.settings, s.paused, s.held))

    stage, his = state(), state(b)
    ann.set_value("critical distance d_m [mm]", 70.0)
    command(ann, "Pause or go on")
    ann.wait_for(lambda _: host.sessions[a].paused and host.sessions[a].settings.run.law.critical_distance == 0.07, WAIT)
    assert state(b) == his and state() == stage
    bo.set_value("critical distance d_m [mm]", 200.0)
    open_lessons(bo)
    bo.wait_for(lambda _: values(host.sessions[b].settings)["scene"] == "solo", WAIT)
    assert room.critical_distance("ann") == 0.07 and state() == stage
    ask(host.session, lambda s: s.change("dm", 0.25))
    assert room.critical_distance("ann") == 0.07
    # Ann's connection breaks off, and she is back where she was.
    ann.close()
    room.come("ann")
    assert room.critical_distance("ann") == 0.07
    # Follow me: the stage, and nothing of their own.
    ann, bo = room.send("Follow me", "ann", "bo")
    sees(ann, "You follow the teacher")
    assert host.sessions == {} and not bodies(ann, "GuiSliderMessage")
    # Released again, each has their own settings, and bo is in his lesson.
    ann, bo = room.send("Explore freely", "ann", "bo")
    assert room.critical_distance("ann") == 0.07
    sees(bo, "Lesson 1 · step 1")
    b = room.number("bo")
    click(bo, "Leave the lessons")
    bo.wait_for(lambda _: host.sessions[b].settings.run.law.critical_distance == 0.2, WAIT)


def test_explorers_begin_at_the_teachers_step_with_their_own_answers(house: OpenHouse, come: Come) -> None:
    room = Class(house, come)
    (ann,) = room.come("ann")
    click(ann, "2 ")
    sees(room.teacher, "1 answered")
    ask(room.host.session, lambda _: room.host.lessons.act(GoTo(1, 1)))
    (ann,) = room.send("Explore freely", "ann")
    sees(ann, "Lesson 2 · step 2")
    walk = room.host.participants[room.number("ann")].visitor.lessons.walk  # type: ignore[union-attr]
    assert walk.done_in(BOOK.lessons[0].id, BOOK.lessons[0].steps[0].id).choice == 1


def test_places_are_few_and_a_student_without_one_reads_so(house: OpenHouse, come: Come) -> None:
    room = Class(house, come, sessions=1)
    host, teacher, (ann, bo), nameless = room.host, room.teacher, room.come("ann", "bo"), come(room.opened)
    (ann,) = room.send("Explore freely", "ann")
    room.number("ann")
    sees(bo, "All 1 places for exploring are taken")
    sees(nameless, "Your browser blocks storage")
    sees(teacher, "exploring: 1", "without a place: 2")
    assert bo.closed is None and nameless.closed is None and len(host.sessions) == 1
    # A class paused stands still, and goes on.
    session = next(iter(host.sessions.values()))
    ask(session, lambda s: s.change("autopilot", True))
    click(teacher, "Pause everybody")
    for one in (ann, bo):
        sees(one, "The teacher has paused everybody.")
    steps = ask(session, lambda s: s.simulation.steps)
    for wish in ("Pause or go on", "One single step", "Slower"):
        command(ann, wish)
    ann.wait_for(lambda _: session.settings.page.speed == 0.5, WAIT)
    assert ask(session, lambda s: s.simulation.steps) == steps and session.paused and host.session.paused
    click(teacher, "Let everybody go on")
    sees(ann, "this is your own session")


def test_every_button_of_the_teacher_has_a_key_and_the_address_is_shown_until_it_is_hidden(house: OpenHouse, come: Come) -> None:
    room = Class(house, come)
    teacher, (ann,) = room.teacher, room.come("ann")
    names = {action: name for name, _, action in COMMANDS}
    # The address is the teacher's until it is on every screen.
    address = room.opened.url.removeprefix("http://") + "/"
    sees(teacher, "students here: 1", address, "<svg")
    assert address not in everything(ann)
    command(teacher, names["invite"])
    sees(ann, "Join the class", address, "QR code")
    click(teacher, "Hide it again")
    ann.wait_for(lambda _: "Join the class" not in shown(ann), WAIT)
    # There is nothing to reveal yet; what comes after it is done after it.
    command(teacher, names["reveal"])
    for action, text in (("pause", "The teacher has paused everybody."), ("pause", "You follow the teacher")):
        command(teacher, names[action])
        sees(ann, text)
    command(ann, "Answer 1")
    sees(teacher, "1 answered · 0 not yet")
    for action, text in (("reveal", "The class said"), ("again", "Asked again")):
        command(teacher, names[action])
        sees(ann, text)
    command(teacher, names["free"])
    room.is_sent_away("ann")
    sees(teacher, "exploring: ")
    command(teacher, names["free"])
    teacher.wait_for(lambda _: not room.host.room.free, WAIT)


def test_a_report_is_handed_in_on_the_stage_and_in_an_own_session_and_taken_back(house: OpenHouse, come: Come) -> None:
    room = Class(house, come)
    teacher, work, (ann, bo) = room.teacher, room.host.room.work, room.come("ann", "bo")
    ids = {name: f"{name.encode().hex():0<32}" for name in ("ann", "bo")}
    assert "Hand in" not in buttons(ann), "there is nothing to hand in"
    click(ann, "2 ")
    sees(ann, "The teacher gets what is in your lab report")
    ann.set_value("Name", " Ann\n=1 ")
    click(ann, "Hand in")
    sees(ann, "Handed in as Ann =1.")
    sees(teacher, "reports handed in: 1")
    assert "Hand in" not in buttons(bo) and "Ann =1" not in everything(bo)
    # In a session of her own she finds it handed in, goes on, and hands it in again, without a name.
    ann, bo = room.send("Explore freely", "ann", "bo")
    sees(ann, "Handed in as Ann =1.")
    (visitor,) = (one.visitor for one in room.host.participants.values() if one.id == ids["ann"])
    assert visitor is not None
    ask(visitor.session, lambda _: [visitor.lessons.act(GoTo(3, 0)), visitor.lessons.act(Choose(1))])
    click(ann, "Hand in again")
    sees(ann, "Handed in without a name.")
    assert '"choice": 1' in work.hand_ins[ids["ann"]].progress and "lambda" in work.hand_ins[ids["ann"]].progress
    # Bo does something there, and hands it in from the stage.
    (his,) = (one.visitor for one in room.host.participants.values() if one.id == ids["bo"])
    assert his is not None
    ask(his.session, lambda _: his.lessons.act(Choose(0)))
    ann, bo = room.send("Follow me", "ann", "bo")
    click(bo, "Hand in")
    sees(bo, "Handed in without a name.")
    assert '"choice": 0' in work.hand_ins[ids["bo"]].progress
    click(ann, "Take it back")
    sees(teacher, "reports handed in: 1")
    assert set(work.hand_ins) == {ids["bo"]}


def test_a_full_lecture_asks_to_wait_but_lets_the_teacher_in(house: OpenHouse, come: Come) -> None:
    opened = house(lecture=True, key=KEY, watchers=2)
    ann, _ = come(opened, "ann"), come(opened, "bob")
    host = lecture_of(opened)
    ann.wait_for(lambda _: host.session.simulation.time > 0.3)
    assert host.operator is None
    with pytest.raises(urllib.error.HTTPError, match="503") as full:
        urllib.request.urlopen(opened.url, timeout=60)
    assert "2 places" in full.value.read().decode()
    with BlockingClient(opened.url, query="key=wrong") as late:
        late.wait_for(lambda v: v.closed)
        assert late.closed is not None and late.closed.rcvd is not None and late.closed.rcvd.reason == ROOM_IS_FULL
    teacher = come(opened, key=KEY)
    with urllib.request.urlopen(f"{opened.url}/?key={quote(KEY)}", timeout=60) as page:
        assert page.status == 200
    teacher.wait_for(lambda _: host.operator is not None)
    assert ann.closed is None and teacher.closed is None
