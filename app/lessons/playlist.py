"""In which order lessons are shown: ours and a folder's, a test before and after them, or what a playlist names."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

from app.lessons.blocks import read_block
from app.lessons.lesson import LAST, Lesson, Step
from app.lessons.markdown import DataBlock

MOST_NAMES: Final = 200
"""In a playlist."""


def names_in(text: str) -> list[str]:
    """Return what a playlist names.

    Raises:
        Fault: it is no playlist.
    """
    table = read_block(DataBlock(1, text.splitlines()))
    names = table.any("lessons", [])
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise table.fault(
            "lessons", 'a playlist needs a list of names, like lessons = ["hold", "lambda#tail", "mine/01-nearer.md"].'
        )
    if len(names) > MOST_NAMES:
        raise table.fault("lessons", f"lessons names {len(names)}; at most {MOST_NAMES} are shown.")
    table.close()
    return names


def asked(lesson: Lesson, last: bool) -> Lesson:
    """Return a test as it is asked for the first time, or for the last."""
    steps = tuple(replace(step, asked="last" if last else "first") for step in lesson.steps)
    return replace(lesson, id=lesson.id + LAST, title=lesson.again, steps=steps) if last else replace(lesson, steps=steps)


def everything(lessons: Iterable[Lesson]) -> Iterator[Lesson]:
    """Yield all lessons, numbered from 1, between a test that is asked twice: the last one that there is."""
    known = list(lessons)
    test, others = next((one for one in reversed(known) if one.again), None), [one for one in known if not one.again]
    if test is not None:
        yield replace(asked(test, False), number=0)
    yield from (replace(lesson, number=number) for number, lesson in enumerate(others, 1))
    if test is not None:
        yield replace(asked(test, True), number=len(others) + 1)


def numbered(chosen: Iterable[tuple[Lesson, Step | None]]) -> Iterator[Lesson]:
    """Yield lessons from 1. Steps of one lesson that follow one another are one lesson; a test that comes twice is asked twice."""
    entries = list(chosen)
    merged: list[Lesson] = []
    for lesson, step in entries:
        twice = sum(other.id == lesson.id and part is None for other, part in entries) > 1
        if lesson.again and step is None and twice and all(one.id != lesson.id + LAST for one in merged):
            merged.append(asked(lesson, any(one.id == lesson.id for one in merged)))
        elif step is not None and merged and _plain(merged[-1].id) == lesson.id and step not in merged[-1].steps:
            merged[-1] = replace(merged[-1], steps=(*merged[-1].steps, step))
        else:
            times = sum(_plain(one.id) == lesson.id for one in merged)
            steps = lesson.steps if step is None else (step,)
            merged.append(replace(lesson, id=f"{lesson.id}-{times + 1}" if times else lesson.id, steps=steps))
    yield from (replace(lesson, number=number) for number, lesson in enumerate(merged, 1))


def _plain(id: str) -> str:
    """Return the name of a lesson without the number that tells it from the same one further up."""
    return re.sub(r"-\d+$", "", id)
