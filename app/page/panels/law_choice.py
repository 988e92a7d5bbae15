"""Choice of the law."""

from collections.abc import Callable
from typing import Any, Final

from app.i18n.speaking import N_, tr
from app.session.actions import Action
from scenes.laws import LAWS
from scenes.setting_spec import Spec

MORE: Final = N_("More laws …")


class MoreLaws(Action):
    """Offer every law in the list."""


class LawChoice:
    """Entries of the drop-down of laws; few controls have a short list.

    Args:
        unoffered: laws that only a link can ask for.
    """

    def __init__(self, handle: Any, spec: Spec, unoffered: tuple[str, ...]) -> None:
        self._handle, self._spec, self._unoffered = handle, spec, unoffered
        self.all = False

    def show(self, present: str, few: bool, say: Callable[[str], str]) -> None:
        """Offer the laws, always with the `present` one. `few`: True if few controls are shown."""
        short = few and not self.all
        offered = [law for law in self._spec.choices if law == present or self._offers(law, short)]
        texts = self._spec.options()
        options = (*(say(texts[law]) for law in offered), *((tr(MORE),) if short else ()))
        if options != self._handle.options:
            self._handle.options = options

    def _offers(self, law: str, short: bool) -> bool:
        return LAWS[law].offered_first if short else law not in self._unoffered
