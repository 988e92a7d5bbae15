from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.hosting.app_context import AppContext
    from app.hosting.joining_pages import JoiningPages
    from app.page.panel_context import PanelMaker


def _panels() -> "Sequence[PanelMaker]":
    from app.features.second_person.invite_box import invite_box

    return (invite_box,)


def _joining(context: "AppContext") -> "JoiningPages":
    from app.features.second_person.guests import Guests

    return Guests(context)


SECOND_PERSON: Final = Feature("second_person", texts=Path(__file__).parent, panels=_panels, joining=_joining)
