from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands() -> Mapping[str, Command]:
    from app.features.bench.command import Bench, bench

    return {"bench": Command(Bench, bench, "compute")}


BENCH: Final = Feature("bench", texts=Path(__file__).parent, commands=_commands)
