"""The laws, each declared once: everything else that knows the laws by name is made from these entries.

A law is a class in `controllers.laws`, its entry here, and its words in `app.text.law_texts`. Nothing here loads a library.
"""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

Budget = Literal["share", "switch", "avoidance", "task", "push", "correction"]
"""What a law makes of retreat v and pull u along the line of contact: λ v − (1 − λ) u; one of the two, by a switch; v alone; −u alone; −u
and a push away; −u, held back by as much as it must be."""

Sees = Literal["nothing", "one row", "all pairs"]
"""What a law looks at: nothing at all, one distance with its row, or every pair of bodies."""


class Knob(NamedTuple):
    """A setting that trades the hand's error for distance.

    Attributes:
        key: of the setting.
        points: values of it to compare, ascending, SI.
        feed_forward: whether the law knows the obstacle's speed w.
        ahead: how far d_0 stays ahead of d_m where that is turned [m]; 0 where d_0 does not follow.
    """

    key: str
    points: tuple[float, ...]
    feed_forward: bool = False
    ahead: float = 0.0

    def settings(self, value: float) -> dict[str, float]:
        """Return key → value of all that is set with it."""
        return {self.key: value, **({"d0": value + self.ahead} if self.ahead else {})}


@dataclass(frozen=True)
class LawEntry:
    """A law.

    Attributes:
        name: on the command line, in links and in files.
        label: what a person reads in the picker.
        short: the same where there is little room.
        made_by: its class, "file:Name" in `controllers.laws`.
        reads: keys of the law's settings that the class takes, as arguments with the names of their fields.
        budget: see `Budget`.
        sees: see `Sees`.
        knobs: of its comparison with others at equal distance; none if its distance cannot be chosen.
        rests: whether there is a closed form of the distance at which it rests, from d_m, n and v.
        promises: whether the promise of `scenes.promise` is made for it.
        of_section_iii: whether it is eq. (12), of which section III of the paper shows the stability.
        in_null_space: whether it divides by what the hand leaves of J_d.
        in_league: whether the league plays it; not what is another law with every curve or every hand.
        offered_first: whether a short list of laws has it.
    """

    name: str
    label: str
    short: str
    made_by: str
    reads: tuple[str, ...]
    budget: Budget
    sees: Sees = "one row"
    knobs: tuple[Knob, ...] = ()
    rests: bool = False
    promises: bool = False
    of_section_iii: bool = False
    in_null_space: bool = False
    in_league: bool = True
    offered_first: bool = False

    @property
    def settings(self) -> frozenset[str]:
        """Keys of all law's settings that have an effect under it: what it reads, and how that is measured."""
        measured = {"nothing": (), "one row": ("pairs", "beta", "eps", "coupled"), "all pairs": ("coupled",)}[self.sees]
        return frozenset({*self.reads, *measured})

    @property
    def has_barrier(self) -> bool:
        """Whether it lets d fall to d_m at γ (d − d_m) at most."""
        return "gamma" in self.reads

    @property
    def retreats(self) -> bool:
        """Whether it retreats at v, so that an obstacle faster than that comes nearer."""
        return "v" in self.reads

    @property
    def distance_knob(self) -> Knob | None:
        """The setting by which its distance is chosen; None if none does."""
        return self.knobs[0] if self.knobs else Knob("dm", ()) if "dm" in self.reads else None


DEFAULT_LAW: Final = "smooth_priority"
"""The paper's own law."""

NO_AVOIDANCE: Final = "unprotected"
"""The law that does nothing."""

BARRIER_LAW: Final = "barrier_qp"
"""The law that other projects have, too."""

DRAWN_LAW: Final = "drawn_curve"
"""The law of which a person draws λ(d)."""

LEVER_LAW: Final = "lever"
"""The law of which a person's hand is λ."""

_DISTANCES: Final = (0.06, 0.09, 0.12, 0.15, 0.19, 0.24, 0.30)
_REACHES: Final = (0.16, 0.20, 0.25, 0.30, 0.40, 0.60)

LAWS: Final[dict[str, LawEntry]] = {
    law.name: law
    for law in (
        LawEntry(
            DEFAULT_LAW, "Smooth priority (paper)", "Smooth priority", "smooth_priority:SmoothPriority",
            ("dm", "n", "v", "ff", "one_sided"), "share", rests=True, promises=True, of_section_iii=True, offered_first=True,
            knobs=(Knob("dm", _DISTANCES), Knob("v", (0.05, 0.10, 0.20, 0.30, 0.50, 0.80)), Knob("dm", _DISTANCES, True)),
        ),
        LawEntry(
            "strict_priority", "Strict priority, always on", "Strict, always on", "strict_priority:StrictPriority",
            ("v",), "avoidance",
        ),
        LawEntry(
            "strict_switched", "Strict priority, switched at d_m", "Strict, switched", "strict_priority:StrictPriority",
            ("dm", "v"), "switch", offered_first=True,
        ),
        LawEntry(
            "null_space_avoidance", "Null-space avoidance", "Null-space avoidance", "null_space_avoidance:NullSpaceAvoidance",
            ("dm", "d0", "v"), "share", knobs=(Knob("d0", _REACHES),), in_null_space=True,
        ),
        LawEntry(
            "potential_field", "Potential field", "Potential field", "potential_field:PotentialField",
            ("d0", "eta"), "push", knobs=(Knob("eta", (0.0005, 0.001, 0.002, 0.005, 0.015, 0.05)),),
        ),
        LawEntry(
            BARRIER_LAW, "Barrier QP, all pairs", "Barrier QP", "barrier_qp:BarrierQP",
            ("dm", "gamma", "ff"), "correction", sees="all pairs",
            knobs=(Knob("dm", _DISTANCES), Knob("gamma", (0.2, 0.5, 1.0, 2.0, 5.0, 20.0)), Knob("dm", _DISTANCES, True)),
        ),
        LawEntry(
            "intermediate_value", "Intermediate value", "Intermediate value", "intermediate_value:IntermediateValue",
            ("dm", "n", "v"), "share", knobs=(Knob("dm", _DISTANCES),), rests=True,
        ),
        LawEntry(
            "task_activation", "Task activation in a hierarchy", "Task activation", "task_activation:TaskActivation",
            ("dm", "d0", "v"), "share", knobs=(Knob("dm", _DISTANCES, ahead=0.15),),
        ),
        LawEntry(
            "continuous_inverse", "Continuous inverse of a stack", "Continuous inverse", "continuous_inverse:ContinuousInverse",
            ("dm", "n", "v"), "share", knobs=(Knob("dm", _DISTANCES),), in_null_space=True,
        ),
        LawEntry(
            "hierarchical_inverse", "Continuous inverse of a hierarchy", "Hierarchical inverse",
            "hierarchical_inverse:HierarchicalInverse", ("dm", "n", "v"), "share", knobs=(Knob("dm", _DISTANCES),), rests=True,
        ),
        LawEntry(
            "lexicographic_qp", "Lexicographic QP, hand second", "Lexicographic QP", "lexicographic_qp:LexicographicQP",
            ("dm", "gamma", "ff"), "correction", sees="all pairs", knobs=(Knob("dm", _DISTANCES), Knob("dm", _DISTANCES, True)),
        ),
        LawEntry(
            "set_based_task", "Set-based task, jumps at d_m", "Set-based task", "set_based_task:SetBasedTask",
            ("dm", "kr", "ff"), "correction",
            knobs=(Knob("dm", _DISTANCES), Knob("kr", (0.0, 1.0, 5.0, 15.0, 40.0)), Knob("dm", _DISTANCES, True)),
        ),
        LawEntry(
            DRAWN_LAW, "Drawn curve (your own λ)", "Drawn curve", "drawn_curve:DrawnCurve", ("curve", "v"), "share",
            in_league=False,
        ),
        LawEntry(
            LEVER_LAW, "Lever (you are λ)", "Lever", "hand_lever:HandLever", ("lever", "v"), "share",
            in_league=False, offered_first=True,
        ),
        LawEntry(
            NO_AVOIDANCE, "Unprotected (task only)", "Unprotected", "unprotected:Unprotected",
            (), "task", sees="nothing", of_section_iii=True, offered_first=True,
        ),
    )
}  # fmt: skip
"""Name → law, in the order of the picker."""
