"""Forged messages for another page's elements, on which the server must not act."""

from app.start import App
from app.web.headless_client import CAMERA
from tests.app.page.helpers import Client
from tests.blocking_client import BlockingClient

VALUES = {
    "GuiSliderMessage": (50.0,),
    "GuiButtonMessage": (True,),
    "GuiTextMessage": ("2",),
    "GuiNumberMessage": (60,),
    "GuiCheckboxMessage": (True,),
}
"""Message type of an element → values to send for it; a row of buttons also gets each of its options."""


def press_everything_of(owner: Client, sender: BlockingClient) -> None:
    """Send all commands and elements of the owner's page from the sender's page."""
    for uuid in list(owner.mirror.commands):
        sender.send({"type": "CommandTriggerMessage", "uuid": uuid})
    for element in list(owner.mirror.gui.values()):
        row = element.get("options", ()) if element["type"] == "GuiButtonGroupMessage" else ()
        for value in (*VALUES.get(element["type"], ()), *row):
            sender.send({"type": "GuiUpdateMessage", "uuid": element["uuid"], "updates": {"value": value}})


def drag(sender: BlockingClient, link: str, owner: str) -> None:
    """Drag a link and release it, under the name of the page that owns it."""
    for phase in ("start", "update", "end"):
        sender.send(
            {
                "type": "SceneNodeDragMessage",
                "name": link,
                "owner": owner,
                "instance_index": None,
                "button": "left",
                "start_position": [0.3, 0.0, 1.0],
                "end_position": [0.0, 0.0, 1.0],
                "modifier": None,
                "phase": phase,
                "start_screen_pos": [0.5, 0.5],
                "end_screen_pos": [0.5, 0.5],
            }
        )


def wait_until_all_has_come(opened: App, sender: BlockingClient, width: int = 700) -> None:
    """Wait until all messages have arrived, by a final camera message. `width`: unique per sender [px]."""
    sender.send(CAMERA | {"image_height": 500, "image_width": width})
    sender.wait_for(
        lambda _: any(client.camera.image_width == width for client in opened.server.get_clients().values())
    )
