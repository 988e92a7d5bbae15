"""Structure of a lesson file, with line numbers."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Final, TypeVar

T = TypeVar("T")
U = TypeVar("U")

SECTIONS: Final = ("Goal", "Predict", "Do", "Observe", "Explain", "Challenge", "Hints", "Belief")

HEAD_SECTIONS: Final = ("Promise", "Learned", "Again")

_FENCE: Final = re.compile(r"^ {0,3}(`{3,}|~{3,})\s*([\w-]*)\s*$")
_HEADING: Final = re.compile(r"^(#{1,6})\s+(.*?)\s*#*\s*$")
ITEM: Final = re.compile(r"^ {0,3}(\d{1,3})[.)]\s+(\S.*)$")

_QUOTE: Final = re.compile(r"^\s*>\s?(.*)$")


class Fault(Exception):
    """A fault of a file. `line`: 1-based."""

    def __init__(self, line: int, message: str, others: "Iterable[Fault]" = ()) -> None:
        super().__init__(message)
        self.line, self.message = line, message
        self.all: tuple[Fault, ...] = (self, *others)


class FaultLog:
    """Collects faults; failed reads are left out or replaced."""

    def __init__(self) -> None:
        self.found: list[Fault] = []

    def take(self, read: Callable[[], T], otherwise: U) -> T | U:
        try:
            return read()
        except Fault as fault:
            self.found += fault.all
            return otherwise

    def all_of(self, reads: Iterable[Callable[[], T]]) -> tuple[T, ...]:
        return tuple(read for read in (self.take(one, None) for one in reads) if read is not None)

    def close(self) -> None:
        """Raise the faults, ordered by line."""
        if self.found:
            first, *others = sorted(self.found, key=lambda fault: fault.line)
            raise Fault(first.line, first.message, (Fault(one.line, one.message) for one in others))


@dataclass
class DataBlock:
    """Content of a fenced block; `line`: its first line."""

    line: int
    lines: list[str] = field(default_factory=list)


@dataclass
class SheetPart:
    """Lines under a heading; `line`: that of the heading."""

    title: str
    line: int
    lines: list[str] = field(default_factory=list)
    blocks: list[DataBlock] = field(default_factory=list)

    @property
    def text(self) -> str:
        return "\n".join(self.lines).strip()


@dataclass
class Chapter(SheetPart):
    """A step, or the part under the title."""

    sections: dict[str, SheetPart] = field(default_factory=dict)


@dataclass
class Sheet:
    """A whole file."""

    head: Chapter
    steps: list[Chapter]


@dataclass(frozen=True)
class Item:
    """Entry of a numbered list, with its quoted lines."""

    text: str
    quote: str
    line: int


def read_sheet(text: str) -> Sheet:
    """Parse a lesson.

    Raises:
        Fault: a heading is missing or misplaced, or a fence is open.
    """
    log, steps = FaultLog(), list[Chapter]()
    # The title is empty until it is read.
    head = Chapter("", 1)
    here: SheetPart = head
    fence, opened, into = "", 0, here.lines
    for number, line in enumerate(text.splitlines(), 1):
        found, heading = _FENCE.match(line), _HEADING.match(line)
        if fence:
            closes = (
                found is not None and not found[2] and found[1][0] == fence[0] and len(found[1]) >= len(fence)
            )
            if not closes or into is here.lines:
                into.append(line)
            if closes:
                fence = ""
        elif found is not None:
            if not head.title:
                raise Fault(
                    number, "a block stands before the title; begin the file with a line like “# Title”."
                )
            fence, opened, into = found[1], number, here.lines
            if found[2] == "duet":
                block = DataBlock(number + 1)
                (steps[-1] if steps else head).blocks.append(block)
                into = block.lines
            else:
                into.append(line)
        elif heading is None:
            if line.strip() and not head.title:
                raise Fault(
                    number, "text stands before the title; begin the file with a line like “# Title”."
                )
            here.lines.append(line)
        elif not (title := heading[2].strip()):
            log.found.append(Fault(number, "the heading has no text; write a title behind the #."))
        elif (level := len(heading[1])) == 1 and not head.title:
            here = head = Chapter(title, number)
        elif not head.title:
            raise Fault(number, "a step stands before the title; begin the file with a line like “# Title”.")
        elif level <= 2:
            if level == 1:
                log.found.append(
                    Fault(
                        number, "there is a second title; a file holds one lesson, its steps begin with ##."
                    )
                )
            here = Chapter(title, number)
            steps.append(here)
        elif level == 3:
            chapter, known = (steps[-1], SECTIONS) if steps else (head, HEAD_SECTIONS)
            here = log.take(partial(_section, chapter, known, title, number), SheetPart(title, number))
        else:
            here.lines.append(line)
    if fence:
        log.found.append(
            Fault(opened, f"the block that begins here is never closed; end it with a line {fence}.")
        )
    log.close()
    if not head.title:
        raise Fault(1, "there is no title; begin the file with a line like “# Title”.")
    if not steps:
        raise Fault(head.line, "the lesson has no step; begin one with a line like “## First step”.")
    return Sheet(head, steps)


def _section(chapter: Chapter, known: tuple[str, ...], title: str, number: int) -> SheetPart:
    if title not in known:
        raise Fault(number, f"there is no section “{title[:40]}” here; choose from {', '.join(known)}.")
    if title in chapter.sections:
        raise Fault(number, f"the section “{title}” is there twice; write each once.")
    if chapter.sections and known.index(title) < max(known.index(name) for name in chapter.sections):
        raise Fault(number, f"“{title}” comes too late; the order is {', '.join(known)}.")
    chapter.sections[title] = SheetPart(title, number)
    return chapter.sections[title]


def read_items(part: SheetPart) -> tuple[str, tuple[Item, ...]]:
    """Text before a numbered list, and its entries.

    Raises:
        Fault: the numbers are not 1, 2, 3 …, or text follows a quote.
    """
    before: list[str] = []
    items: list[tuple[list[str], list[str], int]] = []
    for number, line in enumerate(part.lines, part.line + 1):
        entry, quote = ITEM.match(line), _QUOTE.match(line)
        if entry is not None:
            if int(entry[1]) != len(items) + 1:
                raise Fault(
                    number, f"the list says {entry[1]} where {len(items) + 1} comes next; number it 1, 2, 3 …"
                )
            items.append(([entry[2].strip()], [], number))
        elif not items:
            before.append(line)
        elif quote is not None:
            items[-1][1].append(quote[1].strip())
        elif line.strip():
            if items[-1][1]:
                raise Fault(
                    number,
                    "text follows the reply of an answer; write > before it, or put it into the next section.",
                )
            items[-1][0].append(line.strip())
    made = tuple(Item(" ".join(text), "\n".join(reply).strip(), line) for text, reply, line in items)
    return "\n".join(before).strip(), made
