"""Limits of a student's law, and its problems."""

from dataclasses import dataclass
from typing import NamedTuple

from controllers.errors import LazyText


@dataclass(frozen=True)
class LawLimits:
    """Time and memory for the process of a law.

    Attributes:
        start: time until the process is up, before it has seen the file [s]; nothing that the file could do anything about.
        load: time for reading the file, and for the first call, which may have to load a library [s].
        call: time for every further call [s].
        memory: what it may take in addition to Python and NumPy [bytes].
    """

    start: float = 30.0
    load: float = 3.0
    call: float = 0.05
    memory: int = 512 * 2**20


class LawProblem(NamedTuple):
    """Why a law is not in force.

    Attributes:
        text: one line for its author: file, line if it is known, what is wrong, what was expected.
        line: of the file, counted from 1; None if unknown.
    """

    text: str
    line: int | None = None


def problem_of(name: str, what: str, line: int | None = None) -> LawProblem:
    if line is None:
        return LawProblem(LazyText("{name}: {what}", name=name, what=what))
    return LawProblem(LazyText("{name}, line {line}: {what}", name=name, line=line, what=what), line)
