"""The keys of an open lesson."""

from typing import Final

import viser

from app.features.lessons.session.lesson_actions import LessonAction, Press
from app.i18n.speaking import N_
from app.page.panels.hotkeys import Hotkey, KeyHelp, KeyRange
from scenes.experiments import EXPERIMENTS

LESSON_KEYS: Final[tuple[Hotkey[LessonAction], ...]] = (
    Hotkey("next", Press("next"), "N", N_("lesson: continue"), "N", icon=viser.Icon.ARROW_RIGHT),
    Hotkey("back", Press("back"), "B", N_("lesson: go back"), "B", icon=viser.Icon.ARROW_LEFT),
    Hotkey("check", Press("check"), "C", N_("lesson: check the challenge"), "C", icon=viser.Icon.CHECKS),
    Hotkey("hint", Press("hint"), "H", N_("lesson: the next hint"), "H", icon=viser.Icon.BULB),
    Hotkey(
        "why", Press("why"), "Y", N_("lesson: the run that shows why"), "Y", icon=viser.Icon.QUESTION_MARK
    ),
    Hotkey("leave", Press("leave"), "X", N_("lesson: leave the lessons"), "X", icon=viser.Icon.X),
)
"""← and → are back and next only if the hand cannot move."""


def key_help() -> tuple[KeyHelp, ...]:
    return *LESSON_KEYS, KeyRange("1", str(min(len(EXPERIMENTS), 9)), N_("lesson: your answer"))
