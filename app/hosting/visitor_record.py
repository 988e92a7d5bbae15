"""What a visitor leaves behind, and the id of the tab under which it is found again."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from app.export.class_summary import ClassSummary, HandIn
from app.lessons.session.saved import SavedLesson
from app.lessons.tally import QuestionId
from app.plots.curve_chart import Curve
from app.session.session_state import SessionState
from app.settings import Settings

_TAB_ID: Final = re.compile(r"^[a-z0-9]{16,64}$")

_OF_THE_TAB: Final = ("resume", "window", "key")
"""Parts of a query that describe the tab and its visitor, and not what it shows."""


def tab_id(query: Mapping[str, str]) -> str | None:
    """Return the id that a tab keeps in its browser's storage; None if its query carries no valid one."""
    word = query.get("resume", "")
    return word if _TAB_ID.match(word) else None


def same_tab(query: Mapping[str, str], other: Mapping[str, str]) -> bool:
    """Return whether two queries come from the same tab with the same link."""
    return tab_id(query) is not None and tab_id(query) == tab_id(other) and link_of(query) == link_of(other)


def lesson_link(query: Mapping[str, str]) -> tuple[str, str]:
    """Return lesson and step of a link, as text."""
    return query.get("lesson", "")[:60], query.get("step", "")[:8]


def link_of(query: Mapping[str, str]) -> dict[str, str]:
    """Return the parts of a query that say what it shows."""
    return {key: value for key, value in query.items() if key not in _OF_THE_TAB}


@dataclass(frozen=True)
class ClassRecord:
    """What a class would lose with its server, besides the stage.

    Attributes:
        saved: when it was so [s since 1970].
        ballots: question → id of a student's tab → choice and drawn curve.
        revealed: the questions with a tally that everybody sees.
        free: whether the students explore.
        leader: id of the tab that leads; None for none.
        students: ids of the tabs that do not lead.
        earlier: question → the ballots of its rounds before the newest one, oldest first.
        passed: lesson and step → ids of the tabs that have passed the challenge.
        hand_ins: the reports that were handed in, by the id of a student's tab.
    """

    saved: float
    ballots: Mapping[QuestionId, Mapping[str, tuple[int | None, Curve]]]
    revealed: tuple[QuestionId, ...]
    free: bool
    leader: str | None
    students: tuple[str, ...]
    # Absent from the records of earlier versions.
    earlier: Mapping[QuestionId, tuple[Mapping[str, tuple[int | None, Curve]], ...]] = field(default_factory=dict)
    passed: Mapping[QuestionId, tuple[str, ...]] = field(default_factory=dict)
    hand_ins: Mapping[str, HandIn] = field(default_factory=dict)


@dataclass(frozen=True)
class VisitorRecord:
    """What a visitor can come back to, as plain data that does not change.

    Attributes:
        lessons: progress in the lessons; None if none was ever opened.
        state: where the session was; None if it cannot go on from there.
        room: of the class, where the visitor is the stage of a lecture.
        last_class: what the class before has left behind, likewise.
    """

    query: Mapping[str, str]
    settings: Settings
    lessons: SavedLesson | None
    state: SessionState | None = None
    room: ClassRecord | None = None
    last_class: ClassSummary | None = None
