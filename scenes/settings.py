"""The settings of a run; every field declares an option, a control, a link and an export."""

import math
from dataclasses import dataclass, field, fields, replace
from functools import cache, reduce
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar, cast

from controllers.choices import BoundsTreatment, HandTask, Treatment
from controllers.curve import read_curve
from scenes.experiments import EXPERIMENTS, HOLD, MASTER_SLAVE, Experiment
from scenes.laws import DEFAULT_LAW, LAWS, LawEntry
from scenes.quantities import DISTANCE, FIRST_TASKS, PARTS, WALL, KeptQuantity
from scenes.setting_spec import SPEC, Spec, Tab, checked, start_remedy, unknown_setting, with_added

if TYPE_CHECKING:
    from controllers.laws.situation import Law

RigName = Literal["torso", "table"]
ArmName = Literal["left", "right"]
RobotName = Literal["lwr", "panda", "ur5"]
"""Without robots from files, see `scenes.given_robots`."""
AvoidChoice = Literal["paper", "free", "guided", "both"]
"""As in the paper, the arm that is not held, the held one, or both."""
StartName = Literal["usual", "between"]
Following = Literal["identical", "mirrored"]
PathName = Literal["stay", "circle"]
ControlPoint = Literal["hand", "elbow", "arm"]
"""Part of the arm that keeps clear of the ball."""
BallMotion = Literal["still", "cross"]
ClipName = Literal["medley", "wave", "clap", "cross", "reach"]
Together = Literal["ratios", "stages"]
"""As one first task, or by stages, of which the last wins."""
T = TypeVar("T")

ABOVE, ABOVE_LAST, ELSEWHERE = Tab("above"), Tab("above", 1), Tab("elsewhere")

LAW, LAW_TASK, LAW_INPUT = (Tab("Law", place) for place in range(3))

ARMS, ARMS_TASK, ARMS_WHO, ARMS_PERSON, ARMS_PACE, ARMS_TIME = (Tab("Arms", place) for place in range(6))
HARDWARE: Final = Tab("Robot")


@dataclass(frozen=True)
class LawSettings:
    """How the avoiding arm divides itself between its task and keeping clear. SI units."""

    law: str = LAW.choice(
        DEFAULT_LAW, lambda: {name: law.label for name, law in LAWS.items()}, "law", "law",
        "The paper's smooth change of priority, what came before and after it, or no avoidance at all.",
    )  # fmt: skip
    pairs: Treatment = LAW_INPUT.choice(
        "smooth", Treatment, "pairs", "pairs",
        "What the law sees: the closest pair of bodies (the paper), a smooth minimum over all pairs, or one that stays smooth "
        "also where two links are parallel.",
        "Closest pair (paper)", "Smooth minimum", "Smooth everywhere",
    )  # fmt: skip
    critical_distance: float = LAW.number(
        0.15, "dm", "d_m", "Critical distance: below it avoidance has full priority.",
        "m", 0.03, 0.30, 5.0, "mm", 1000.0, words="critical distance",
    )  # fmt: skip
    order: float = LAW.number(
        6.0, "n", "n", "Order of λ: larger means later and steeper.", "", 1.0, 20.0, 0.5, words="order"
    )
    nominal_velocity: float = LAW.number(
        0.30, "v", "v", "Speed of retreat at full priority; a hand faster than this gets closer than d_m.",
        "m/s", 0.0, 1.0, 0.01, "m/s", words="speed of retreat",
    )  # fmt: skip
    beta: float = LAW_INPUT.number(
        100.0, "beta", "β", "Sharpness of the smooth minimum; larger is closer to the true minimum.",
        "1/m", 20.0, 400.0, 5.0, "1/m", words="sharpness",
    )  # fmt: skip
    convexity: float = LAW_INPUT.number(
        1e-4, "eps", "ε", "Rounds the distance of two parallel links; larger is smoother, and keeps a little more distance.",
        "m²", 1e-6, 1e-3, 1.0, "mm²", 1e6, words="rounding",
    )  # fmt: skip
    feed_forward: bool = LAW_INPUT.flag(
        "ff",
        "add w to v",
        "Tell the law how fast the obstacle comes: d ≥ d_m then no longer needs w ≤ v.",
        words="feed-forward:",
    )
    one_sided: bool = LAW_INPUT.flag(
        "one_sided", "one-sided", "Never slow down a retreat that is already faster than v."
    )
    coupled: bool = LAW_INPUT.flag(
        "coupled",
        "coupled",
        "Where both arms keep clear: one row over the joints of both, instead of one row an arm.",
    )
    influence_distance: float = LAW.number(
        0.30, "d0", "d_0", "Where null-space avoidance, the potential field and task activation begin to act.",
        "m", 0.05, 0.60, 5.0, "mm", 1000.0, words="influence distance",
    )  # fmt: skip
    field_strength: float = LAW.number(
        0.005,
        "eta",
        "η",
        "Strength of the potential field.",
        "m² rad²/s",
        0.0,
        0.05,
        0.001,
        "m² rad²/s",
        words="field strength",
    )
    barrier_gain: float = LAW.number(
        5.0, "gamma", "γ", "How fast the barrier QP lets the distance above d_m be used up.",
        "1/s", 0.1, 40.0, 0.1, "1/s", words="barrier gain",
    )  # fmt: skip
    restoring_gain: float = LAW.number(
        5.0, "kr", "k_r", "How fast the set-based task returns to d_m from below; 0 freezes the distance.",
        "1/s", 0.0, 40.0, 0.5, "1/s", words="restoring gain",
    )  # fmt: skip

    curve: str = LAW.text(
        "0.15:1,0.2:0.3,0.4:0", read_curve, "curve", "λ(d)",
        "Points of a λ of your own: distance in metres, a colon, λ from 0 to 1; with commas between them.", words="your curve",
    )  # fmt: skip
    hand_lever: float = LAW.number(
        0.5, "lever", "λ", "Your lever: 0 is only the task, 1 only the retreat.",
        "", 0.0, 1.0, 0.01, words="your lever",
    )  # fmt: skip

    @property
    def proximity(self) -> tuple[Treatment, float, float]:
        """Arguments of `ProximityDetector.detect`: visible pairs, β [1/m] and ε [m²]."""
        return self.pairs, self.beta, self.convexity

    @property
    def entry(self) -> LawEntry:
        return LAWS[self.law]

    def made(self) -> "Law":
        """The law with these settings."""
        read = {
            f.name: getattr(self, f.name) for f in fields(self) if f.metadata[SPEC].key in self.entry.reads
        }
        law: Law = resolve_name(f"controllers.laws.{self.entry.made_by}")(**read)
        return law

    @property
    def knows_w(self) -> bool:
        """True if the law uses the obstacle's speed w."""
        return self.feed_forward and "ff" in self.entry.reads


@dataclass(frozen=True)
class HardwareSettings:
    """How the arms that avoid differ from ideal ones: what is behind the commanded velocity, and what is seen. SI units; 0 is ideal."""

    dead_time: float = HARDWARE.number(
        0.0, "dead", "dead time T", "How long a commanded velocity is on its way to the joints, in whole time steps.",
        "s", 0.0, 0.1, 5.0, "ms", 1000.0,
    )  # fmt: skip
    lag: float = HARDWARE.number(
        0.0,
        "lag",
        "lag τ",
        "Time constant with which the joints reach a commanded velocity.",
        "s",
        0.0,
        0.1,
        5.0,
        "ms",
        1000.0,
    )
    joint_noise: float = HARDWARE.number(
        0.0, "qnoise", "noise of q", "Standard deviation of what the joint sensors show, in every step.",
        "rad", 0.0, 0.02, 0.01, "°", math.degrees(1.0),
    )  # fmt: skip
    joint_resolution: float = HARDWARE.number(
        0.0,
        "qstep",
        "step of q",
        "Resolution of the joint sensors.",
        "rad",
        0.0,
        0.02,
        0.01,
        "°",
        math.degrees(1.0),
    )
    frame_rate: float = HARDWARE.number(
        0.0, "fps", "camera", "Frames a second in which the distance is measured; in between d and J_d stay. 0 is every step.",
        "1/s", 0.0, 100.0, 5.0, "Hz",
    )  # fmt: skip
    distance_noise: float = HARDWARE.number(
        0.0, "dnoise", "noise of d", "Standard deviation of the measured distance, in every frame.",
        "m", 0.0, 0.02, 0.5, "mm", 1000.0,
    )  # fmt: skip

    @property
    def sees_wrong(self) -> bool:
        """True if the controller's measurements differ from the true state."""
        return max(self.joint_noise, self.joint_resolution, self.frame_rate, self.distance_noise) > 0.0


@dataclass(frozen=True)
class RunSettings:
    """Who stands where and what they are asked to do. SI units."""

    scene: str = ABOVE.choice(
        HOLD,
        lambda: {name: experiment.label for name, experiment in EXPERIMENTS.items()},
        "scene",
        "scene",
        "Which experiment.",
    )
    rig: str = ABOVE_LAST.choice(
        "torso",
        RigName,
        "rig",
        "rig",
        "Where the two arms stand.",
        "Torso (the paper's laboratory)",
        "Table, face to face",
    )
    robot: str = ABOVE.choice(
        "lwr", RobotName, "robot", "robot", "Which arms, the left one first where they differ; nothing is tied to the LWR.",
        "KUKA LWR 4+", "Franka Panda", "UR5",
    )  # fmt: skip
    guided: ArmName = ARMS_WHO.choice(
        "right", ArmName, "guided", "your arm", "The arm that you move.", "Left", "Right"
    )
    task: HandTask = ARMS_TASK.choice(
        "position", HandTask, "task", "task", "What the avoiding hand keeps: its position, or its position and orientation.",
        "Hold position", "Hold pose",
    )  # fmt: skip
    avoid: AvoidChoice = ARMS_WHO.choice(
        "paper", AvoidChoice, "avoid", "who avoids",
        "Which arm keeps clear. In the paper: the free arm in Fig. 5, both in Figs 6 and 7.",
        "As in the paper", "The free arm", "Your arm", "Both arms",
    )  # fmt: skip
    start: StartName = ARMS_WHO.choice(
        "usual", StartName, "start", "start",
        "The posture that the arms begin in; in the second, your arm slides along the tie of two pairs.",
        "Usual", "Between two pairs",
    )  # fmt: skip
    following: Following = ARMS.choice(
        "mirrored",
        Following,
        "following",
        "slave",
        "How the slave copies the master's joints.",
        "Identical",
        "Mirrored",
    )
    path: PathName = ARMS.choice(
        "stay", PathName, "path", "path", "What the hand of the single arm does.", "Stays", "Draws a circle"
    )
    point: ControlPoint = ARMS.choice(
        "hand", ControlPoint, "point", "keeps clear", "What of the arm keeps clear of the ball.",
        "Its hand", "Its elbow", "All of it",
    )  # fmt: skip
    ball: BallMotion = ARMS.choice(
        "still", BallMotion, "ball", "ball", "What the ball does by itself.", "Stays", "Crosses the path"
    )
    first: str = ABOVE.choice(
        WALL, lambda: {name: quantity.label for name, quantity in FIRST_TASKS.items()}, "first", "first task",
        "What the arm must keep before anything else; d_m and v are then in its unit.",
    )  # fmt: skip
    together: Together = ABOVE.choice(
        "ratios", Together, "together", "all at once",
        "How several first tasks are one: the smooth minimum of their ratios, or one stage after the other.",
        "By ratios", "By stages",
    )  # fmt: skip
    load: float = ABOVE.number(6.0, "load", "load", "Mass in the hand.", "kg", 0.0, 20.0, 0.5, "kg")
    clip: ClipName = ARMS_TASK.choice(
        "medley",
        ClipName,
        "clip",
        "clip",
        "What the built-in person does.",
        "All in turn",
        "Wave",
        "Clap",
        "Cross",
        "Reach",
    )
    gain: float = LAW_TASK.number(
        2.0,
        "k",
        "K",
        "How hard the avoiding hand is drawn back to its place.",
        "1/s",
        0.0,
        20.0,
        0.1,
        "1/s",
        words="task gain",
    )
    overdrive: float = LAW_TASK.number(
        1.0, "kx", "K times", "Multiplies K of the single arm, to see what happens where K dt > 2.",
        "", 1.0, 10.0, 0.5, words="task gain:",
    )  # fmt: skip
    hand_speed: float = ARMS_PACE.number(
        0.25, "wmax", "w_max", "A person's speed limit: nothing on your arm moves faster, unless it keeps clear itself.",
        "m/s", 0.05, 1.0, 0.01, "m/s", words="speed limit",
    )  # fmt: skip
    dt: float = ARMS_TIME.number(
        0.005,
        "dt",
        "dt",
        "Time step of the simulation.",
        "s",
        0.00125,
        0.020,
        0.25,
        "ms",
        1000.0,
        words="time step",
    )
    limit_gain: float = ARMS_TIME.number(
        10.0,
        "g",
        "g",
        "How softly a joint comes to rest at its stop.",
        "1/s",
        1.0,
        40.0,
        0.5,
        "1/s",
        words="joint-stop gain",
    )
    bounds: BoundsTreatment = ARMS_TIME.choice(
        "distance", BoundsTreatment, "bounds", "bounds",
        "What is kept when joints meet their bounds: the distance rate; the direction of q̇; or the hand's velocity, too, by joints "
        "that still can.",
        "Keep the distance rate", "Shorten the whole q̇", "Saturate in the null space",
    )  # fmt: skip
    world: bool = ARMS_WHO.flag(
        "world",
        "glide along",
        "Arms glide along table, stand, floor and their own links, whatever else they are asked to do. The table counts as solid down "
        "to the floor.",
    )
    seed: int = ARMS_PACE.number(
        1, "seed", "seed", "Seed of the autopilot and of the sensors' noise.", "", 0, 9999, 1
    )
    law: LawSettings = field(default_factory=LawSettings)
    hardware: HardwareSettings = field(default_factory=HardwareSettings)

    @property
    def experiment(self) -> Experiment:
        return EXPERIMENTS[self.scene]

    @property
    def quantity(self) -> KeptQuantity:
        """First task of the law."""
        return FIRST_TASKS[self.first] if "first" in self.experiment.reads else DISTANCE

    @property
    def stages(self) -> tuple[KeptQuantity, ...]:
        """First tasks kept one after the other, the last wins; () if they are one."""
        parts = PARTS.get(self.quantity.name, ()) if self.together == "stages" else ()
        return tuple(FIRST_TASKS[part] for part in parts)

    @property
    def draws_circle(self) -> bool:
        """True if the hand draws a circle and nothing else can move it."""
        return self.path == "circle" and "path" in self.experiment.reads

    @property
    def moves_itself(self) -> bool:
        """True if the experiment's own source moves what the visitor does not hold."""
        return not self.draws_circle and not ("ball" in self.experiment.reads and self.ball == "still")

    @property
    def has_law_distance(self) -> bool:
        """True if d_law can differ from the distance d of the closest pair."""
        # A first task without parts is one "pair".
        several = self.quantity is DISTANCE or self.quantity.name in PARTS
        return (several and self.law.pairs != "single") or self.hardware.sees_wrong

    @property
    def both_avoid(self) -> bool:
        if self.experiment.obstacle != "arm":
            return False
        return self.experiment.both_avoid if self.avoid == "paper" else self.avoid == "both"

    @property
    def one_row(self) -> bool:
        """True if both arms avoid by one row over all joints: if chosen, or if w is added to v.

        With two rows each arm would add the other's last velocity, and the sum would alternate.
        """
        return self.both_avoid and (self.law.coupled or self.law.knows_w)

    @property
    def adds_w(self) -> bool:
        """True if the law adds all of w to v; a master that avoids alone leaves out what its slave copies."""
        return self.law.knows_w and (self.both_avoid or self.avoid != "guided" or self.scene != MASTER_SLAVE)

    @property
    def fits_between(self) -> bool:
        """True if the run can start between two pairs, see `scenes.starts`."""
        return "start" in self.experiment.reads and self.rig == "torso" and self.robot == "lwr"


@cache
def leaves(settings_type: type) -> dict[str, tuple[tuple[str, ...], Spec]]:
    """Key → field names that lead to it, and its declaration, in order."""
    found: dict[str, tuple[tuple[str, ...], Spec]] = {}
    for f in fields(settings_type):
        if SPEC in f.metadata:
            found[f.metadata[SPEC].key] = (f.name,), f.metadata[SPEC]
        else:
            found |= {
                key: ((f.name, *path), spec)
                for key, (path, spec) in leaves(cast(type, f.default_factory)).items()
            }
    return found


def specs(settings_type: type = RunSettings) -> dict[str, Spec]:
    """Key → `Spec` of every field of the tree, in order."""
    return {key: with_added(spec) for key, (_, spec) in leaves(settings_type).items()}


def values(settings: Any) -> dict[str, Any]:
    """Key → value of every field of the tree, in order."""
    return {key: reduce(getattr, path, settings) for key, (path, _) in leaves(type(settings)).items()}


LATER: Final = {"world": False, "first": WALL, "together": "ratios", "load": 6.0}
"""Key → default of settings added later: tables name them only with other values."""


def named_values(settings: Any) -> dict[str, Any]:
    """`values` without defaults of `LATER`, so that old tables keep their bytes."""
    return {key: value for key, value in values(settings).items() if key not in LATER or value != LATER[key]}


def changed(settings: T, key: str, value: object) -> T:
    """The settings with the field of a key set to a checked value.

    Args:
        value: of the field's type, or text that reads as one.

    Raises:
        BadSetting: unknown key, wrong type, not finite, out of range or not a choice.
    """
    known = leaves(type(settings))
    if key not in known:
        raise unknown_setting(key, known)
    path, spec = known[key]
    return replaced(
        settings, path, checked(with_added(spec), reduce(getattr, path, settings), value, start_remedy)
    )


def replaced(settings: T, path: tuple[str, ...], value: Any) -> T:
    """The settings with the field at a path of names set to a valid value."""
    name, *rest = path
    return replace(
        cast(Any, settings),
        **{name: replaced(getattr(settings, name), tuple(rest), value) if rest else value},
    )


def validate(settings: RunSettings) -> RunSettings:
    """The settings if every field is in its range.

    Raises:
        BadSetting: names the first field that is not.
    """
    for key, value in values(settings).items():
        changed(settings, key, value)
    return settings
