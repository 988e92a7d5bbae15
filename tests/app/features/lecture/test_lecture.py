"""The class on the wire: a teacher and students who speak viser's protocol, together in one lecture."""

import html
import urllib.error
import urllib.request
from typing import Any
from urllib.parse import quote

import pytest

from app.features.lecture import breakout_sessions
from app.features.lecture.presenter_keys import CLICKER_KEYS
from app.features.lecture.teacher_panel import COMMANDS
from app.features.lessons.library import notes_of
from app.features.lessons.session.lesson_actions import Choose, GoTo, Press
from app.page.panels.choice_buttons import MARK
from app.start import App
from app.web.headless_client import CAMERA, Mirror
from app.web.pages import HELLO, ROOM_IS_FULL, TAKEN_OVER
from app.web.server import MOVED_CODE
from scenes.settings import values
from tests.app.conftest import Join, OpenHouse, ask
from tests.app.features.lecture.lecture_room import (
    KEY,
    WAIT,
    Class,
    Come,
    choose,
    command,
    drawn_name,
    lecture_of,
    sees,
    sessions_of,
    tab_of,
)
from tests.app.features.lessons.helpers import lessons_of, our_book
from tests.app.page.helpers import bodies, buttons, click, open_lessons, shown
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

BOOK = our_book()
NOTES = notes_of(BOOK)


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
        tab = f"resume={tab_of(name)}" if name else ""
        return join(house, "&".join(part for part in (tab, query, key and f"key={quote(key)}") if part))

    return make


def secrets_of(lesson: str) -> list[str]:
    """Words that stand in the notes to a lesson and in nothing that students read."""
    lines = [line.strip() for line in NOTES[lesson].splitlines() if len(line.split()) > 5]
    return [" ".join(line.split(" ")[1:5]) for line in lines if not set(line) & set("#*`$“”")] + [
        "Usually believed",
        "Watch out",
    ]


@pytest.mark.thorough
def test_only_the_key_opens_the_notes_and_a_wrong_one_is_named(house: OpenHouse, come: Come) -> None:
    classroom = Class(house, come)
    opened, host, teacher = classroom.opened, classroom.host, classroom.teacher
    students = [*classroom.come("ann"), come(opened, "bo", "key=chal"), come(opened, query="screen=1")]
    students += classroom.send("Explore freely", "ann")
    some = [BOOK.lessons[i] for i in (5, 0)]
    for lesson in some:
        ask(host.session, lambda _, lesson=lesson: host.lessons.act(GoTo(lesson.number, 0)))
        sees(teacher, secrets_of(lesson.id)[0])
        sees(students[2], f"Lesson {lesson.number} · step 1")
    students[1].wait_for(lambda _: "not the teacher" in everything(students[1]), WAIT)
    sent, heard = everything(teacher), [everything(student) for student in students]
    for lesson in some:
        words = secrets_of(lesson.id)
        assert len(words) > 3 and any(word in sent for word in words)
        assert not [word for word in words if any(word in one for one in heard)], lesson.id
    assert ["not the teacher" in one for one in heard] == [
        False,
        True,
        False,
        False,
    ] and "not the teacher" not in sent
    # The key is the teacher's: it is on no page.
    assert not any("chalk" in one or quote(KEY) in one for one in (sent, *heard))
    with urllib.request.urlopen(opened.url, timeout=60) as page:
        assert "Usually believed" not in page.read().decode()


def test_alone_the_key_opens_the_notes_and_another_one_says_so(house: OpenHouse, come: Come) -> None:
    opened = house(key=KEY)
    teacher, bo = come(opened, key=KEY), come(opened, "bo", "key=chal")
    for visitor in (teacher, bo):
        open_lessons(visitor)
        sees(visitor, "Lesson 1 · step 1")
    sees(teacher, "Usually believed")
    bo.wait_for(lambda _: "This is not the teacher's key" in everything(bo).replace("\\'", "'"), WAIT)
    assert "not the teacher" not in everything(teacher) and "Usually believed" not in everything(bo)


def test_a_class_answers_on_its_own_devices_and_every_button_of_the_teacher_has_a_key(
    house: OpenHouse, come: Come
) -> None:
    classroom = Class(house, come)
    host, teacher, (ann, bo, cy) = classroom.host, classroom.teacher, classroom.come("ann", "bo", "cy")
    names = {action: name for name, _, action in COMMANDS}
    # There is nothing to reveal yet; what comes after it is done after it.
    command(teacher, names["reveal"])
    for action, text in (("pause", "The teacher has paused everybody."), ("pause", "You follow the teacher")):
        command(teacher, names[action])
        sees(ann, text)
    screen = come(classroom.opened, query="screen=1")
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
    (ann,) = classroom.come("ann")
    sees(ann, "You may change it until the reveal.")
    bo.close()
    sees(teacher, "2 answered · 1 not yet", "students here: 2")
    (bo,) = classroom.come("bo")
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
    sent = ask(host.session, lambda _: host.classroom.answer(host.lessons.walk, "bo", right))
    assert not sent and not [label for label in buttons(bo) if label.startswith(f"{right + 1} ")]
    # The outcome stands beside the answers, and everybody gets the verdict on their own one.
    ask(host.session, lambda _: host.lessons.act(Press("next")))
    for one in (ann, bo, cy):
        sees(one, "The class said", "Measured", "You said")
    sees(bo, "card wrong duet-say")
    # The stage's verdict is the class's; ann's own one stands beside it.
    ann.wait_for(lambda _: shown(ann).count("card right duet-say") == 2, WAIT)
    # Asked again, everybody answers again, and both rounds are shown.
    click(teacher, "Ask again")
    sees(teacher, "0 answered · 3 not yet", "Round 1", "Round 2")
    command(teacher, names["reveal"])
    sees(bo, "Asked again", "Your first answer:")
    assert "Round 1" not in everything(bo)
    for one in (ann, bo, cy):
        click(one, f"{right + 1} ")
    sees(teacher, "another answer the second time: 1.")
    command(teacher, names["reveal"])
    for one in (bo, screen):
        sees(one, "Round 1", "Round 2", "another answer the second time: 1.")
    command(teacher, names["again"])
    sees(bo, "Asked again", "Your first answer:")
    # The teacher leaves the lessons: nothing is left of the question.
    click(teacher, "Leave the lessons")
    click(teacher, "Leave with the class")
    bo.wait_for(
        lambda v: not [c for c in list(v.mirror.commands.values()) if str(c["label"]).startswith("Answer")],
        WAIT,
    )
    # An own session has the look of the student's link.
    ask(host.session, lambda s: s.change("theme", "dark"))
    for one in (bo, cy):
        one.close()
    di = come(classroom.opened, "di", query="lang=sl")
    command(teacher, names["free"])
    assert ended(di)[0] == MOVED_CODE
    classroom.students["di"] = come(classroom.opened, "di", query="lang=sl")
    page = sessions_of(host)[classroom.number("di")].settings.page
    assert (page.language, page.theme) == ("sl", "light")
    command(teacher, names["free"])
    teacher.wait_for(lambda _: not host.classroom.free, WAIT)


def test_votes_of_a_program_without_a_page_are_seen_and_can_be_left_out(house: OpenHouse, come: Come) -> None:
    classroom = Class(house, come)
    host, teacher, pages = classroom.host, classroom.teacher, classroom.come("ann", "bo")
    for page in pages:
        page.send({"type": HELLO})
        click(page, "1 ")
    programs = classroom.come(*(f"program {number}" for number in range(3)))
    for program in programs:
        click(program, "2 ")
    sees(teacher, "5 answered · 0 not yet", "votes: 5", "addresses: 1", "votes without a page: 3")
    click(teacher, "Leave out votes without a page")
    sees(teacher, "2 answered · 0 not yet", "votes without a page: 3")
    # One that votes later and goes at once is left out, too.
    (late,) = classroom.come("late")
    click(late, "2 ")
    late.close()
    sees(teacher, "2 answered · 0 not yet", "votes without a page: 4")
    assert ask(host.session, lambda _: host.summaries()[0].asked[0].rounds[0].counts[:2]) == (2, 0)
    click(teacher, "Count votes without a page")
    sees(teacher, "6 answered · 0 not yet")
    click(teacher, "Leave out votes without a page")
    sees(teacher, "2 answered · 0 not yet")
    click(teacher, "Reveal to everybody")
    sees(pages[0], "The class said", "2 answered")
    assert host.lessons.walk.done.choice == 0
    # A program sees no more of it than a page.
    assert not any("without a page" in everything(one) for one in (*pages, *programs))


def test_two_students_and_a_teacher_do_not_reach_each_other(house: OpenHouse, come: Come) -> None:
    classroom = Class(house, come)
    host, teacher = classroom.host, classroom.teacher
    click(teacher, "Leave the lessons")
    click(teacher, "Leave with the class")
    teacher.wait_for(lambda _: not host.lessons.open, WAIT)
    ask(host.session, lambda s: s.change("dm", 0.12))
    classroom.come("ann", "bo")
    ann, bo = classroom.send("Explore freely", "ann", "bo")
    a, b = classroom.number("ann"), classroom.number("bo")
    sees(teacher, "exploring: 2")
    sees(ann, "this is your own session")
    # They begin where the teacher is, and see nothing of the stage.
    assert classroom.critical_distance("ann") == classroom.critical_distance("bo") == 0.12
    assert all(
        node.get("owner") == str(a)
        for name, node in list(ann.mirror.nodes.items())
        if name.startswith("/arms/")
    )

    def state(number: int | None = None) -> tuple[Any, ...]:
        session = host.session if number is None else sessions_of(host)[number]
        return ask(session, lambda s: (s.settings, s.paused, s.held))

    stage, his = state(), state(b)
    ann.set_value("critical distance d_m [mm]", 70.0)
    command(ann, "Pause or go on")
    ann.wait_for(
        lambda _: (
            sessions_of(host)[a].paused and sessions_of(host)[a].settings.run.law.critical_distance == 0.07
        ),
        WAIT,
    )
    assert state(b) == his and state() == stage
    bo.set_value("critical distance d_m [mm]", 200.0)
    open_lessons(bo)
    bo.wait_for(lambda _: values(sessions_of(host)[b].settings)["scene"] == "solo", WAIT)
    assert classroom.critical_distance("ann") == 0.07 and state() == stage
    ask(host.session, lambda s: s.change("dm", 0.25))
    assert classroom.critical_distance("ann") == 0.07
    # Ann's connection breaks off, and she is back where she was.
    ann.close()
    classroom.come("ann")
    assert classroom.critical_distance("ann") == 0.07
    # Follow me: the stage, and nothing of their own.
    ann, bo = classroom.send("Follow me", "ann", "bo")
    sees(ann, "You follow the teacher")
    # Bo's earlier connection may end later than ann's.
    ann.wait_for(lambda _: sessions_of(host) == {}, WAIT)
    assert not bodies(ann, "GuiSliderMessage")
    # Released again, each has their own settings, and bo is in his lesson.
    ann, bo = classroom.send("Explore freely", "ann", "bo")
    assert classroom.critical_distance("ann") == 0.07
    sees(bo, "Lesson 1 · step 1")
    b = classroom.number("bo")
    click(bo, "Leave the lessons")
    bo.wait_for(lambda _: sessions_of(host)[b].settings.run.law.critical_distance == 0.2, WAIT)


@pytest.mark.thorough
def test_more_students_than_places_explore_in_groups_of_which_one_operates(
    house: OpenHouse, come: Come, monkeypatch: pytest.MonkeyPatch
) -> None:
    classroom = Class(house, come, sessions=1, students=3)
    host, teacher = classroom.host, classroom.teacher
    sees(teacher, "3 students, room for 1: groups of 3")
    classroom.students["bo"] = come(classroom.opened, "bo", query="lang=de&theme=dark")
    classroom.come("ann", "cy")
    nameless = come(classroom.opened)
    choose(teacher, "Explore freely")
    for name in ("ann", "bo", "cy"):
        classroom.is_sent_away(name)
    (ann,) = classroom.come("ann")
    number = classroom.number("ann")
    sees(ann, "this is your own session")
    bo = classroom.students["bo"] = come(classroom.opened, "bo", query="lang=de&theme=dark")
    (cy,) = classroom.come("cy")
    # All see the one session, each in their own language; who came first operates it.
    sees(ann, "You are 3 at this robot, and answer together. You operate it.", "Lesson 1 · step 1")
    sees(bo, "Sie sind zu 3 an diesem Roboter", "Lektion 1", 'data-words="de"')
    # On a phone the page leaves room for the button of who watches.
    sees(
        cy,
        "Another member of your group has control.",
        "Lesson 1 · step 1",
        'class="duet-banner own watches duet-say"',
    )
    sees(nameless, "Your browser blocks storage")
    sees(teacher, "exploring: 3", "without a place: 1", "groups of 4", f"{drawn_name(ann)} × 3")
    assert drawn_name(cy) == drawn_name(ann) in shown(bo) and len(sessions_of(host)) == 1
    session = sessions_of(host)[number]
    click(ann, "2 ")
    for one in (ann, cy):
        sees(one, "Your prediction")
    # Who watches has nothing to operate, and what belongs to another page does nothing.
    assert not bodies(cy, "GuiSliderMessage") and not cy.mirror.grabbable and "Take over" not in buttons(ann)
    steps = ask(session, lambda s: s.simulation.steps)
    for uuid in (*ann.mirror.commands, *(one["uuid"] for one in list(ann.mirror.gui.values()))):
        cy.send({"type": "CommandTriggerMessage", "uuid": uuid})
        cy.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})
    # A class paused stands still, and goes on.
    click(teacher, "Pause everybody")
    for one in (ann, cy):
        sees(one, "The teacher has paused everybody.")
    for wish in ("Pause or go on", "One single step", "Slower"):
        command(ann, wish)
    ann.wait_for(lambda _: session.settings.page.speed == 0.5, WAIT)
    assert ask(session, lambda s: s.simulation.steps) == steps and session.paused and host.session.paused
    click(teacher, "Let everybody go on")
    sees(ann, "You operate it.")
    # Another one takes over, with the same session; who operated it watches.
    click(cy, "Take over")
    for name in ("ann", "cy"):
        classroom.is_sent_away(name)
    cy, ann = classroom.come("cy", "ann")
    assert sessions_of(host)[classroom.number("cy")] is session
    sees(ann, "Another member of your group has control.")
    cy.wait_for(
        lambda _: bo.closed is None and "Ein anderes Mitglied Ihrer Gruppe steuert." in shown(bo), WAIT
    )
    assert session.settings.page.speed == 0.5
    # Their report is everybody's: ann hands it in, though cy operates.
    click(ann, "Hand in")
    sees(teacher, "reports handed in: 1")
    (report,) = host.classroom.work.hand_ins.values()
    assert '"choice": 1' in report.progress
    # A member who closes the tab comes back to the same group, and one who comes late is in it, too.
    bo.close()
    sees(cy, "You are 2 at this robot")
    (di,) = classroom.come("di")
    classroom.is_sent_away("di")
    (di,) = classroom.come("di")
    bo = come(classroom.opened, "bo", query="lang=de")
    sees(di, "You are 4 at this robot", "Another member of your group")
    sees(bo, "Sie sind zu 4 an diesem Roboter")
    # The one who operates goes for good: after a while the page that was there first comes again, and does.
    monkeypatch.setattr(breakout_sessions, "AWAY", 1.0)
    cy.close()
    classroom.is_sent_away("ann")
    (ann,) = classroom.come("ann")
    assert sessions_of(host)[classroom.number("ann")] is session
    sees(ann, "You operate it.")
    # Called back and sent again they are together again.
    bo.close()
    ann, di = classroom.send("Follow me", "ann", "di")
    sees(di, "You follow the teacher")
    sees(teacher, "students here: 3")
    di, ann = classroom.send("Explore freely", "di", "ann")
    sees(ann, "You are 2 at this robot")
    sees(di, "You are 2 at this robot", "Lesson 1 · step 1", "Your prediction")


def test_a_teachers_second_tab_assists_until_it_takes_over(house: OpenHouse, come: Come) -> None:
    classroom = Class(house, come)
    host, first, (ann,) = classroom.host, classroom.teacher, classroom.come("ann")
    second = come(classroom.opened, "t", key=KEY, query="lang=de")
    sees(second, "Sie assistieren", "Lektion 1", secrets_of(BOOK.lessons[0].id)[0])
    assert "Take over" not in buttons(first) and "You assist" not in shown(first)
    # The second one has nothing to lead with; a student has neither, and what belongs to a teacher's page does nothing there.
    assert (
        not bodies(second, "GuiButtonGroupMessage")
        and "Pause everybody" not in buttons(second)
        and not second.mirror.commands
    )
    for uuid in [one["uuid"] for page in (first, second) for one in list(page.mirror.gui.values())]:
        ann.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})
    click(ann, "2 ")
    sees(first, "1 answered")
    assert host.controls.operator is not None and not host.classroom.paused
    led = host.controls.operator
    click(second, "Übernehmen")
    sees(first, "You assist: another tab of the teacher leads.")
    second.wait_for(
        lambda _: host.controls.operator not in (None, led) and "Sie assistieren" not in shown(second), WAIT
    )
    assert first.closed is None and "Pause everybody" not in buttons(first)
    click(second, "Alle anhalten")
    sees(ann, "The teacher has paused everybody.")
    # And back; a third one, doubled from the tab that leads, takes the lead from it at once, and both say so.
    click(first, "Take over")
    sees(second, "Sie assistieren")
    click(first, "Let everybody go on")
    sees(ann, "You follow the teacher")
    click(second, "Übernehmen")
    second.wait_for(lambda _: "Sie assistieren" not in shown(second), WAIT)
    doubled = come(classroom.opened, "t", key=KEY, query="lang=de")
    sees(second, "Sie assistieren")
    doubled.wait_for(lambda v: v.mirror.grabbable or bodies(v, "GuiButtonGroupMessage"), WAIT)
    assert "Sie assistieren" not in shown(doubled)
    # Who leads goes: another tab leads.
    doubled.close()
    first.wait_for(lambda _: "You assist" not in shown(first) or "Sie assistieren" not in shown(second), WAIT)


def have_no_clicker(classroom: Class, keyed: BlockingClient, others: list[BlockingClient]) -> None:
    """A projector with the key has a clicker, and no other control; what belongs to it and to the teacher's page does nothing elsewhere."""
    host, teacher = classroom.host, classroom.teacher
    assert (
        len(keyed.mirror.commands) == len(CLICKER_KEYS)
        and not bodies(keyed, "GuiButtonMessage")
        and not keyed.mirror.grabbable
    )
    commands = [*teacher.mirror.commands, *keyed.mirror.commands]
    elements = [
        (e["uuid"], o) for e in bodies(teacher, "GuiButtonGroupMessage") for o in e.get("options", ())
    ]
    for kind, value in (("GuiButtonMessage", True), ("GuiTextMessage", "2"), ("GuiNumberMessage", 60)):
        elements += [(e["uuid"], value) for e in bodies(teacher, kind)]

    def state(_: object) -> tuple[object, ...]:
        shown, group = host.control.presenter, host.classroom
        covers = (
            shown.station,
            shown.blank,
            shown.frozen,
            shown.panels,
            shown.left,
            shown.work,
            shown.quotes,
            shown.inviting,
        )
        return (*covers, shown.expected, group.pace, group.wanted, group.paused)

    before = ask(host.session, state)
    for k, one in enumerate(others):
        assert not [c for c in list(one.mirror.commands.values()) if "screen" in str(c["label"])]
        for uuid in commands:
            one.send({"type": "CommandTriggerMessage", "uuid": uuid})
        for uuid, value in elements:
            one.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})
        # The camera is everybody's own: once it has arrived, all of the above has, too.
        one.send(CAMERA | {"image_height": 500, "image_width": 700 + k})
        one.wait_for(
            lambda _, k=k: any(
                c.camera.image_width == 700 + k for c in classroom.opened.server.get_clients().values()
            )
        )
    assert ask(host.session, state) == before
    for one in others[1:]:
        one.close()


def test_the_address_ends_everywhere_and_only_a_screen_with_the_key_has_a_clicker(
    house: OpenHouse, come: Come
) -> None:
    classroom = Class(house, come)
    teacher, invite = classroom.teacher, next(name for name, _, action in COMMANDS if action == "invite")
    address = classroom.opened.url.removeprefix("http://") + "/"
    (ann,) = classroom.come("ann")

    def inviting(*pages: BlockingClient) -> bool:
        return all("Join the class" in shown(one) for one in pages)

    def no_longer(**pages: BlockingClient) -> None:
        for name, one in pages.items():
            try:
                one.wait_for(lambda _, one=one: not inviting(one), WAIT)
            except TimeoutError as error:
                where = classroom.host.control.presenter.inviting
                raise AssertionError(
                    f"the page of {name} keeps the address, which is asked for on {where!r} pages"
                ) from error

    # In the tab it is the teacher's; without a projector the teacher's page is the screen.
    sees(teacher, "students here: 1", address, "<svg")
    command(teacher, invite)
    sees(teacher, "Join the class", "the address is on the screen")
    command(teacher, invite)
    no_longer(teacher=teacher)
    screen = come(classroom.opened, query=f"screen=1&key={quote(KEY)}")
    sees(teacher, "screens: 1")
    choose(teacher, "On the screen")
    sees(screen, "Join the class", address, "QR code")
    # It is no part of the picture, which may be frozen.
    command(teacher, "Class: the screen frozen, or live")
    sees(teacher, "the screen is frozen")
    command(screen, "Class: the address away")
    no_longer(screen=screen)
    assert classroom.host.control.presenter.frozen
    assert (
        "Join the class" not in everything(ann) and address not in everything(ann) and not inviting(teacher)
    )
    have_no_clicker(
        classroom,
        screen,
        [ann, *(come(classroom.opened, query=f"screen=1{key}") for key in ("", "&key=chal"))],
    )
    # On every page; one that opens later does not get it, but the next time.
    choose(teacher, "On every page")
    for one in (teacher, screen, ann):
        sees(one, "Join the class", address, "QR code")
    (bo,) = classroom.come("bo")
    sees(bo, "You follow the teacher")
    sees(teacher, "students here: 2", "the address is on every page")
    command(teacher, "Class: the next thing on the screen")
    no_longer(teacher=teacher, screen=screen, ann=ann)
    assert not classroom.host.control.presenter.frozen and "Join the class" not in everything(bo)
    choose(teacher, "On every page")
    sees(bo, "Join the class")
    sees(teacher, "the address is on every page")
    (row,) = (row["uuid"] for row in bodies(teacher, "GuiButtonGroupMessage") if "Nowhere" in row["options"])
    # The page has not been sent yet that the mark is elsewhere; nothing else counts as a press.
    for value in ("On every screen", "", f"{MARK}Nowhere"):
        teacher.send({"type": "GuiUpdateMessage", "uuid": row, "updates": {"value": value}})
    no_longer(teacher=teacher, screen=screen, ann=ann, bo=bo)
    assert teacher.closed is None


def test_a_student_hands_in_from_one_tab_at_a_time_on_the_stage_and_in_an_own_session(
    house: OpenHouse, come: Come
) -> None:
    classroom = Class(house, come)
    teacher, work, (ann, bo) = classroom.teacher, classroom.host.classroom.work, classroom.come("ann", "bo")
    ids = {name: tab_of(name) for name in ("ann", "bo")}
    assert "Hand in" not in buttons(ann), "there is nothing to hand in"

    def doubled(first: BlockingClient) -> BlockingClient:
        """A second tab takes the place of the first one."""
        (second,) = classroom.come("ann")
        assert ended(first)[1] == TAKEN_OVER
        return second

    click(ann, "2 ")
    sees(teacher, "1 answered · 1 not yet")
    sees(ann, "The teacher gets what is in your lab report")
    ann.set_value("Name", " Ann\n=1 ")
    click(ann, "Hand in")
    sees(ann, "Handed in as Ann =1.")
    sees(teacher, "reports handed in: 1")
    assert "Hand in" not in buttons(bo) and "Ann =1" not in everything(bo)
    ann = doubled(ann)
    sees(ann, "You may change it until the reveal.", "Handed in as Ann =1.")
    sees(teacher, "1 answered · 1 not yet", "students here: 2")
    # In a session of her own, at the teacher's step and with her own answer, she finds it handed in, and so does her next tab.
    ask(classroom.host.session, lambda _: classroom.host.lessons.act(GoTo(2, 1)))
    ann, bo = classroom.send("Explore freely", "ann", "bo")
    sees(ann, "Handed in as Ann =1.")
    classroom.number("ann")
    ann = doubled(ann)
    sees(ann, "this is your own session", "Lesson 2 · step 2", "Handed in as Ann =1.")
    sees(teacher, "students here: 2")
    visitor = classroom.host.participants[classroom.number("ann")].visitor
    assert visitor is not None
    assert lessons_of(visitor).walk.done_in(BOOK.lessons[0].id, BOOK.lessons[0].steps[0].id).choice == 1
    # She goes on, and hands it in again, without a name.
    ask(visitor.session, lambda _: [lessons_of(visitor).act(GoTo(4, 1)), lessons_of(visitor).act(Choose(1))])
    click(ann, "Hand in again")
    sees(ann, "Handed in without a name.")
    assert (
        '"choice": 1' in work.hand_ins[ids["ann"]].progress and "lambda" in work.hand_ins[ids["ann"]].progress
    )
    # Bo does something there, and hands it in from the stage.
    his = classroom.host.participants[classroom.number("bo")].visitor
    assert his is not None
    ask(his.session, lambda _: lessons_of(his).act(Choose(0)))
    ann, bo = classroom.send("Follow me", "ann", "bo")
    click(bo, "Hand in")
    sees(bo, "Handed in without a name.")
    assert '"choice": 0' in work.hand_ins[ids["bo"]].progress
    sees(teacher, "reports handed in: 2")
    click(ann, "Take it back")
    teacher.wait_for(lambda _: set(work.hand_ins) == {ids["bo"]}, WAIT)
    sees(teacher, "reports handed in: 1")
    # Of projectors and teachers there may be several.
    screens = [come(classroom.opened, "s", query="screen=1") for _ in range(2)]
    teachers = [come(classroom.opened, "t", key=KEY) for _ in range(2)]
    sees(teacher, "screens: 2")
    assert all(one.closed is None for one in (ann, *screens, *teachers))


def test_a_full_lecture_asks_to_wait_but_lets_the_teacher_in(house: OpenHouse, come: Come) -> None:
    opened = house(lecture=True, key=KEY, watchers=2)
    ann, _ = come(opened, "ann"), come(opened, "bob")
    host = lecture_of(opened)
    # Both see the stage, which takes no place yet.
    ann.wait_for(lambda _: host.session.simulation.time > 0.3 and opened.server.count_clients() == 2)
    assert host.controls.operator is None
    with pytest.raises(urllib.error.HTTPError, match="503") as full:
        urllib.request.urlopen(opened.url, timeout=60)
    assert "2 places" in full.value.read().decode()
    with BlockingClient(opened.url, query="key=wrong") as late:
        assert ended(late)[1] == ROOM_IS_FULL
    teacher = come(opened, key=KEY)
    with urllib.request.urlopen(f"{opened.url}/?key={quote(KEY)}", timeout=60) as page:
        assert page.status == 200
    teacher.wait_for(lambda _: host.controls.operator is not None)
    assert ann.closed is None and teacher.closed is None
