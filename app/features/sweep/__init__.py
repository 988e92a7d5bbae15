"""Sweeps over a grid of settings."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands() -> Mapping[str, Command]:
    from app.features.sweep.command import Sweep, sweep

    return {"sweep": Command(Sweep, sweep, "compute")}


SWEEP: Final = Feature("sweep", texts=Path(__file__).parent, commands=_commands)
