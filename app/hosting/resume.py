"""Progress that outlives a reload or a dropped connection: kept at the server for ten minutes under a word that the tab remembers."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Final

from app.lessons.session.lesson_session import LessonSession
from app.lessons.session.saved import SavedLesson
from app.settings import WHOLE
from controllers.errors import LazyText

KEEP: Final = 600.0
"""How long progress is kept after a visitor has gone [s]."""

MOST: Final = 300
"""Visitors whose progress is kept at once; the oldest ones make room."""

_WORD: Final = re.compile(r"^[a-z0-9]{16,64}$")


@dataclass(frozen=True)
class _Progress:
    saved: SavedLesson
    link: tuple[str, str]
    since: float


def word_of(query: Mapping[str, str]) -> str | None:
    """Return the word that a tab remembers; None if it brings none that could be one of ours."""
    word = query.get("resume", "")
    return word if _WORD.match(word) else None


def link_of(query: Mapping[str, str]) -> tuple[str, str]:
    """Return which lesson and step a link asks for, as text."""
    return query.get("lesson", "")[:60], query.get("step", "")[:8]


class ProgressStore:
    """What visitors who have gone left behind."""

    def __init__(self) -> None:
        self._kept: dict[str, _Progress] = {}

    def keep(self, query: Mapping[str, str], saved: SavedLesson | None, now: float | None = None) -> None:
        """Keep what a visitor who came with a query has done; nothing if there is nothing, or nobody to give it back to."""
        word = word_of(query)
        if word is None or saved is None:
            return
        now = monotonic() if now is None else now
        self._kept.pop(word, None)
        self._kept[word] = _Progress(saved, link_of(query), now)
        self._forget(now)

    def find(self, query: Mapping[str, str], now: float | None = None) -> tuple[SavedLesson, bool] | None:
        """Return what a visitor left behind, and whether they come by the same link, so that they are to be where they were."""
        self._forget(monotonic() if now is None else now)
        kept = self._kept.get(word_of(query) or "")
        return None if kept is None else (kept.saved, kept.link == link_of(query))

    def _forget(self, now: float) -> None:
        for word, kept in list(self._kept.items()):
            if now - kept.since > KEEP or len(self._kept) > MOST:
                del self._kept[word]


def open_link(run: LessonSession, query: Mapping[str, str], found: tuple[SavedLesson, bool] | None) -> tuple[str, ...]:
    """Open what a link, or what was kept, asks for; return a message for every part of the link that is not possible."""
    lesson, step = link_of(query)
    if found is not None:
        saved, same = found
        run.resume(saved, reopen=same)
        if same:
            return ()
    if not lesson:
        return (LazyText("step = {step} has a meaning with lesson = … only.", step=step),) if step else ()
    place, problem = step_of(step)
    index: int | str = int(lesson) if lesson.isascii() and lesson.isdecimal() else lesson
    if isinstance(index, int):
        numbers = [one.number for one in run.book.lessons]
        if index not in numbers:
            return (_unknown(lesson, map(str, numbers)),)
        index = numbers.index(index)
    elif all(one.id != index for one in run.book.lessons):
        return (_unknown(lesson, (one.id for one in run.book.lessons)),)
    run.enter(index, place)
    if query.get(WHOLE) == "1":
        run.vary(query)
    return (problem,) if problem else ()


def _unknown(lesson: str, known: Iterable[str]) -> LazyText:
    there_are = ", ".join(known) or LazyText("none: the folder holds no lesson")
    return LazyText("There is no lesson {id}; choose from {names}.", id=lesson, names=there_are)


def step_of(text: str) -> tuple[int, str]:
    """Return a step from 0 and what is wrong with its text, "" if nothing."""
    if not text:
        return 0, ""
    if text.isascii() and text.isdecimal() and int(text) >= 1:
        return int(text) - 1, ""
    return 0, LazyText("step = {step} is no number; the first step is 1.", step=text)
