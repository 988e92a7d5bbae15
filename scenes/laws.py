"""A law is a class in `controllers.laws`, its entry here, and its texts in `app.text.law_texts`.

Loads no library.
"""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

Budget = Literal["share", "switch", "avoidance", "task", "push", "correction"]
"""Retreat v and pull u along the line of contact give λ v − (1 − λ) u; v or −u by a switch; v; −u; −u and a
push away; or −u, reduced as far as necessary.
"""

Sees = Literal["nothing", "one row", "all pairs"]
"""Pairs whose distance and J_d a law uses."""


class Knob(NamedTuple):
    """A setting that trades the hand's error for distance.

    Attributes:
        points: values to compare, ascending, SI.
        feed_forward: the law knows the obstacle's speed w.
        ahead: d_0 − d_m while d_m varies [m]; 0 if d_0 does not follow.
    """

    key: str
    points: tuple[float, ...]
    feed_forward: bool = False
    ahead: float = 0.0

    def settings(self, value: float) -> dict[str, float]:
        return {self.key: value, **({"d0": value + self.ahead} if self.ahead else {})}


@dataclass(frozen=True)
class LawEntry:
    """Entry of `LAWS`.

    Attributes:
        name: in commands, links and files.
        label: in the picker.
        made_by: its class, "file:Name" in `controllers.laws`.
        reads: keys of law settings, also the class's arguments.
        knobs: for comparisons at equal distance; () if its distance cannot be chosen.
        rests: its resting distance has a closed form in d_m, n and v.
        promises: `scenes.promise` holds for it.
        of_section_iii: eq. (12), with the stability of the paper's section III.
        in_null_space: it divides by the part of J_d in the hand's null space.
        in_league: False for a law that can imitate any other.
        offered_first: in the short list of laws.
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
        """Keys of its settings, including those of the measured distance."""
        measured = {"nothing": (), "one row": ("pairs", "beta", "eps", "coupled"), "all pairs": ("coupled",)}[
            self.sees
        ]
        return frozenset({*self.reads, *measured})

    @property
    def has_barrier(self) -> bool:
        """True if ḋ ≥ −γ (d − d_m)."""
        return "gamma" in self.reads

    @property
    def retreats(self) -> bool:
        """True if it retreats at v; a faster obstacle comes nearer."""
        return "v" in self.reads

    @property
    def distance_knob(self) -> Knob | None:
        return self.knobs[0] if self.knobs else Knob("dm", ()) if "dm" in self.reads else None


DEFAULT_LAW: Final = "smooth_priority"

NO_AVOIDANCE: Final = "unprotected"
BARRIER_LAW: Final = "barrier_qp"

DRAWN_LAW: Final = "drawn_curve"

LEVER_LAW: Final = "lever"

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
