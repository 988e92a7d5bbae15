"""The class on the wire: a teacher and students who speak viser's protocol, together in one lecture."""

import html
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from app.bench.blocking_client import BlockingClient
from app.bench.headless_client import HeadlessClient
from app.bench.page_mirror import Mirror
from app.classroom.lecture import LectureHost
from app.classroom.teacher_panel import COMMANDS
from app.hosting.private_host import PrivateHost
from app.lessons.loading import load_lessons, load_notes
from app.lessons.session.lesson_actions import GoOn, GoTo
from app.start import App
from app.web.audiences import MOVED_CODE
from app.web.index_page import ROOM_IS_FULL
from scenes.settings import values
from tests.app.conftest import HAND, OpenHouse, ask

BOOK, NOTES = load_lessons(), load_notes()
KEY = "chalk"
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


def everything(visitor: BlockingClient | HeadlessClient) -> str:
    """All that a page was ever sent."""
    return html.unescape("\n".join(list(vars(visitor.mirror).get("heard", []))))


@pytest.fixture
def come() -> Iterator[Come]:
    """`come(house, "ann")` is a student whose tab remembers a word; `come(house, key=KEY)` a teacher."""
    visitors: list[BlockingClient] = []

    def make(house: App, name: str = "", query: str = "", key: str = "") -> BlockingClient:
        word = f"resume={name.encode().hex():0<32}" if name else ""
        visitors.append(BlockingClient(house.url, query="&".join(part for part in (word, query, key and f"key={key}") if part)))
        visitors[-1].wait_for(lambda v: v.mirror.replayed and any(n.startswith("/arms/") for n in list(v.mirror.nodes)), WAIT)
        return visitors[-1]

    yield make
    for visitor in visitors:
        visitor.close()


def host_of(house: App) -> LectureHost:
    """The lecture's host."""
    assert isinstance(house.host, LectureHost)
    return house.host


def shown(visitor: BlockingClient | HeadlessClient) -> str:
    """All texts in view on a page."""
    return html.unescape(
        " ".join(str(e.get("content") or "") for e in list(visitor.mirror.gui.values()) if e.get("visible", True))
    )


def sees(visitor: BlockingClient, *texts: str) -> None:
    """Wait until a page shows texts."""
    try:
        visitor.wait_for(lambda _: all(text in shown(visitor) for text in texts), WAIT)
    except TimeoutError as error:
        raise AssertionError(f"{[t for t in texts if t not in shown(visitor)]} not in {shown(visitor)[-3000:]}") from error


def labels(visitor: BlockingClient) -> list[str]:
    """What stands on the buttons in view."""
    found = [e for e in list(visitor.mirror.gui.values()) if e["type"] == "GuiButtonMessage" and e.get("visible", True)]
    return [str(e["label"]) for e in found]


def click(visitor: BlockingClient, start: str) -> None:
    """Press the button in view whose label begins like this."""
    visitor.wait_for(lambda v: any(label.removeprefix("● ").startswith(start) for label in labels(visitor)), WAIT)
    visitor.click(next(label for label in labels(visitor) if label.removeprefix("● ").startswith(start)))


def choose(visitor: BlockingClient, label: str) -> None:
    """Press one of a row of buttons."""

    def row(v: Any) -> dict[str, Any] | None:
        rows = [e for e in list(v.mirror.gui.values()) if e["type"] == "GuiButtonGroupMessage"]
        return next((e for e in rows if any(str(o).removeprefix("● ") == label for o in e["options"])), None)

    visitor.wait_for(row, WAIT)
    found = row(visitor)
    assert found is not None
    value = next(o for o in found["options"] if str(o).removeprefix("● ") == label)
    visitor.send({"type": "GuiUpdateMessage", "uuid": found["uuid"], "updates": {"value": value}})


def command(visitor: BlockingClient, name: str) -> None:
    """Do something by its name, as the palette and the keys do."""
    visitor.wait_for(lambda v: any(c["label"] == name for c in list(v.mirror.commands.values())), WAIT)
    uuid = next(uuid for uuid, c in visitor.mirror.commands.items() if c["label"] == name)
    visitor.send({"type": "CommandTriggerMessage", "uuid": uuid})


def is_sent_away(visitor: BlockingClient) -> None:
    """Wait until a page is asked to come again."""
    visitor.wait_for(lambda v: v.closed is not None, WAIT)
    assert visitor.closed is not None and visitor.closed.rcvd is not None and visitor.closed.rcvd.code == MOVED_CODE


def open_class(house: OpenHouse, come: Come, **options: Any) -> tuple[App, LectureHost, BlockingClient]:
    """A lecture with its teacher, in lesson 1."""
    opened = house(lecture=True, key=KEY, **options)
    teacher = come(opened, key=KEY)
    click(teacher, "Lessons")
    sees(teacher, "Lesson 1 · step 1")
    return opened, host_of(opened), teacher


def dm_of(house: App, host: LectureHost, number: int) -> float:
    """The d_m of a breakout session."""
    return ask(host.sessions[number], lambda s: s.settings.run.law.critical_distance)


def explores(host: LectureHost, visitor: BlockingClient) -> int:
    """Wait until a visitor has a session of their own, and return its number."""
    visitor.wait_for(lambda v: HAND in v.mirror.nodes or "Lesson" in shown(visitor), WAIT)
    visitor.wait_for(lambda v: any(e["type"] == "GuiSliderMessage" for e in list(v.mirror.gui.values())), WAIT)
    owners = {str(n["owner"]) for n in list(visitor.mirror.nodes.values()) if n.get("owner")}
    assert len(owners) == 1
    number = int(owners.pop())
    visitor.wait_for(lambda _: number in host.sessions, WAIT)
    return number


def secrets_of(lesson: str) -> list[str]:
    """Words that stand in the notes to a lesson and in nothing that students read."""
    lines = [line.strip() for line in NOTES[lesson].splitlines() if len(line.split()) > 5]
    return [" ".join(line.split(" ")[1:5]) for line in lines if not set(line) & set("#*`$“”")] + ["Usually believed", "Watch out"]


def test_only_the_key_opens_the_notes_and_a_wrong_one_is_named(house: OpenHouse, come: Come) -> None:
    opened, host, teacher = open_class(house, come)
    students = [come(opened, "ann"), come(opened, "bo", "key=chal"), come(opened, query="screen=1")]
    choose(teacher, "Explore freely")
    is_sent_away(students[0])
    students.append(come(opened, "ann"))
    some = [BOOK.lessons[i] for i in (5, 0)]
    for lesson in some:
        ask(host.session, lambda _, lesson=lesson: host.lessons.act(GoTo(BOOK.lessons.index(lesson), 0)))
        sees(teacher, secrets_of(lesson.id)[0])
        sees(students[2], f"Lesson {lesson.number} · step 1")
    told, heard = everything(teacher), [everything(student) for student in students]
    for lesson in some:
        words = secrets_of(lesson.id)
        assert len(words) > 3 and any(word in told for word in words)
        assert not [word for word in words if any(word in one for one in heard)], lesson.id
    assert ["not the teacher" in one for one in heard] == [False, True, False, False] and "not the teacher" not in told
    with urllib.request.urlopen(opened.url, timeout=60) as page:
        assert "Usually believed" not in page.read().decode()


def test_alone_the_key_opens_the_notes_and_another_one_says_so(house: OpenHouse, come: Come) -> None:
    opened = house(key=KEY)
    assert isinstance(opened.host, PrivateHost)
    teacher, student, mistaken = come(opened, key=KEY), come(opened, "ann"), come(opened, "bo", "key=chal")
    for visitor in (teacher, student, mistaken):
        click(visitor, "Lessons")
        sees(visitor, "Lesson 1 · step 1")
    sees(teacher, "Usually believed")
    mistaken.wait_for(lambda _: "This is not the teacher's key" in everything(mistaken).replace("\\'", "'"), WAIT)
    for visitor in (student, mistaken):
        assert "Usually believed" not in everything(visitor)
    assert "not the teacher" not in everything(student) and "not the teacher" not in everything(teacher)


def test_a_class_answers_on_its_own_devices(house: OpenHouse, come: Come) -> None:
    opened, host, teacher = open_class(house, come)
    ann, bo, cy = (come(opened, name) for name in ("ann", "bo", "cy"))
    screen = come(opened, query="screen=1")
    sees(ann, "Your prediction? Answer here")
    choices = [c.text for c in BOOK.lessons[0].steps[0].question.choices]  # type: ignore[union-attr]
    right = BOOK.lessons[0].steps[0].question.right  # type: ignore[union-attr]
    wrong = (right + 1) % len(choices)
    sees(teacher, "0 answered · 3 not yet", "students here: 3")
    click(ann, f"{wrong + 1} ")
    sees(ann, "You may change it until the reveal.")
    command(bo, f"Answer {wrong + 1}")
    sees(teacher, "2 answered · 1 not yet")
    # Ann changes her mind, and comes back twice; bo's connection is lost.
    click(ann, f"{right + 1} ")
    ann.close()
    ann = come(opened, "ann")
    sees(ann, "You may change it until the reveal.")
    bo.close()
    sees(teacher, "2 answered · 1 not yet", "students here: 2")
    bo = come(opened, "bo")
    sees(teacher, "2 answered · 1 not yet", "students here: 3")
    assert not any("The class sa" in everything(one) for one in (ann, bo, cy, screen))
    assert not any(label[:2] in ("1 ", "● ") for label in labels(screen))
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
    assert not sent and not [label for label in labels(bo) if label.startswith(f"{right + 1} ")]
    # The outcome stands beside the answers, and everybody gets the verdict on their own one.
    ask(host.session, lambda _: host.lessons.act(GoOn()))
    for one in (ann, bo, cy):
        sees(one, "The class said", "Measured", "You said")
    sees(bo, "card wrong duet-say")
    # The stage's verdict is the class's; ann's own one stands beside it.
    ann.wait_for(lambda _: shown(ann).count("card right duet-say") == 2, WAIT)
    # Asked again, everybody answers again.
    click(teacher, "Ask again")
    sees(teacher, "0 answered · 3 not yet")
    sees(bo, "Your prediction? Answer here")
    # The teacher leaves the lessons: nothing is left of the question.
    click(teacher, "Leave the lessons")
    bo.wait_for(lambda v: not [c for c in list(v.mirror.commands.values()) if str(c["label"]).startswith("Answer")], WAIT)


def test_a_student_operates_nothing_but_their_own_answer(house: OpenHouse, come: Come) -> None:
    opened, host, teacher = open_class(house, come)
    ann, bo = come(opened, "ann"), come(opened, "bo")
    sees(bo, "Your prediction? Answer here")
    mine = {e["uuid"] for e in ann.mirror.gui.values() if e["type"] == "GuiButtonMessage"}
    theirs = [e["uuid"] for e in list(teacher.mirror.gui.values()) if e["type"] in ("GuiButtonMessage", "GuiButtonGroupMessage")]
    before = ask(host.session, lambda s: (s.settings, host.room.free, host.room.paused, host.lessons.walk.to_json()))
    for uuid in mine:
        bo.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})
    for uuid in theirs:
        for value in (True, "Explore freely", "Reset step"):
            bo.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})
    for uuid in list(teacher.mirror.commands):
        bo.send({"type": "CommandTriggerMessage", "uuid": uuid})
    click(bo, "1 ")
    sees(teacher, "1 answered · 1 not yet")
    after = ask(host.session, lambda s: (s.settings, host.room.free, host.room.paused, host.lessons.walk.to_json()))
    assert after == before and host.room.ballots.answers_of(f"{b'ann'.hex():0<32}") == {}


def test_two_students_and_a_teacher_do_not_reach_each_other(house: OpenHouse, come: Come) -> None:
    opened, host, teacher = open_class(house, come)
    click(teacher, "Leave the lessons")
    teacher.wait_for(lambda _: not host.lessons.open, WAIT)
    ask(host.session, lambda s: s.change("dm", 0.12))
    ann, bo = come(opened, "ann"), come(opened, "bo")
    choose(teacher, "Explore freely")
    for one in (ann, bo):
        is_sent_away(one)
    ann, bo = come(opened, "ann"), come(opened, "bo")
    a, b = explores(host, ann), explores(host, bo)
    sees(teacher, "exploring: 2")
    sees(ann, "this is your own session")
    # They begin where the teacher is, and see nothing of the stage.
    assert dm_of(opened, host, a) == dm_of(opened, host, b) == 0.12
    assert all(node.get("owner") == str(a) for name, node in ann.mirror.nodes.items() if name.startswith("/arms/"))

    def state(number: int) -> tuple[Any, ...]:
        return ask(host.sessions[number], lambda s: (s.settings, s.paused, s.held))

    stage, his = ask(host.session, lambda s: (s.settings, s.paused, s.held)), state(b)
    ann.set_value("d_m [mm]", 70.0)
    command(ann, "Pause or go on")
    ann.wait_for(lambda _: host.sessions[a].paused and host.sessions[a].settings.run.law.critical_distance == 0.07, WAIT)
    assert state(b) == his and ask(host.session, lambda s: (s.settings, s.paused, s.held)) == stage
    bo.set_value("d_m [mm]", 200.0)
    click(bo, "Lessons")
    bo.wait_for(lambda _: values(host.sessions[b].settings)["scene"] == "solo", WAIT)
    assert state(a)[0].run.law.critical_distance == 0.07 and ask(host.session, lambda s: s.settings) == stage[0]
    ask(host.session, lambda s: s.change("dm", 0.25))
    assert state(a)[0].run.law.critical_distance == 0.07
    # Ann's connection breaks off, and she is back where she was.
    ann.close()
    ann = come(opened, "ann")
    a = explores(host, ann)
    assert dm_of(opened, host, a) == 0.07

    # Follow me: the stage, and nothing of their own.
    choose(teacher, "Follow me")
    for one in (ann, bo):
        is_sent_away(one)
    ann, bo = come(opened, "ann"), come(opened, "bo")
    sees(ann, "You follow the teacher")
    assert host.sessions == {} and not any(e["type"] == "GuiSliderMessage" for e in ann.mirror.gui.values())
    # Released again, each has their own settings, and bo is in his lesson.
    choose(teacher, "Explore freely")
    for one in (ann, bo):
        is_sent_away(one)
    ann, bo = come(opened, "ann"), come(opened, "bo")
    a, b = explores(host, ann), explores(host, bo)
    assert dm_of(opened, host, a) == 0.07
    sees(bo, "Lesson 1 · step 1")
    click(bo, "Leave the lessons")
    bo.wait_for(lambda _: host.sessions[b].settings.run.law.critical_distance == 0.2, WAIT)


def test_explorers_begin_at_the_teachers_step_with_their_own_answers(house: OpenHouse, come: Come) -> None:
    opened, host, teacher = open_class(house, come)
    ann = come(opened, "ann")
    click(ann, "2 ")
    sees(teacher, "1 answered")
    ask(host.session, lambda _: host.lessons.act(GoTo(1, 1)))
    choose(teacher, "Explore freely")
    is_sent_away(ann)
    ann = come(opened, "ann")
    sees(ann, "Lesson 2 · step 2")
    number = explores(host, ann)
    walk = host.participants[number].visitor.lessons.walk  # type: ignore[union-attr]
    assert walk.done_in(BOOK.lessons[0].id, BOOK.lessons[0].steps[0].id).choice == 1


def test_places_are_few_and_a_student_without_one_reads_so(house: OpenHouse, come: Come) -> None:
    opened, host, teacher = open_class(house, come, sessions=1)
    ann, bo, nameless = come(opened, "ann"), come(opened, "bo"), come(opened)
    choose(teacher, "Explore freely")
    is_sent_away(ann)
    ann = come(opened, "ann")
    explores(host, ann)
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


def test_every_button_of_the_teacher_has_a_key_and_the_address_is_on_every_screen_until_it_is_hidden(
    house: OpenHouse, come: Come
) -> None:
    opened, host, teacher = open_class(house, come)
    ann = come(opened, "ann")
    sees(teacher, "students here: 1")
    names = {action: name for name, _, action in COMMANDS}
    address = opened.url.removeprefix("http://") + "/"

    def press(action: str) -> None:
        command(teacher, names[action])

    # The address is the teacher's until it is on every screen.
    sees(teacher, address, "<svg")
    assert address not in everything(ann)
    press("invite")
    sees(ann, "Join the class", address, "QR code")
    click(teacher, "Hide it again")
    ann.wait_for(lambda _: "Join the class" not in shown(ann), WAIT)
    # There is nothing to reveal yet; what comes after it is done after it.
    press("reveal")
    for action, text in (("pause", "The teacher has paused everybody."), ("pause", "You follow the teacher")):
        press(action)
        sees(ann, text)
    command(ann, "Answer 1")
    sees(teacher, "1 answered · 0 not yet")
    for action, text in (("reveal", "The class said"), ("again", "Your prediction? Answer here")):
        press(action)
        sees(ann, text)
    press("free")
    is_sent_away(ann)
    sees(teacher, "exploring: ")
    press("free")
    teacher.wait_for(lambda _: not host.room.free, WAIT)


def test_a_full_lecture_asks_to_wait_but_lets_the_teacher_in(house: OpenHouse, come: Come) -> None:
    opened = house(lecture=True, key=KEY, watchers=2)
    ann, _ = come(opened, "ann"), come(opened, "bob")
    with pytest.raises(urllib.error.HTTPError, match="503") as full:
        urllib.request.urlopen(opened.url, timeout=60)
    assert "2 places" in full.value.read().decode()
    with BlockingClient(opened.url, query="key=wrong") as late:
        late.wait_for(lambda v: v.closed)
        assert late.closed is not None and late.closed.rcvd is not None and late.closed.rcvd.reason == ROOM_IS_FULL
    teacher = come(opened, key=KEY)
    with urllib.request.urlopen(f"{opened.url}/?key={KEY}", timeout=60) as page:
        assert page.status == 200
    teacher.wait_for(lambda _: host_of(opened).operator is not None)
    assert ann.closed is None and teacher.closed is None
