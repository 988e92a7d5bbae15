"""A row of buttons of which one is marked as the present choice."""

from collections.abc import Callable, Mapping
from typing import Final, TypeVar

import viser

from app.i18n.speaking import tr
from app.session.actions import Action

MARK: Final = "● "
"""Stands before the present choice: a cue that is no colour."""

Asked = TypeVar("Asked", bound=Action)


class ChoiceButtons:
    """A row of buttons, one for each choice.

    Args:
        label: before the row, in English; may be empty.
        choices: what a button says, in English → what it asks for.
        hint: one line that explains it, in English.
        post: called with what a button that was pressed asks for, on the network's thread.
        order: place among its neighbours, None for the end.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        choices: Mapping[str, Asked],
        hint: str,
        post: Callable[[Asked], None],
        order: float | None = None,
    ) -> None:
        said = {tr(label): choice for label, choice in choices.items()}
        self._labels = tuple(said)
        self._buttons = gui.add_button_group(tr(label), self._labels, hint=tr(hint), order=order)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            # A press may have been on its way while the mark moved, or the button was taken away.
            plain = event.target.value.removeprefix(MARK)
            if plain in {one.removeprefix(MARK) for one in event.target.options}:
                post(said[plain])

    @property
    def order(self) -> float:
        """Place among its neighbours."""
        return self._buttons.order

    def show(self, marked: int = -1, offered: tuple[int, ...] | None = None, visible: bool = True) -> None:
        """Update the row.

        Args:
            marked: index of the present choice; −1 for none.
            offered: indices of the choices that have a button; None for all.
            visible: whether the row is there.
        """
        indices = range(len(self._labels)) if offered is None else offered
        self._buttons.options = tuple((MARK if i == marked else "") + self._labels[i] for i in indices)
        self._buttons.visible = visible
