"""Whole sessions of visitors who are away: a dropped connection or a reload gives back the very session, where it was."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Final

from app.hosting.resume import KEEP, word_of
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session

MOST: Final = 8
"""Sessions kept at once; the oldest one makes room. Each holds the history of its run."""

_OF_THE_TAB: Final = ("resume", "window")
"""Parts of a query that tell about the tab, and not what it is to show."""


@dataclass(frozen=True)
class _Kept:
    session: Session
    lessons: LessonSession
    link: dict[str, str]
    since: float


def same_tab(query: Mapping[str, str], other: Mapping[str, str]) -> bool:
    """Return whether two visitors come from the same tab by the same link."""
    return word_of(query) is not None and word_of(query) == word_of(other) and _link_of(query) == _link_of(other)


def _link_of(query: Mapping[str, str]) -> dict[str, str]:
    return {key: value for key, value in query.items() if key not in _OF_THE_TAB}


class SessionStore:
    """Sessions of visitors who are away, under the word that each one's tab remembers. Used on the frame loop's thread only."""

    def __init__(self) -> None:
        self._kept: dict[str, _Kept] = {}

    def __len__(self) -> int:
        return len(self._kept)

    def leave(self, query: Mapping[str, str], session: Session, lessons: LessonSession, now: float | None = None) -> None:
        """Keep the session of a visitor who came with a query; close it if nobody could ever ask for it. It stands still meanwhile."""
        now = monotonic() if now is None else now
        word = word_of(query)
        if word is None:
            session.close()
            return
        session.hold(None)
        if word in self._kept:
            self._close(word)
        self._kept[word] = _Kept(session, lessons, _link_of(query), now)
        while len(self._kept) > MOST:
            self._close(next(iter(self._kept)))

    def fetch(self, query: Mapping[str, str], now: float | None = None) -> tuple[Session, LessonSession] | None:
        """Return what a visitor left who is back by the same link within `KEEP` seconds; else None, and what was left is closed."""
        self.tidy(now)
        word = word_of(query) or ""
        kept = self._kept.get(word)
        if kept is None:
            return None
        if kept.link != _link_of(query):
            self._close(word)
            return None
        del self._kept[word]
        return kept.session, kept.lessons

    def tidy(self, now: float | None = None) -> None:
        """Close what nobody has come back for."""
        now = monotonic() if now is None else now
        for word, kept in list(self._kept.items()):
            if now - kept.since <= KEEP:
                # They stand in the order in which they were left.
                return
            self._close(word)

    def close(self) -> None:
        """Close everything."""
        for word in list(self._kept):
            self._close(word)

    def _close(self, word: str) -> None:
        self._kept.pop(word).session.close()
