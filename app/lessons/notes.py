"""The teacher's notes to a lesson, step by step: Markdown in which `## 2. …` begins what belongs to the second step."""

import re
from typing import Final, NamedTuple

_STEP: Final = re.compile(r"^## +(\d{1,3})\b[.:]? *(.*)$")


class StepNotes(NamedTuple):
    """What is for one step.

    Attributes:
        number: of the step, from 1.
        title: as the teacher reads it; may be empty.
    """

    number: int
    title: str
    text: str


class Notes(NamedTuple):
    """What a file of notes says.

    Attributes:
        title: of the whole; may be empty.
        text: Markdown, about the whole lesson; may be empty.
        steps: in the order of the file.
    """

    title: str
    text: str
    steps: tuple[StepNotes, ...]


def read_notes(text: str) -> Notes:
    """Return the parts of a file of notes; whatever is under no step's heading is about the whole lesson. Never raises."""
    parts: list[tuple[int, str, list[str]]] = [(0, "", [])]
    for line in text.strip().splitlines():
        found = _STEP.match(line)
        if found is None:
            parts[-1][2].append(line)
        else:
            parts.append((int(found[1]), found[2].strip(), []))
    whole = parts[0][2]
    title = re.sub("^#+ *", "", whole[0]) if whole and whole[0].startswith("#") else ""
    about = "\n".join(whole[1:] if title else whole).strip()
    return Notes(title, about, tuple(StepNotes(number, name, "\n".join(lines).strip()) for number, name, lines in parts[1:]))
