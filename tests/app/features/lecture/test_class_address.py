"""The address of the class over real connections: shown, hidden; and the clicker of a projector."""

import pytest

from app.features.lecture.lecture import LectureHost
from app.features.lecture.presenter_keys import CLICKER_KEYS
from app.page.panels.choice_buttons import MARK
from app.session.session import Session
from tests.app.conftest import ask
from tests.app.features.lecture.forgery import press_everything_of, wait_until_all_has_come
from tests.app.features.lecture.lecture_room import (
    BY_KEY,
    KEY,
    WAIT,
    Class,
    Come,
    choose,
    command,
    everything,
    sees,
)
from tests.app.page.helpers import bodies, shown
from tests.blocking_client import BlockingClient

INVITED = "Join the class"
ON_EVERY_PAGE = "On every page"


@pytest.fixture
def address(classroom: Class) -> str:
    return classroom.opened.url.removeprefix("http://") + "/"


@pytest.fixture
def screen(classroom: Class) -> BlockingClient:
    """A projector with the teacher's key."""
    one = classroom.screen(KEY)
    sees(classroom.teacher, "screens: 1")
    return one


def no_longer(*pages: BlockingClient) -> None:
    """Wait until no page shows the address over its scene."""
    for one in pages:
        one.wait_for(lambda v: INVITED not in shown(v), WAIT)


def test_without_a_projector_the_teachers_page_is_the_screen(classroom: Class, address: str) -> None:
    teacher = classroom.teacher
    sees(teacher, address, "<svg")
    assert INVITED not in shown(teacher)
    command(teacher, BY_KEY["invite"])
    sees(teacher, INVITED, "is on the screen")
    command(teacher, BY_KEY["invite"])
    no_longer(teacher)


def test_the_address_is_shown_and_hidden_on_a_frozen_projector(
    classroom: Class, address: str, screen: BlockingClient
) -> None:
    teacher, (ann,) = classroom.teacher, classroom.come("ann")
    choose(teacher, "On the screen")
    sees(screen, INVITED, address, "QR code")
    command(teacher, "Class: the screen frozen, or live")
    sees(teacher, "the screen is frozen")
    command(screen, "Class: the address away")
    no_longer(screen)
    assert classroom.host.control.presenter.frozen
    assert INVITED not in everything(ann) + shown(teacher) and address not in everything(ann)


def test_the_address_on_every_page_excludes_pages_opened_later(
    classroom: Class, address: str, screen: BlockingClient
) -> None:
    teacher, (ann,) = classroom.teacher, classroom.come("ann")
    command(teacher, "Class: the screen frozen, or live")
    choose(teacher, ON_EVERY_PAGE)
    for one in (teacher, screen, ann):
        sees(one, INVITED, address, "QR code")
    (bo,) = classroom.come("bo")
    sees(bo, "You follow the teacher")
    sees(teacher, "students here: 2", "is on every page")
    command(teacher, "Class: the next thing on the screen")
    no_longer(teacher, screen, ann)
    assert not classroom.host.control.presenter.frozen and INVITED not in everything(bo)
    choose(teacher, ON_EVERY_PAGE)
    sees(bo, INVITED)


def test_a_press_on_the_chosen_button_hides_the_address(classroom: Class) -> None:
    teacher, (ann,) = classroom.teacher, classroom.come("ann")
    choose(teacher, ON_EVERY_PAGE)
    sees(ann, INVITED)
    sees(teacher, "is on every page")
    (row,) = (row["uuid"] for row in bodies(teacher, "GuiButtonGroupMessage") if "Nowhere" in row["options"])
    # The page still has the old position of the mark; no other value counts as a press.
    for value in ("On every screen", "", f"{MARK}Nowhere"):
        teacher.send({"type": "GuiUpdateMessage", "uuid": row, "updates": {"value": value}})
    no_longer(teacher, ann)
    assert teacher.closed is None


def state(host: LectureHost) -> tuple[object, ...]:
    """State that a teacher's page and a clicker can change."""

    def read(_: Session) -> tuple[object, ...]:
        shown, group = host.control.presenter, host.classroom
        covers = shown.station, shown.blank, shown.frozen, shown.panels, shown.left, shown.inviting
        return (
            *covers,
            shown.work,
            shown.quotes,
            shown.expected,
            group.pace,
            group.wanted,
            group.paused,
            group.free,
        )

    return ask(host.session, read)


def test_a_screen_with_the_key_has_only_the_clicker(screen: BlockingClient) -> None:
    screen.wait_for(lambda v: len(v.mirror.commands) == len(CLICKER_KEYS))
    assert not bodies(screen, "GuiButtonMessage") and not screen.mirror.grabbable


def test_forged_clicker_and_teacher_messages_have_no_effect(
    classroom: Class, screen: BlockingClient, come: Come
) -> None:
    opened, host, (ann,) = classroom.opened, classroom.host, classroom.come("ann")
    keyless = [come(opened, query=f"screen=1{key}") for key in ("", "&key=chal")]
    before = state(host)
    for k, one in enumerate((ann, *keyless)):
        assert not [c for c in list(one.mirror.commands.values()) if "screen" in str(c["label"])]
        for owner in (classroom.teacher, screen):
            press_everything_of(owner, one)
        wait_until_all_has_come(opened, one, 700 + k)
    assert state(host) == before
