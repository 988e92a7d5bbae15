"""The experiments, each declared once: everything else that knows the experiments by name is made from these entries.

An experiment is a `Scenario` of `scenes.roles`, its entry here, and its words in `app.text.experiment_texts`. Nothing here loads a library.
"""

from dataclasses import dataclass
from typing import Final, Literal

Obstacle = Literal["nothing", "ball", "arm", "task"]
"""What there is to keep clear of; with "task", a first task that the settings choose, see `scenes.quantities`."""

Moved = Literal["arm", "ball", "person"]
"""What the visitor moves: an arm, the ball, or the figure of the person who is imitated."""

Followed = Literal["nothing", "arm", "person"]
"""Who leads the joints of the arm that plots and numbers show; with "nothing", its task is about its hand."""


@dataclass(frozen=True)
class Experiment:
    """What the arms and the person do in a room.

    Attributes:
        name: on the command line, in links and in files.
        label: what a person reads in the picker.
        short: the same where there is little room.
        made_by: its class, "file:Name" in `scenes`.
        obstacle, moves, follows: see `Obstacle`, `Moved` and `Followed`.
        reads: keys of settings that have an effect in some experiments only, and in this one.
        both_avoid: whether both arms keep clear in the paper.
        for_two: whether a second person can hold the arm that keeps its place.
        maps: whether distance and error are mapped over n and v, see `scenes.sweep`.
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
        """Unit of the squared error that is recorded."""
        return "m²" if self.follows == "nothing" else "rad²"


SOLO: Final = "solo"
BALL: Final = "ball"
HOLD: Final = "hold"
MASTER_SLAVE: Final = "master_slave"
IMITATION: Final = "imitation"
FIRST_TASK: Final = "first_task"
"""Those that figures, tests of laws and benchmarks are made of."""

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
"""Name → experiment, in the order of the picker."""
