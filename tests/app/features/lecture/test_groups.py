"""More students than places, over real connections: a group shares one session, with one operator."""

import pytest

from app.features.lecture import breakout_sessions
from tests.app.conftest import OpenHouse, ask
from tests.app.features.lecture.forgery import press_everything_of, wait_until_all_has_come
from tests.app.features.lecture.lecture_room import (
    WAIT,
    Class,
    Come,
    banner,
    choose,
    command,
    drawn_name,
    sees,
    sessions_of,
)
from tests.app.page.helpers import bodies, buttons, click, shown
from tests.approved import Approve

pytestmark = pytest.mark.thorough

GERMAN = "lang=de&theme=dark"
OPERATES = "You operate it."
WATCHES = "has control"
"""Part of the text on a watching member's page."""


@pytest.fixture
def room(house: OpenHouse, come: Come) -> Class:
    """A class of three students with one place for a session."""
    return Class(house, come, sessions=1, students=3)


@pytest.fixture
def group(room: Class) -> Class:
    """One group: ann operates; cy watches, and bo in German."""
    room.explore("ann", "bo", "cy")
    room.come("ann")
    room.number("ann")
    room.come("bo", query=GERMAN)
    (cy,) = room.come("cy")
    sees(cy, WATCHES, "Lesson 1 · step 1")
    return room


def takes_over(group: Class, name: str, operator: str) -> None:
    """Make a member the operator; both pages reconnect."""
    click(group.students[name], "Take over")
    for one in (name, operator):
        group.is_sent_away(one)
    group.come(name, operator)


def test_three_students_share_a_session_and_the_first_one_operates_it(
    room: Class, come: Come, approve: Approve
) -> None:
    sees(room.teacher, "groups of 3")
    room.come("bo", query=GERMAN)
    room.come("ann", "cy")
    nameless = come(room.opened)
    choose(room.teacher, "Explore freely")
    for name in ("ann", "bo", "cy"):
        room.is_sent_away(name)
    (ann,) = room.come("ann")
    room.number("ann")
    sees(ann, "this is your own session")
    (bo,), (cy,) = room.come("bo", query=GERMAN), room.come("cy")
    sees(ann, "You are 3 at this robot", OPERATES, "Lesson 1 · step 1")
    sees(bo, "Sie sind zu 3", "Lektion 1", 'data-words="de"')
    # On a phone the page keeps room for a watcher's button.
    sees(cy, WATCHES, "Lesson 1 · step 1", 'class="duet-banner own watches duet-say"')
    sees(nameless, "Your browser blocks")
    name = drawn_name(ann)
    approve(
        "banners of a group.txt", "".join(banner(one).replace(name, "…") for one in (ann, bo, cy, nameless))
    )
    sees(room.teacher, "exploring: 3", "without a place: 1", "groups of 4", f"{drawn_name(ann)} × 3")
    assert drawn_name(cy) == drawn_name(ann) in shown(bo) and len(sessions_of(room.host)) == 1


def test_a_watching_member_sees_the_answer_but_cannot_change_anything(group: Class) -> None:
    ann, _, cy = (group.students[name] for name in ("ann", "bo", "cy"))
    session = group.session_of("ann")
    click(ann, "2 ")
    for one in (ann, cy):
        sees(one, "Your prediction")
    assert not bodies(cy, "GuiSliderMessage") and not cy.mirror.grabbable and "Take over" not in buttons(ann)

    def state() -> tuple[object, ...]:
        return ask(session, lambda s: (s.settings, s.paused, s.held, s.simulation.steps))

    before = state()
    press_everything_of(ann, cy)
    wait_until_all_has_come(group.opened, cy)
    assert state() == before


def test_a_paused_group_ignores_its_operators_run_commands(group: Class) -> None:
    (ann, cy), session = (group.students[name] for name in ("ann", "cy")), group.session_of("ann")
    click(ann, "2 ")
    sees(ann, "Your prediction")
    steps = ask(session, lambda s: s.simulation.steps)
    click(group.teacher, "Pause everybody")
    for one in (ann, cy):
        sees(one, "paused everybody")
    for wish in ("Pause or continue", "One single step", "Slower"):
        command(ann, wish)
    ann.wait_for(lambda _: session.settings.page.speed == 0.5, WAIT)
    assert ask(session, lambda s: s.simulation.steps) == steps
    assert session.paused and group.host.session.paused
    click(group.teacher, "Continue for everybody")
    sees(ann, OPERATES)


def test_a_new_operator_keeps_the_session_and_any_member_can_hand_in(group: Class) -> None:
    ann, bo, session = group.students["ann"], group.students["bo"], group.session_of("ann")
    click(ann, "2 ")
    sees(ann, "Your prediction")
    command(ann, "Slower")
    ann.wait_for(lambda _: session.settings.page.speed == 0.5, WAIT)
    takes_over(group, "cy", "ann")
    ann = group.students["ann"]
    assert group.session_of("cy") is session
    sees(ann, WATCHES)
    bo.wait_for(lambda _: bo.closed is None and "Mitglied Ihrer Gruppe" in shown(bo), WAIT)
    assert session.settings.page.speed == 0.5
    # Ann hands in, although cy is the operator.
    click(ann, "Hand in")
    sees(group.teacher, "reports handed in: 1")
    (report,) = group.host.classroom.work.hand_ins.values()
    assert '"choice": 1' in report.progress


def test_late_and_returning_members_join_the_group(group: Class) -> None:
    cy, bo = group.students["cy"], group.students["bo"]
    bo.close()
    sees(cy, "You are 2 at this robot")
    group.come("di")
    group.is_sent_away("di")
    (di,) = group.come("di")
    (bo,) = group.come("bo", query="lang=de")
    sees(di, "You are 4 at this robot", WATCHES)
    sees(bo, "Sie sind zu 4")


def test_the_oldest_page_replaces_an_operator_who_left(group: Class, monkeypatch: pytest.MonkeyPatch) -> None:
    session = group.session_of("ann")
    monkeypatch.setattr(breakout_sessions, "AWAY", 1.0)
    group.students["ann"].close()
    group.is_sent_away("bo")
    (bo,) = group.come("bo")
    assert group.session_of("bo") is session
    sees(bo, OPERATES)


def test_a_recalled_group_continues_together_in_its_lesson(group: Class) -> None:
    click(group.students["ann"], "2 ")
    sees(group.students["cy"], "Your prediction")
    group.students["bo"].close()
    ann, cy = group.send("Follow me", "ann", "cy")
    sees(cy, "You follow the teacher")
    sees(group.teacher, "students here: 2")
    cy, ann = group.send("Explore freely", "cy", "ann")
    for one in (ann, cy):
        sees(one, "You are 2 at this robot", "Lesson 1 · step 1", "Your prediction")
