"""A row of buttons of which one is marked as the present choice."""

from collections.abc import Callable
from typing import Final

import viser

from app.i18n.speaking import tr, tr_all

MARK: Final = "● "
"""Stands before the present choice: a cue that is no colour."""


class ChoiceButtons:
    """A row of buttons, one for each choice.

    Args:
        gui: of the visitor who operates it; the caller has opened the container.
        label: before the row, in English; may be empty.
        labels: what the buttons say, in English.
        hint: one line that explains it, in English.
        chosen: called with the index of a button that was pressed, on the network's thread.
        order: place among its neighbours, None for the end.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        labels: tuple[str, ...],
        hint: str,
        chosen: Callable[[int], None],
        order: float | None = None,
    ) -> None:
        said = self._labels = tr_all(labels)
        self._marked = -1
        self._offered = tuple(range(len(labels)))
        self._buttons = gui.add_button_group(tr(label), said, hint=tr(hint), order=order)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            plain = event.target.value.removeprefix(MARK)
            if plain in said:
                chosen(said.index(plain))

    def mark(self, index: int) -> None:
        """Mark one choice; none if the index is −1."""
        if index != self._marked:
            self._marked = index
            self._write()

    def offer(self, indices: tuple[int, ...]) -> None:
        """Show the buttons of these choices only."""
        if indices != self._offered:
            self._offered = indices
            self._write()

    def show(self, visible: bool) -> None:
        """Show or hide the whole row."""
        self._buttons.visible = visible

    def _write(self) -> None:
        self._buttons.options = tuple((MARK if i == self._marked else "") + self._labels[i] for i in self._offered)
