"""The hotkeys: one table, which is the key bindings, the help, and the entries of the command palette at once."""

from dataclasses import dataclass
from typing import Final, Generic, TypeVar

import viser
from viser._messages import HotkeyKey, KeyModifier

from app.i18n.speaking import N_, spoken, tr
from app.lessons.session.lesson_actions import Check, GoBack, GoOn, Leave, LessonAction, ShowHint, ShowWhy
from app.session.actions import (
    Action,
    ChangeSpeed,
    FirstView,
    Nudge,
    Pause,
    Reset,
    SetSetting,
    SingleStep,
    SwingElbow,
    Toggle,
)
from app.text.documents import DOCUMENTS, PREFIX

AnyAction = TypeVar("AnyAction", Action, LessonAction)


@dataclass(frozen=True)
class Hotkey(Generic[AnyAction]):
    """One row.

    Attributes:
        name: its name in the code.
        action: what it asks for.
        shown: the key as a person knows it.
        text: what it does.
        key: what viser listens to, with `modifier`.
        relayed: `KeyboardEvent.key` of a key that viser's command palette has no name for, or that moves its camera; the page
            turns it into `key` with `modifier`.
        icon: in the palette.
    """

    name: str
    action: AnyAction
    shown: str
    text: str
    key: HotkeyKey
    relayed: str = ""
    icon: viser.IconName | None = None

    @property
    def modifier(self) -> KeyModifier | None:
        """What has to be held down with `key`: a combination that is not pressed by chance, where the page presses it for another key."""
        return "alt+shift" if self.relayed else None

    @property
    def title(self) -> str:
        """What it does, as the name of a command, in the visitor's language."""
        said = tr(self.text)
        return said[:1].upper() + said[1:]


HOTKEYS: Final[tuple[Hotkey[Action], ...]] = (
    Hotkey("pause", Pause(), "Space", "pause or go on", "space", icon=viser.Icon.PLAYER_PAUSE),
    Hotkey("step", SingleStep(), ".", "one single step", "1", relayed=".", icon=viser.Icon.PLAYER_SKIP_FORWARD),
    Hotkey("slower", ChangeSpeed(-1), "[", "slower", "2", relayed="[", icon=viser.Icon.PLAYER_TRACK_PREV),
    Hotkey("faster", ChangeSpeed(1), "]", "faster", "3", relayed="]", icon=viser.Icon.PLAYER_TRACK_NEXT),
    Hotkey("reset", Reset(), "R", "start anew", "R", icon=viser.Icon.REFRESH),
    # viser moves its camera by W, A, S and D.
    Hotkey("autopilot", Toggle("autopilot"), "A", "autopilot on or off", "8", relayed="a", icon=viser.Icon.ROBOT),
    Hotkey("left", Nudge(right=-1), "←", "hand or ball 2 cm to the left", "4", relayed="ArrowLeft", icon=viser.Icon.ARROW_LEFT),
    Hotkey(
        "right", Nudge(right=1), "→", "hand or ball 2 cm to the right", "5", relayed="ArrowRight", icon=viser.Icon.ARROW_RIGHT
    ),
    Hotkey("up", Nudge(up=1), "↑", "hand or ball 2 cm up", "6", relayed="ArrowUp", icon=viser.Icon.ARROW_UP),
    Hotkey("down", Nudge(up=-1), "↓", "hand or ball 2 cm down", "7", relayed="ArrowDown", icon=viser.Icon.ARROW_DOWN),
    Hotkey("away", Nudge(away=1), "Page ↑", "hand or ball 2 cm away from you", "pageup", icon=viser.Icon.ARROW_BAR_TO_UP),
    Hotkey("near", Nudge(away=-1), "Page ↓", "hand or ball 2 cm towards you", "pagedown", icon=viser.Icon.ARROW_BAR_TO_DOWN),
    Hotkey("elbow_up", SwingElbow(1), "J", "elbow 4° to one side", "J", icon=viser.Icon.ROTATE),
    Hotkey("elbow_down", SwingElbow(-1), "K", "elbow 4° to the other side", "K", icon=viser.Icon.ROTATE_CLOCKWISE),
    Hotkey("view", FirstView(), "V", "the first view again", "V", icon=viser.Icon.CAMERA),
    Hotkey("law", Toggle("avoidance"), "L", "avoidance on or off", "L", icon=viser.Icon.SHIELD),
    Hotkey("ghost", Toggle("ghost"), "G", "a ghost with these settings, or none", "G", icon=viser.Icon.GHOST),
    Hotkey("solo", SetSetting("scene", "solo"), "1", "one arm alone", "1", icon=viser.Icon.NUMBER_1),
    Hotkey("ball", SetSetting("scene", "ball"), "2", "a ball in the way", "2", icon=viser.Icon.NUMBER_2),
    Hotkey("hold", SetSetting("scene", "hold"), "3", "hold", "3", icon=viser.Icon.NUMBER_3),
    Hotkey("master_slave", SetSetting("scene", "master_slave"), "4", "master and slave", "4", icon=viser.Icon.NUMBER_4),
    Hotkey("imitation", SetSetting("scene", "imitation"), "5", "imitation", "5", icon=viser.Icon.NUMBER_5),
)


LESSON_KEYS: Final[tuple[Hotkey[LessonAction], ...]] = (
    Hotkey("next", GoOn(), "N", "lesson: go on", "N", icon=viser.Icon.ARROW_RIGHT),
    Hotkey("back", GoBack(), "B", "lesson: go back", "B", icon=viser.Icon.ARROW_LEFT),
    Hotkey("check", Check(), "C", "lesson: check the challenge", "C", icon=viser.Icon.CHECKS),
    Hotkey("hint", ShowHint(), "H", "lesson: the next hint", "H", icon=viser.Icon.BULB),
    Hotkey("why", ShowWhy(), "Y", "lesson: the run that shows why", "Y", icon=viser.Icon.QUESTION_MARK),
    Hotkey("leave", Leave(), "X", "lesson: leave the lessons", "X", icon=viser.Icon.X),
)
"""Keys of the lessons, listened to while one is open. There 1 to 5 answer, and ← and → go back and on where the hand is not yours."""


KEY_NAMES: Final = (N_("Space"), N_("Page ↑"), N_("Page ↓"))
"""What stands on keys, and is another word on other keyboards."""


def pressing(digit: str) -> str:
    """Return JavaScript that presses a digit with Alt and Shift, as nobody does by chance. `digit`: a JavaScript expression."""
    return (
        "document.documentElement.dispatchEvent(new KeyboardEvent('keydown',"
        f"{{key:{digit},code:'Digit'+{digit},altKey:true,shiftKey:true,bubbles:true}}));"
    )


def relay_script() -> str:
    """Return JavaScript that turns the relayed keys into the ones that viser listens to, unless they are meant for a widget."""
    table = {h.relayed: h.key for h in HOTKEYS if h.relayed}
    return (
        "(()=>{const to=" + repr(table) + ";"
        "addEventListener('keydown',e=>{"
        "const k=to[e.key]||to[e.key.toLowerCase()],t=e.target;"
        "if(!k||(e.ctrlKey||e.metaKey||e.altKey)&&!e.getModifierState('AltGraph'))return;"
        "if(t instanceof Element&&t.closest('input,textarea,select,[contenteditable=true],[role=slider],[role=tab],"
        "[role=listbox],[role=combobox],[role=dialog]'))return;"
        "e.preventDefault();e.stopImmediatePropagation();" + pressing("k") + "},true);})();"
    )


def help_html() -> str:
    """Return the table as HTML."""
    rows = "".join(
        f"<tr><td><kbd>{tr(h.shown) if h.shown in KEY_NAMES else h.shown}</kbd></td><td>{tr(h.text)}</td></tr>"
        for h in (*HOTKEYS, *LESSON_KEYS)
    )
    rows += f"<tr><td><kbd>1</kbd> … <kbd>5</kbd></td><td>{tr('lesson: your answer')}</td></tr>"
    rows += f"<tr><td><kbd>Ctrl K</kbd></td><td>{tr('every command by name')}</td></tr>"
    links = " · ".join(
        f'<a href=".{PREFIX}{name}?lang={spoken().language}" target="_blank">{tr(title)}</a>'
        for name, (_, title) in DOCUMENTS.items()
    )
    return f"<table>{rows}</table><p>{tr('To read')}: {links}</p>"
