"""Lessons on paper: pages to print, with a teacher's copy, and questions for Moodle."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands(features: Sequence[Feature]) -> Mapping[str, Command]:
    del features
    from app.features.handout.command import Handout, handout

    return {"handout": Command(Handout, handout)}


HANDOUT: Final = Feature("handout", texts=Path(__file__).parent, commands=_commands)
