"""The experiments by name."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from scenes import ball, hold, imitation, master_slave, solo
from scenes.roles import Roles, TargetSource
from scenes.settings import RunSettings, SceneName
from scenes.world import World


@dataclass(frozen=True)
class Experiment:
    """What is done in a room.

    Attributes:
        cast: who takes part.
        person: who moves what can be moved as long as nobody else does.
        error_unit: of the squared error that is recorded.
    """

    cast: Callable[[World, RunSettings], Roles]
    person: Callable[[World, RunSettings], TargetSource]
    error_unit: str = "m²"


EXPERIMENTS: Final[dict[SceneName, Experiment]] = {
    "solo": Experiment(solo.cast, solo.person),
    "ball": Experiment(ball.cast, ball.person),
    "hold": Experiment(hold.cast, hold.person),
    "master_slave": Experiment(master_slave.cast, master_slave.person, "rad²"),
    "imitation": Experiment(imitation.cast, imitation.person, "rad²"),
}
