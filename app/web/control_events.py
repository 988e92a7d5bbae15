"""Control events as calls on the network's thread."""

from collections.abc import Callable
from typing import Any, TypeVar

import viser

InputHandle = TypeVar("InputHandle", bound=viser.GuiInputHandle[Any])
PressedHandle = TypeVar("PressedHandle", bound=viser.GuiButtonHandle | viser.CommandHandle)


def on_entry(control: InputHandle, take: Callable[[Any], object]) -> InputHandle:
    """Call `take` with every value that a visitor, not the server, enters."""

    @control.on_update
    async def _(event: viser.GuiEvent[Any]) -> None:
        # Values written by the server arrive here too, without a client.
        if event.client_id is not None:
            take(event.target.value)

    return control


def on_press(control: PressedHandle, act: Callable[[], object]) -> PressedHandle:
    """Call `act` for every press, also by a palette's name or key."""

    @(control.on_trigger if isinstance(control, viser.CommandHandle) else control.on_click)
    async def _(event: viser.GuiEvent[Any] | viser.CommandEvent) -> None:
        del event
        act()

    return control


def on_file(upload: viser.GuiUploadButtonHandle, take: Callable[[str, bytes], object]) -> None:
    """Call `take` with the name and content of every file."""

    @upload.on_upload
    async def _(event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        take(event.target.value.name, event.target.value.content)
