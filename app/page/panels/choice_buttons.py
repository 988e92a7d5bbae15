"""Buttons of a choice."""

from collections.abc import Callable, Mapping
from typing import Final, TypeVar

import viser

from app.i18n.speaking import tr
from app.session.actions import Action

MARK: Final = "● "
"""Mark of the present choice; a cue other than colour."""

Asked = TypeVar("Asked", bound=Action)


class ChoiceButtons:
    """Row of buttons, one per choice.

    Args:
        label, hint: in English.
        choices: English label → action.
        post: called on the network's thread.
        order: None for the end of the container.
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
        self._said, self._texts, self._labels = said, (label, hint, tuple(choices)), tuple(said)
        self._buttons = gui.add_button_group(tr(label), self._labels, hint=tr(hint), order=order)

        @self._buttons.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            # A press may have been on its way while the mark moved, or the button was taken away.
            plain = event.target.value.removeprefix(MARK)
            if plain in {one.removeprefix(MARK) for one in event.target.options}:
                post(said[plain])

    @property
    def order(self) -> float:
        return self._buttons.order

    def say(self, say: Callable[[str], str]) -> None:
        """Change the row's words from the next `show` on; `say` translates them."""
        label, hint, names = self._texts
        # A press may be on its way from a button with its old name.
        self._said |= {say(name): self._said[one] for name, one in zip(names, self._labels, strict=True)}
        self._labels = tuple(map(say, names))
        self._buttons.label, self._buttons.hint = say(label), say(hint)

    def show(self, marked: int = -1, offered: tuple[int, ...] | None = None, visible: bool = True) -> None:
        """Update the row.

        Args:
            marked: index of the present choice, or −1.
            offered: shown indices; None for all.
        """
        indices = range(len(self._labels)) if offered is None else offered
        self._buttons.options = tuple((MARK if i == marked else "") + self._labels[i] for i in indices)
        self._buttons.visible = visible
