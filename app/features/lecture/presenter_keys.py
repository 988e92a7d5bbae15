"""Hotkeys of teachers, and of projectors with their key."""

from typing import Final, Literal

import viser

from app.i18n.speaking import N_
from app.page.panels.hotkeys import Hotkey

PresenterAction = Literal["on", "back", "blank", "freeze", "hide"]

PRESENTER_KEYS: Final[tuple[Hotkey[PresenterAction], ...]] = (
    Hotkey(
        "present_next",
        "on",
        "Page ↓",
        N_("class: the next thing on the screen"),
        "pagedown",
        icon=viser.Icon.ARROW_DOWN,
    ),
    Hotkey(
        "present_back", "back", "Page ↑", N_("class: the thing before"), "pageup", icon=viser.Icon.ARROW_UP
    ),
    Hotkey(
        "present_blank", "blank", "B", N_("class: the screen black, or live"), "B", icon=viser.Icon.EYE_OFF
    ),
    Hotkey(
        "present_freeze",
        "freeze",
        "F",
        N_("class: the screen frozen, or live"),
        "F",
        icon=viser.Icon.SNOWFLAKE,
    ),
    # Pressed by the address's script, `page_overlay.js`.
    Hotkey(
        "present_hide",
        "hide",
        "Esc",
        N_("class: the address away"),
        "9",
        relayed="Escape",
        icon=viser.Icon.QRCODE_OFF,
    ),
)
"""They replace the keys' usual meaning."""

CLICKER_KEYS: Final[tuple[Hotkey[PresenterAction], ...]] = (
    *PRESENTER_KEYS,
    Hotkey("clicker_next", "on", "→", N_("class: the next thing on the screen"), "5", relayed="ArrowRight"),
    Hotkey("clicker_back", "back", "←", N_("class: the thing before"), "4", relayed="ArrowLeft"),
    Hotkey("clicker_blank", "blank", ".", N_("class: the screen black, or live"), "1", relayed="."),
)
"""Also those that some clickers send."""
