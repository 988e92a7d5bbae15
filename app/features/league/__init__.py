"""The league of laws."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature
from app.i18n.speaking import N_
from app.text.document_list import DocumentFile


def _commands() -> Mapping[str, Command]:
    from app.features.league.command import League, league

    return {"league": Command(League, league, "compute")}


_HERE: Final = Path(__file__).parent

_DOCUMENTS: Final = {"league": DocumentFile(_HERE / "league.md", N_("The league"))}

LEAGUE: Final = Feature("league", texts=_HERE, documents=_DOCUMENTS, commands=_commands)
