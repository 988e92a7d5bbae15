"""Marks and feedback for hand-ins."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands() -> Mapping[str, Command]:
    from app.features.marks.command import Grade, grade

    return {"grade": Command(Grade, grade, "teach")}


MARKS: Final = Feature("marks", texts=Path(__file__).parent, commands=_commands)
