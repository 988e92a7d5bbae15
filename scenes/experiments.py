"""An experiment is a `Scenario` of `scenes.roles`, its entry here, its texts in `app.text.experiment_texts`.

Loads no library.
"""

from dataclasses import dataclass
from typing import Final, Literal

Obstacle = Literal["nothing", "ball", "arm", "task"]
"""With "task", the settings choose one of `scenes.quantities`."""

Moved = Literal["arm", "ball", "person"]
"""With "person", the visitor moves the imitated figure."""

Followed = Literal["nothing", "arm", "person"]
"""Leader of the plotted arm's joints; with "nothing", its task concerns its hand."""

Series = Literal["usual", "first-tasks", "world"]
"""Random runs: of all experiments except another first task; of that one; of the former again, with arms
that glide along things and distant hand targets.
"""


@dataclass(frozen=True)
class Experiment:
    """Entry of `EXPERIMENTS`.

    Attributes:
        name: in commands, links and files.
        label: in the picker.
        made_by: its class, "file:Name" in `scenes`.
        reads: keys of settings that only some experiments use, including this one.
        both_avoid: both arms keep clear in the paper.
        for_two: a second person can hold the arm that keeps its place.
        maps: has maps over n and v, see `scenes.sweep`.
    """

    name: str
    label: str
    short: str
    made_by: str
    obstacle: Obstacle
    moves: Moved
    follows: Followed
    reads: tuple[str, ...]
    both_avoid: bool = False
    for_two: bool = False
    maps: bool = False

    @property
    def error_unit(self) -> str:
        return "m²" if self.follows == "nothing" else "rad²"


SOLO: Final = "solo"
BALL: Final = "ball"
HOLD: Final = "hold"
MASTER_SLAVE: Final = "master_slave"
IMITATION: Final = "imitation"
FIRST_TASK: Final = "first_task"

EXPERIMENTS: Final[dict[str, Experiment]] = {
    experiment.name: experiment
    for experiment in (
        Experiment(
            SOLO, "One arm alone (eqs 1–8)", "one arm alone", "solo:Solo", "nothing", "arm", "nothing",
            ("robot", "task", "path", "kx"),
        ),
        Experiment(
            BALL, "A ball in the way (Fig. 1)", "a ball in the way", "ball:BallInTheWay", "ball", "ball", "nothing",
            ("robot", "task", "point", "ball"),
        ),
        Experiment(
            HOLD, "Hold (Fig. 5)", "hold", "two_arms:Hold", "arm", "arm", "nothing",
            ("robot", "rig", "guided", "task", "start"), for_two=True, maps=True,
        ),
        Experiment(
            MASTER_SLAVE, "Master and slave (Fig. 6)", "master and slave", "two_arms:MasterSlave", "arm", "arm", "arm",
            ("robot", "rig", "guided", "following"), both_avoid=True,
        ),
        Experiment(
            IMITATION, "Imitation (Figs 7, 8)", "imitation", "imitation:Imitation", "arm", "person", "person",
            ("clip",), both_avoid=True,
        ),
        Experiment(
            FIRST_TASK, "Another first task (eqs 9–13)", "another first task", "first_task.scenario:AnotherFirstTask",
            "task", "arm", "nothing", ("first", "together", "load", "task"),
        ),
    )
}  # fmt: skip
