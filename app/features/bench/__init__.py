"""What a step and a visitor cost."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Final

from app.feature import Command, Feature


def _commands(features: Sequence[Feature]) -> Mapping[str, Command]:
    from app.features.bench.command import Bench, bench

    return {"bench": Command(Bench, partial(bench, features=features))}


BENCH: Final = Feature("bench", commands=_commands)
