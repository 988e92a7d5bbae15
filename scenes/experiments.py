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
        roles: makes the roles.
        source: the default source of targets, used while the user moves nothing.
        error_unit: of the squared error that is recorded.
    """

    roles: Callable[[World, RunSettings], Roles]
    source: Callable[[World, RunSettings], TargetSource]
    error_unit: str = "m²"


EXPERIMENTS: Final[dict[SceneName, Experiment]] = {
    "solo": Experiment(solo.roles, solo.source),
    "ball": Experiment(ball.roles, ball.source),
    "hold": Experiment(hold.roles, hold.source),
    "master_slave": Experiment(master_slave.roles, hold.source, "rad²"),
    "imitation": Experiment(imitation.roles, imitation.source, "rad²"),
}
