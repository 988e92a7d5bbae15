"""In which order lessons are shown: ours and a folder's, a test before and after them, or what a playlist names."""

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
            "lessons", 'a playlist needs a list of names, like lessons = ["drift", "lambda#tail", "mine/01-nearer.md"].'
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
    merged: list[tuple[str, Lesson]] = []
    for lesson, step in entries:
        before = [one for name, one in merged if name == lesson.id]
        twice = sum(other.id == lesson.id and part is None for other, part in entries) > 1
        if lesson.again and step is None and twice and not any(one.asked == "last" for one in before):
            made = asked(lesson, any(one.asked == "first" for one in before))
        elif step is not None and _takes(merged, lesson, step):
            _, last = merged.pop()
            made = replace(last, steps=(*last.steps, step))
        else:
            # No file has a name with an underscore.
            id = f"{lesson.id}_{len(before) + 1}" if before else lesson.id
            made = replace(lesson, id=id, steps=lesson.steps if step is None else (step,))
        merged.append((lesson.id, made))
    yield from (replace(lesson, number=number) for number, (_, lesson) in enumerate(merged, 1))


def _takes(merged: list[tuple[str, Lesson]], lesson: Lesson, step: Step) -> bool:
    """Return whether the newest lesson goes on with a step."""
    return bool(merged) and merged[-1][0] == lesson.id and not merged[-1][1].asked and step not in merged[-1][1].steps
