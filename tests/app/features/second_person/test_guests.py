"""A guest holds only the silver arm in another visitor's session; both may leave and reconnect."""

import re
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from app.features.second_person.guest import AWAY, CLOSED, ENDED, TAKEN
from app.features.second_person.second_place import SecondPlace
from app.i18n.catalogue import words_of
from app.page.panels.hotkeys import hotkeys
from app.settings import JOIN, Settings
from scenes.settings import RunSettings
from scenes.targets import LinkTarget
from tests.app.conftest import Arrive, Guest, OpenHouse
from tests.app.features.custom_law.helpers import edited
from tests.app.features.custom_law.test_edited_law import LAW, state_of
from tests.app.features.custom_law.test_edited_law import enter as save_law
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.helpers import click, hotkey_uuid, notes, shown
from tests.blocking_client import BlockingClient
from tests.scenes.helpers import place_of

HOLD = Settings(run=RunSettings(scene="hold", avoid="both"))
HAND_LINK = "/arms/{}/base/j1/j2/j3/j4/j5/j6/j7"
ON_STAGE = "You hold the silver arm"
INVITE, END = "Invite a second person", "End the invitation"


def word_on(visitor: BlockingClient) -> str:
    """Word of the invitation link on a host's page."""
    visitor.wait_for(lambda v: re.search(rf"\?{JOIN}=[0-9a-f]{{16}}\"", shown(v)))
    found = re.search(rf"\?{JOIN}=([0-9a-f]{{16}})\"", shown(visitor))
    assert found is not None
    return found[1]


def see(visitor: BlockingClient, text: str) -> None:
    visitor.wait_for(lambda v: text in shown(v))


def enter(opened: ExitStack, url: str, word: str, number: int, more: str = "") -> BlockingClient:
    return opened.enter_context(BlockingClient(url, query=f"{JOIN}={word}&resume={number:032d}{more}"))


def came_again(opened: ExitStack, guest: BlockingClient, url: str, word: str, number: int) -> BlockingClient:
    """A guest's page that the server sent elsewhere, reconnected as its script does."""
    guest.wait_for(lambda v: v.closed is not None)
    return enter(opened, url, word, number)


class Invited:
    """A host with an invitation in the experiment for two, and the guests' pages."""

    def __init__(self, host: Guest, url: str, opened: ExitStack) -> None:
        self.host, self.url, self.opened = host, url, opened
        click(host.visitor, INVITE)
        self.word = word_on(host.visitor)

    def enter(self, number: int, more: str = "", word: str = "") -> BlockingClient:
        return enter(self.opened, self.url, word or self.word, number, more)

    def came_again(self, guest: BlockingClient, number: int) -> BlockingClient:
        return came_again(self.opened, guest, self.url, self.word, number)

    def links(self) -> tuple[str, str]:
        """Links of the host's hand and of the silver hand."""
        session = self.host.session
        return HAND_LINK.format(session.hand.arm.name), HAND_LINK.format(session.simulation.avoiding.name)


@pytest.fixture
def invited(house: OpenHouse, arrive: Arrive) -> Iterator[Invited]:
    with ExitStack() as opened:
        app = house(HOLD)
        yield Invited(arrive(app, f"resume={1:032d}"), app.url, opened)


def test_a_guest_pulls_the_silver_arm_and_no_other(invited: Invited) -> None:
    host, guest = invited.host, invited.enter(2)
    assert host.session.parts.of(SecondPlace).word == invited.word
    orange, silver = invited.links()
    guest.wait_for(lambda v: silver in v.mirror.grabbable)
    see(host.visitor, "The second person is here")
    assert not any(name.startswith(orange.partition("/base")[0]) for name in guest.mirror.grabbable)
    before = host.ask(lambda s: place_of(s.simulation).copy())
    hand = host.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.avoiding).translation.copy())
    guest.pull(silver, "start", hand.tolist(), hand.tolist())
    guest.pull(silver, "update", hand.tolist(), (hand + np.array([0.0, 0.0, 0.15])).tolist())
    host.wait(lambda s: isinstance(s.hand.other, LinkTarget))
    host.wait(lambda s: place_of(s.simulation)[2] > before[2] + 0.01)
    assert host.session.held is None, "the host must hold nothing"
    guest.pull(silver, "end", hand.tolist(), hand.tolist())
    host.wait(lambda s: s.hand.other is None)


def test_a_guests_description_appears_only_on_the_guests_page(invited: Invited) -> None:
    guest = invited.enter(2, "&lang=de")
    see(guest, "Sie halten den silbernen Arm")
    text = words_of("de")(next(hotkey.text for hotkey in hotkeys() if hotkey.name == "describe"))
    label = text[0].upper() + text[1:]
    guest.wait_for(lambda v: label in {command["label"] for command in v.mirror.commands.values()})
    describe = next(u for u, command in guest.mirror.commands.items() if command["label"] == label)
    guest.send({"type": "CommandTriggerMessage", "uuid": describe})
    guest.wait_for(lambda v: any("Arm: Hand" in note for note in notes(v)))
    assert not notes(invited.host.visitor)


def test_forged_messages_of_a_guest_change_nothing(invited: Invited) -> None:
    """The host's controls, keys, buttons and handles, with their real names."""
    host, guest = invited.host, invited.enter(2)
    (orange, silver), own = invited.links(), host.visitor.mirror
    guest.wait_for(lambda v: silver in v.mirror.grabbable)
    settings, paused = host.session.settings, host.session.paused
    for element in list(own.gui.values()):
        guest.send({"type": "GuiUpdateMessage", "uuid": element["uuid"], "updates": {"value": True}})
    for action in ("pause", "reset", "law", "gizmo"):
        guest.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(host.visitor, action)})
    for claimed in (own.nodes[orange]["owner"], guest.mirror.nodes[silver]["owner"]):
        guest.mirror.nodes[orange]["owner"] = claimed
        guest.pull(orange, "start", [0.0, 0.0, 0.0], [0.0, 0.0, 0.5])
    # A connection's messages are handled in order: after this pull, the forged ones have been handled.
    guest.pull(silver, "start", [0.0, 0.0, 0.0], [0.0, 0.0, 0.1])
    host.wait(lambda s: s.hand.other is not None)
    kept = host.ask(lambda s: (s.settings, s.paused, s.held, s.parts.of(SecondPlace).word))
    assert kept == (settings, paused, None, invited.word)
    assert not lessons_of(host).open
    assert not re.search("Lessons|Pause|Reset", str(guest.mirror.gui.values()))


def test_one_guest_holds_the_arm_until_that_guest_leaves(invited: Invited) -> None:
    guest = invited.enter(2)
    see(guest, ON_STAGE)
    late = invited.enter(3)
    see(late, TAKEN)
    guest.close()
    late = invited.came_again(late, 3)
    see(late, ON_STAGE)
    # A reconnected page of the same tab gets the arm although the lost connection is not yet noticed.
    again = invited.enter(3)
    see(again, ON_STAGE)
    see(late, TAKEN)


def test_in_another_experiment_a_guest_holds_nothing(invited: Invited) -> None:
    host, guest = invited.host, invited.enter(2)
    _, silver = invited.links()
    guest.wait_for(lambda v: silver in v.mirror.grabbable)
    host.ask(lambda s: s.change("scene", "ball"))
    see(guest, "Here only your host holds something")
    see(host.visitor, "they hold the other arm again")
    guest.wait_for(lambda v: not v.mirror.grabbable)
    host.ask(lambda s: s.change("scene", "hold"))
    guest.wait_for(lambda v: silver in v.mirror.grabbable)
    see(host.visitor, "and holds the other arm")


def test_the_host_leaves_returns_and_ends_the_invitation(invited: Invited) -> None:
    guest = invited.enter(3)
    see(guest, ON_STAGE)
    invited.host.visitor.close()
    see(guest, AWAY)
    newcomer = invited.enter(4)
    see(newcomer, CLOSED)
    # The same session again.
    back = invited.opened.enter_context(BlockingClient(invited.url, query=f"resume={1:032d}"))
    see(back, "The second person is here")
    guest.wait_for(lambda v: AWAY not in shown(v))
    see(newcomer, TAKEN)
    click(back, END)
    see(guest, ENDED)
    see(newcomer, CLOSED)
    assert not any(name.startswith("/arms") for name in newcomer.mirror.nodes)
    unknown = invited.enter(5, "&lang=sl", word="0" * 16)
    see(unknown, words_of("sl")(CLOSED))
    click(back, INVITE)
    assert word_on(back) != invited.word


def test_a_guest_of_the_owner_gets_no_editor_and_cannot_forge_a_save(
    house: OpenHouse, arrive: Arrive, tmp_path: Path
) -> None:
    file = tmp_path / "my_law.py"
    owner = arrive(house(HOLD, features=(edited(file),)))
    owner.visitor.wait_for(state_of)
    box = (state_of(owner.visitor) or {})["box"]
    click(owner.visitor, INVITE)
    with ExitStack() as opened:
        guest = enter(opened, owner.visitor.url, word_on(owner.visitor), 2)
        see(guest, ON_STAGE)
        assert state_of(guest) is None
        save_law(guest, box, LAW)
        # A connection's messages are handled in order: after the pull, the forged entry has been handled.
        _, silver = (
            HAND_LINK.format(arm.name) for arm in (owner.session.hand.arm, owner.session.simulation.avoiding)
        )
        guest.wait_for(lambda v: silver in v.mirror.grabbable)
        guest.pull(silver, "start", [0.0, 0.0, 0.0], [0.0, 0.0, 0.5])
        owner.wait(lambda s: s.hand.other is not None)
        assert not file.exists() and (state_of(owner.visitor) or {})["number"] == ""
    save_law(owner.visitor, box, LAW)
    owner.visitor.wait_for(lambda v: (state_of(v) or {})["said"] == "saved")
