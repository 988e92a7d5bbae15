"""A row of buttons with the present choice marked."""

from collections.abc import Callable, Mapping
from typing import Final, TypeVar

import viser

from app.i18n.speaking import tr
from app.session.actions import Action

MARK: Final = "● "
"""Prefix of the present choice: a cue without colour."""

UNTICKED: Final = "○ "
"""Prefix of an unticked choice, as wide as `MARK`, so that a tick moves no button."""

Asked = TypeVar("Asked", bound=Action)


class ChoiceButtons:
    """One button per choice.

    Args:
        label: before the row, in English; may be empty.
        choices: label in English → value to post.
        hint: one line, in English.
        post: called with a button's value, on the network's thread.
        order: among its neighbours, None for the end.
        numbered: whether each button begins with its number, from 1.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        choices: Mapping[str, Asked],
        hint: str,
        post: Callable[[Asked], None],
        order: float | None = None,
        numbered: bool = False,
    ) -> None:
        said = {f"{i} {tr(label)}" if numbered else tr(label): choice for i, (label, choice) in enumerate(choices.items(), 1)}
        self._labels = tuple(said)
        self._buttons = gui.add_button_group(tr(label), self._labels, hint=tr(hint), order=order)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            # The mark may have moved, or the button been removed, while the press was on its way.
            plain = event.target.value.removeprefix(MARK).removeprefix(UNTICKED)
            if plain in {one.removeprefix(MARK).removeprefix(UNTICKED) for one in event.target.options}:
                post(said[plain])

    @property
    def order(self) -> float:
        return self._buttons.order

    def show(self, marked: int = -1, offered: tuple[int, ...] | None = None, visible: bool = True) -> None:
        """Update the row.

        Args:
            marked: index of the present choice, or −1.
            offered: indices of the choices with a button; None for all.
        """
        indices = range(len(self._labels)) if offered is None else offered
        self._buttons.options = tuple((MARK if i == marked else "") + self._labels[i] for i in indices)
        self._buttons.visible = visible

    def tick(self, ticked: tuple[int, ...], visible: bool) -> None:
        """Mark several choices. `ticked`: their indices."""
        self._buttons.options = tuple((MARK if i in ticked else UNTICKED) + label for i, label in enumerate(self._labels))
        self._buttons.visible = visible
