"""Table of key bindings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar, cast

import viser
from markupsafe import Markup

from app.i18n.speaking import N_, spoken, tr
from app.session.actions import (
    Action,
    ChangeSpeed,
    Describe,
    Digit,
    FirstView,
    Nudge,
    Pause,
    Reset,
    SingleStep,
    SwingElbow,
    Toggle,
)
from app.text.document_list import DOCUMENTS
from app.text.documents import PREFIX
from app.text.templates import macros
from app.web.control_events import on_press
from app.web.viser_internals import HotkeyKey
from scenes.experiments import EXPERIMENTS

AnyAction = TypeVar("AnyAction", bound=Action | str)


@dataclass(frozen=True)
class Hotkey(Generic[AnyAction]):
    """One row.

    Attributes:
        shown: label of the key.
        relayed: `KeyboardEvent.key` of a key that viser's palette cannot name, or that moves its camera;
            `hotkeys.js` turns it into `key` with Alt and Shift.
    """

    name: str
    action: AnyAction
    shown: str
    text: str
    key: HotkeyKey
    relayed: str = ""
    icon: viser.IconName | None = None

    @property
    def title(self) -> str:
        text = tr(self.text)
        return text[:1].upper() + text[1:]

    def add_to(self, gui: viser.GuiApi, act: Callable[[AnyAction], None]) -> viser.CommandHandle:
        """Add its command to a page. `act`: called on the network's thread."""
        command = gui.add_command(
            self.title,
            description=tr("Key: {key}", key=self.shown) if self.relayed else None,
            hotkey=self.key,
            # Not pressed by chance: the page presses it for another key.
            modifier="alt+shift" if self.relayed else None,
            icon=self.icon,
        )
        return on_press(command, lambda: act(self.action))


_TABLE: Final[tuple[Hotkey[Action], ...]] = (
    Hotkey("pause", Pause(), "Space", "pause or continue", "space", icon=viser.Icon.PLAYER_PAUSE),
    Hotkey(
        "step", SingleStep(), ".", "one single step", "1", relayed=".", icon=viser.Icon.PLAYER_SKIP_FORWARD
    ),
    Hotkey("slower", ChangeSpeed(-1), "[", "slower", "2", relayed="[", icon=viser.Icon.PLAYER_TRACK_PREV),
    Hotkey("faster", ChangeSpeed(1), "]", "faster", "3", relayed="]", icon=viser.Icon.PLAYER_TRACK_NEXT),
    Hotkey("reset", Reset(), "R", "restart the run", "R", icon=viser.Icon.REFRESH),
    # viser moves its camera by W, A, S and D.
    Hotkey(
        "autopilot", Toggle("autopilot"), "A", "autopilot on or off", "8", relayed="a", icon=viser.Icon.ROBOT
    ),
    Hotkey(
        "left",
        Nudge(right=-1),
        "←",
        "hand or ball 2 cm to the left",
        "4",
        relayed="ArrowLeft",
        icon=viser.Icon.ARROW_LEFT,
    ),
    Hotkey(
        "right",
        Nudge(right=1),
        "→",
        "hand or ball 2 cm to the right",
        "5",
        relayed="ArrowRight",
        icon=viser.Icon.ARROW_RIGHT,
    ),
    Hotkey("up", Nudge(up=1), "↑", "hand or ball 2 cm up", "6", relayed="ArrowUp", icon=viser.Icon.ARROW_UP),
    Hotkey(
        "down",
        Nudge(up=-1),
        "↓",
        "hand or ball 2 cm down",
        "7",
        relayed="ArrowDown",
        icon=viser.Icon.ARROW_DOWN,
    ),
    Hotkey(
        "away",
        Nudge(away=1),
        "Page ↑",
        "hand or ball 2 cm away from you",
        "pageup",
        icon=viser.Icon.ARROW_BAR_TO_UP,
    ),
    Hotkey(
        "near",
        Nudge(away=-1),
        "Page ↓",
        "hand or ball 2 cm towards you",
        "pagedown",
        icon=viser.Icon.ARROW_BAR_TO_DOWN,
    ),
    Hotkey("elbow_up", SwingElbow(1), "J", "elbow 4° to one side", "J", icon=viser.Icon.ROTATE),
    Hotkey(
        "elbow_down", SwingElbow(-1), "K", "elbow 4° to the other side", "K", icon=viser.Icon.ROTATE_CLOCKWISE
    ),
    Hotkey("gizmo", Toggle("gizmo"), "M", "arrows along the axes, or none", "M", icon=viser.Icon.ARROWS_MOVE),
    Hotkey(
        "describe", Describe(), "I", "what is to be seen, in a sentence", "I", icon=viser.Icon.TEXT_CAPTION
    ),
    Hotkey("view", FirstView(), "V", "the first view again", "V", icon=viser.Icon.CAMERA),
    Hotkey(
        "contact",
        Toggle("contact"),
        "O",
        "λ in the scene on or off: line, skin and tint",
        "O",
        icon=viser.Icon.CIRCLE_DASHED,
    ),
    Hotkey("law", Toggle("avoidance"), "L", "avoidance on or off", "L", icon=viser.Icon.SHIELD),
    Hotkey("ghost", Toggle("ghost"), "G", "a ghost with these settings, or none", "G", icon=viser.Icon.GHOST),
)


def hotkeys() -> tuple[Hotkey[Action], ...]:
    """The table with digits for the first nine experiments."""
    digits = (
        Hotkey[Action](
            one.name,
            Digit(i),
            str(i),
            one.short,
            cast(HotkeyKey, str(i)),
            icon=getattr(viser.Icon, f"NUMBER_{i}"),
        )
        for i, one in zip(range(1, 10), EXPERIMENTS.values(), strict=False)
    )
    return (*_TABLE, *digits)


def keys_of(
    table: tuple[Hotkey[AnyAction], ...], instead: tuple[Hotkey[Any], ...]
) -> tuple[Hotkey[AnyAction], ...]:
    taken = {hotkey.key for hotkey in instead}
    return tuple(hotkey for hotkey in table if hotkey.key not in taken)


KEY_NAMES: Final = (N_("Space"), N_("Page ↑"), N_("Page ↓"))
"""Labels of keys that differ between languages."""


@dataclass(frozen=True)
class KeyRange:
    """Keys `first` to `last` as one row of the help."""

    first: str
    last: str
    text: str


KeyHelp = Hotkey[Any] | KeyRange
"""Row of a feature in the help."""


def help_html(instead: tuple[Hotkey[Any], ...] = (), further: Sequence[KeyHelp] = ()) -> Markup:
    """The table as HTML. `instead`: keys with other meanings on this page."""
    theirs = tuple(row for row in further if isinstance(row, Hotkey))
    ranges = [row for row in further if isinstance(row, KeyRange)]
    rows = (*instead, *keys_of(hotkeys(), instead), *keys_of(theirs, instead))
    documents = [(name, one.title) for name, one in DOCUMENTS.items()]
    return macros("page/panels/help.html").help(rows, KEY_NAMES, ranges, documents, PREFIX, spoken().language)
