"""A teacher's second tab, over real connections: it has the notes, but no controls until it takes over."""

import pytest

from tests.app.features.lecture.forgery import press_everything_of
from tests.app.features.lecture.lecture_room import KEY, WAIT, Class, Come, banner, sees
from tests.app.features.lecture.test_teachers_notes import BOOK, secrets_of
from tests.app.page.helpers import bodies, buttons, click, shown
from tests.approved import Approve
from tests.blocking_client import BlockingClient

GERMAN = "lang=de"
TAB = "t"
ASSISTS, ASSISTS_IN_GERMAN = "You assist", "Sie assistieren"


@pytest.fixture
def second(classroom: Class, come: Come) -> BlockingClient:
    one = come(classroom.opened, TAB, key=KEY, query=GERMAN)
    sees(one, ASSISTS_IN_GERMAN)
    return one


def leads(second: BlockingClient) -> None:
    """Wait until the German tab no longer assists."""
    second.wait_for(lambda v: ASSISTS_IN_GERMAN not in shown(v), WAIT)


def test_a_second_tab_has_the_notes_but_no_controls(
    classroom: Class, second: BlockingClient, approve: Approve
) -> None:
    first = classroom.teacher
    approve("banner of an assistant.txt", banner(second))
    sees(second, "Lektion 1", secrets_of(BOOK.lessons[0].id)[0])
    assert "Take over" not in buttons(first) and ASSISTS not in shown(first)
    assert not bodies(second, "GuiButtonGroupMessage") and not second.mirror.commands
    assert "Alle anhalten" not in buttons(second)


def test_teachers_controls_forged_by_a_student_have_no_effect(
    classroom: Class, second: BlockingClient
) -> None:
    host, (ann,) = classroom.host, classroom.come("ann")
    led = host.controls.operator
    for owner in (classroom.teacher, second):
        press_everything_of(owner, ann)
    click(ann, "2 ")
    sees(classroom.teacher, "1 answered")
    assert host.controls.operator is led is not None
    assert not host.classroom.paused and not host.classroom.free


def test_a_second_tab_takes_over_and_the_first_takes_over_again(
    classroom: Class, second: BlockingClient
) -> None:
    host, first, (ann,) = classroom.host, classroom.teacher, classroom.come("ann")
    led = host.controls.operator
    click(second, "Übernehmen")
    sees(first, ASSISTS)
    second.wait_for(lambda _: host.controls.operator not in (None, led), WAIT)
    leads(second)
    assert first.closed is None and "Pause everybody" not in buttons(first)
    click(second, "Alle anhalten")
    sees(ann, "paused everybody")
    click(first, "Take over")
    sees(second, ASSISTS_IN_GERMAN)
    click(first, "Continue for everybody")
    sees(ann, "You follow the teacher")


def test_a_copy_of_the_leading_tab_leads_until_it_closes(
    classroom: Class, second: BlockingClient, come: Come
) -> None:
    first = classroom.teacher
    click(second, "Übernehmen")
    leads(second)
    doubled = come(classroom.opened, TAB, key=KEY, query=GERMAN)
    sees(second, ASSISTS_IN_GERMAN)
    doubled.wait_for(lambda v: v.mirror.grabbable or bodies(v, "GuiButtonGroupMessage"), WAIT)
    assert ASSISTS_IN_GERMAN not in shown(doubled)
    doubled.close()
    first.wait_for(lambda _: ASSISTS not in shown(first) or ASSISTS_IN_GERMAN not in shown(second), WAIT)
