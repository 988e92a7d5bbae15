from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands() -> Mapping[str, Command]:
    from app.features.handout.command import Handout, handout

    return {"handout": Command(Handout, handout, "teach")}


HANDOUT: Final = Feature("handout", texts=Path(__file__).parent, commands=_commands)
