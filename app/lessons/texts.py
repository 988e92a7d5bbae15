"""Numbers inside the texts, filled in when they are shown: `{measured:drift}`, `{measured:drift:1}` (its first comparison),
`{measured:drift:ratio}` and `{setting:dm}`."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from app.lessons.lesson import Measurement, Step
from app.lessons.measures import Value
from app.lessons.runs import Setup, page_value
from app.settings import Settings
from scenes.files import path_inside
from scenes.settings import specs, values

_PICTURE: Final = re.compile(r"!\[([^\]]*)\]\(([^)]*)\)")
_FORMATS: Final = (".svg", ".png")
MOST_BYTES: Final = 300_000
"""Largest picture."""

_HOLE: Final = re.compile(r"\{(measured|setting):([^{}]*)\}")

Measured = Mapping[str, tuple[Value, ...]]
"""Identity of a measurement → its value, then those of its comparisons."""


def asks_for_numbers(text: str) -> bool:
    """Return whether a text has a measured number in it."""
    return any(kind == "measured" for kind, _ in _HOLE.findall(text))


def placeholder_problems(line: str, step: Step, before: bool = False) -> Iterator[str]:
    """Yield what is wrong with the placeholders of a line of a step's text.

    Args:
        before: whether the text is seen before the run, so that the outcome must not stand in it.
    """
    by_id = {m.id: m for m in step.measurements}
    for kind, name in _HOLE.findall(line):
        if kind == "setting":
            if name not in specs(Settings):
                yield f"{{setting:{name}}}: there is no such setting; choose from {', '.join(specs(Settings))}."
            continue
        id, _, number = name.partition(":")
        if id not in by_id:
            yield f"{{measured:{name}}}: the step measures no {id!r}; choose from {', '.join(by_id) or 'none: add [[measure]]'}."
        elif before and step.question is not None and id == step.measurements[0].id and number in ("", "ratio"):
            yield f"{{measured:{name}}} gives the answer away before the run; name a comparison, such as {{measured:{id}:1}}."
        elif number == "ratio" and by_id[id].compare:
            continue
        elif number and not (number.isdecimal() and 1 <= int(number) <= len(by_id[id].compare)):
            yield f"{{measured:{name}}}: {id} has {len(by_id[id].compare)} comparisons; number them from 1."


def picture_problems(line: str, folder: Path) -> Iterator[str]:
    """Yield what is wrong with the pictures of a line of text: `![what is seen](pictures/name.svg)`."""
    for description, name in _PICTURE.findall(line):
        path = path_inside(folder, name)
        if not description.strip():
            yield f"the picture {name[:60]!r} says nothing to those who do not see it; write what is seen into the [ ]."
        if path is None or path.suffix not in _FORMATS:
            yield f"{name[:60]!r} is no picture beside the lesson; it must be an .svg or .png in its folder or one below."
        elif not path.is_file():
            yield f"there is no picture {name[:60]!r} beside the lesson."
        elif path.stat().st_size > MOST_BYTES:
            yield f"the picture {name[:60]!r} is larger than {MOST_BYTES // 1000} kB; make it smaller."


def filled(text: str, measurements: tuple[Measurement, ...], measured: Measured, setup: Setup) -> str:
    """Return a text with its numbers in it; what is not known yet is a dash."""
    by_id = {m.id: m for m in measurements}

    def fill(hole: re.Match[str]) -> str:
        kind, name = hole[1], hole[2]
        if kind == "setting":
            found = values(setup.settings(Settings()))
            return page_value(name, found[name]) if name in found else "–"
        id, _, number = name.partition(":")
        known = measured.get(id, ())
        if number == "ratio":
            own, other = (*known, None, None)[:2]
            return f"{own / other:.2f}" if own is not None and other else "–"
        index = int(number) if number else 0
        value = known[index] if index < len(known) else None
        return by_id[id].text(value) if id in by_id else "–"

    return _HOLE.sub(fill, text)
