"""A guest holds the silver arm of another visitor's session, and can do nothing else there; both may leave and come back."""

import re
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from app.features.second_person.second_place import SecondPlace
from app.settings import JOIN, Settings
from app.start import App
from scenes.settings import RunSettings
from scenes.targets import LinkTarget
from tests.app.conftest import Arrive, OpenHouse
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
    """The word of the link that a host's page shows."""
    visitor.wait_for(lambda v: re.search(rf"\?{JOIN}=[0-9a-f]{{16}}\"", shown(v)))
    found = re.search(rf"\?{JOIN}=([0-9a-f]{{16}})\"", shown(visitor))
    assert found is not None
    return found[1]


def see(visitor: BlockingClient, text: str) -> None:
    visitor.wait_for(lambda v: text in shown(v))


def enter(opened: ExitStack, url: str, word: str, number: int, more: str = "") -> BlockingClient:
    return opened.enter_context(BlockingClient(url, query=f"{JOIN}={word}&resume={number:032d}{more}"))


def came_again(opened: ExitStack, guest: BlockingClient, url: str, word: str, number: int) -> BlockingClient:
    """The page of a guest whom the server sends elsewhere, connected again as its script does."""
    guest.wait_for(lambda v: v.closed is not None)
    return enter(opened, url, word, number)


def test_a_guest_holds_the_silver_arm_and_nothing_else(house: OpenHouse, arrive: Arrive) -> None:
    opened_house: App = house(HOLD)
    host = arrive(opened_house, f"resume={1:032d}")
    session, url = host.session, opened_house.url
    click(host.visitor, INVITE)
    word = word_on(host.visitor)
    assert session.parts.of(SecondPlace).word == word
    see(host.visitor, "Start with <code>--host 0.0.0.0</code>")
    yours, other = (HAND_LINK.format(arm.name) for arm in (session.hand.arm, session.simulation.avoiding))
    with ExitStack() as opened:
        guest = enter(opened, url, word, 2, "&lang=de&theme=dark")
        see(guest, "Sie halten den silbernen Arm")
        guest.wait_for(lambda v: other in v.mirror.grabbable)
        see(host.visitor, "The second person is here")
        assert not any(name.startswith(yours.partition("/base")[0]) for name in guest.mirror.grabbable)
        describe = next(
            u
            for u, command in guest.mirror.commands.items()
            if command["label"] == "Was zu sehen ist, in einem Satz"
        )
        guest.send({"type": "CommandTriggerMessage", "uuid": describe})
        guest.wait_for(lambda v: any("Arm: Hand" in note for note in notes(v)))
        assert not notes(host.visitor)
        before = host.ask(lambda s: place_of(s.simulation).copy())
        hand = host.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.avoiding).translation.copy())
        guest.pull(other, "start", hand.tolist(), hand.tolist())
        guest.pull(other, "update", hand.tolist(), (hand + np.array([0.0, 0.0, 0.15])).tolist())
        host.wait(lambda s: isinstance(s.hand.other, LinkTarget))
        host.wait(lambda s: place_of(s.simulation)[2] > before[2] + 0.01)
        assert session.held is None, "the host holds nothing"

        # What a forged message asks for: the host's controls, keys, buttons and handles, by their own names.
        settings, paused = session.settings, session.paused
        own = host.visitor.mirror
        for element in list(own.gui.values()):
            guest.send({"type": "GuiUpdateMessage", "uuid": element["uuid"], "updates": {"value": True}})
        for action in ("pause", "reset", "law", "gizmo"):
            guest.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(host.visitor, action)})
        owner = own.nodes[yours]["owner"]
        for claimed in (owner, guest.mirror.nodes[other]["owner"]):
            guest.mirror.nodes[yours]["owner"] = claimed
            guest.pull(yours, "start", [0.0, 0.0, 0.0], [0.0, 0.0, 0.5])
        guest.pull(other, "end", hand.tolist(), hand.tolist())
        host.wait(lambda s: s.hand.other is None)
        assert host.ask(lambda s: (s.settings, s.paused, s.held, s.parts.of(SecondPlace).word)) == (
            settings,
            paused,
            None,
            word,
        )
        assert not lessons_of(host).open and not re.search(
            "Lessons|Pause|Reset|Keep and replay", str(guest.mirror.gui.values())
        )

        # No one else can take the arm, until it is free; what the guest held is let go of.
        late = enter(opened, url, word, 3)
        see(late, "Another guest holds this arm")
        guest.close()
        late = came_again(opened, late, url, word, 3)
        see(late, ON_STAGE)
        # A page that is connected again by the same tab has the arm, though the line before is not known to be lost.
        again = enter(opened, url, word, 3)
        see(again, ON_STAGE)
        see(late, "Another guest holds this arm")
        # In another experiment there is nothing for a guest.
        host.ask(lambda s: s.change("scene", "ball"))
        see(again, "Here only your host holds something")
        see(host.visitor, "In the experiment “Hold” they hold the other arm again")
        again.wait_for(lambda v: not v.mirror.grabbable)
        host.ask(lambda s: s.change("scene", "hold"))
        again.wait_for(lambda v: other in v.mirror.grabbable)
        see(host.visitor, "The second person is here, and holds the other arm")

        # The host leaves and comes back, to the same session.
        host.visitor.close()
        see(again, "Your host is away")
        newcomer = enter(opened, url, word, 4)
        see(newcomer, "This invitation is not open")
        back = opened.enter_context(BlockingClient(url, query=f"resume={1:032d}"))
        see(back, "The second person is here")
        again.wait_for(lambda v: "Your host is away" not in shown(v))
        see(newcomer, "Another guest holds this arm")
        click(back, END)
        see(again, "Your host has ended this invitation.")
        see(newcomer, "This invitation is not open")
        assert not any(name.startswith("/arms") for name in newcomer.mirror.nodes)
        unknown = enter(opened, url, "0" * 16, 5, "&lang=sl")
        see(unknown, "To povabilo ni odprto")
        click(back, INVITE)
        assert word_on(back) != word


def test_a_guest_of_the_owner_gets_no_editor_and_forges_none(
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
        # What a connection sends is dealt with in its order: after the pull, the forged entry has been.
        _, silver = (
            HAND_LINK.format(arm.name) for arm in (owner.session.hand.arm, owner.session.simulation.avoiding)
        )
        guest.wait_for(lambda v: silver in v.mirror.grabbable)
        guest.pull(silver, "start", [0.0, 0.0, 0.0], [0.0, 0.0, 0.5])
        owner.wait(lambda s: s.hand.other is not None)
        assert not file.exists() and (state_of(owner.visitor) or {})["number"] == ""
    save_law(owner.visitor, box, LAW)
    owner.visitor.wait_for(lambda v: (state_of(v) or {})["said"] == "saved")
