"""The league of laws: every law in the same runs, as tables, pictures and one page."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands(features: Sequence[Feature]) -> Mapping[str, Command]:
    del features
    from app.features.league.command import League, league

    return {"league": Command(League, league)}


LEAGUE: Final = Feature("league", texts=Path(__file__).parent, commands=_commands)
