"""All figures, and the report."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from app.features.figures import equal_safety, first_tasks
from app.features.figures import fig1_path as path
from app.features.figures import fig2_fig4_law as law
from app.features.figures import fig5_hold as hold
from app.features.figures import fig6_fig7_followers as followers
from app.features.figures import fig8_film as film
from app.features.figures import laws_compared as laws
from app.features.figures import pair_switches as switches
from app.features.figures import resting_distance as resting
from app.features.figures import section3_stability as stability
from app.features.figures.drawn_figure import Drawn, Plan
from controllers.errors import BadSetting


@dataclass(frozen=True)
class FigureEntry:
    """A figure.

    Attributes:
        paper: the paper's statement.
        number: in the paper; 0 for ours.
    """

    name: str
    title: str
    paper: str
    draw: Callable[[Plan], Drawn]
    number: int = 0

    @property
    def stem(self) -> str:
        return f"fig{self.number}_{self.name}" if self.number else self.name

    @property
    def heading(self) -> str:
        return f"Fig. {self.number}: {self.title}" if self.number else self.title


CATALOGUE: Final = (
    FigureEntry(
        "path",
        "past an obstacle from A to B",
        "A drawing: the robot's hand leaves its desired path from A to B where an obstacle is near, and the critical point is the "
        "point of the robot nearest to it.",
        path.draw,
        1,
    ),
    FigureEntry(
        "activation",
        "λ over the distance",
        "λ(d) = (d_m/d)ⁿ, and 1 below d_m, eq. (31), for several n with d_m = 0.1 m: the change of priority is smooth, and n says how "
        "early it begins.",
        law.draw_activation,
        2,
    ),
    FigureEntry(
        "setup", "the two arms", "A photo of two KUKA LWR arms on the bimanual set-up.", film.still, 3
    ),
    FigureEntry(
        "scheme",
        "the control scheme",
        "A block diagram for the direct control of the separate joints: proximity detection gives d, λ(d) weighs the task's joint "
        "velocity q̇_n against the retreat, forward kinematics closes the loop.",
        law.draw_scheme,
        4,
    ),
    FigureEntry(
        "hold",
        "one arm holds its place, the other is moved by hand",
        "The left arm holds its end-effector position, the right one is guided by hand at random for 50 s. The closest distance never "
        "passes the threshold; the squared tracking error is significant where the arms are close to each other.",
        hold.draw,
        5,
    ),
    FigureEntry(
        "master_slave",
        "master and slave",
        "The left arm follows the joints of the right one, and both avoid each other, 30 s: d is always above the threshold, and the "
        "slave (solid) follows the master (dashed) while they are away from it.",
        followers.master_slave,
        6,
    ),
    FigureEntry(
        "imitation",
        "imitation of a person",
        "Both arms are driven in real time by a person's two arms through a depth camera, four angles an arm, 40 s: d is above the "
        "threshold, and the actual angles (dashed) are similar to the desired ones (solid) when away from it.",
        followers.imitation,
        7,
    ),
    FigureEntry(
        "film", "eight frames of the imitation", "Eight photos of the experiment of Fig. 7.", film.film, 8
    ),
    FigureEntry(
        "resting",
        "The resting distance over n, v and w",
        "The paper gives no resting distance, and neither its v nor the n of its experiments.",
        resting.draw,
    ),
    FigureEntry(
        "threshold",
        "The smallest distance over v/w",
        "The closest distance never goes below the threshold in any of the three experiments; the paper does not say up to what speed of "
        "the other arm.",
        resting.draw_threshold,
    ),
    FigureEntry(
        "laws",
        "All laws side by side",
        "With strict priority, eq. (11), the priority of the tasks cannot be changed in a smooth way; therefore the new law, eq. (12). "
        "No law is measured against another.",
        laws.draw,
    ),
    FigureEntry(
        "equal_safety",
        "Laws at equal safety",
        "The new law is not measured against another. A comparison is fair where the laws keep the same distance.",
        equal_safety.draw,
    ),
    FigureEntry(
        "slide_loss",
        "Loss over v between two pairs",
        "The critical point is the point of the robot closest to the obstacle, and d stays above the threshold; two points that are "
        "equally close are not discussed.",
        switches.draw_slide_loss,
    ),
    FigureEntry(
        "switches",
        "Changes of the closest pair, and the step of q̇, over dt",
        "The transition between the tasks is smooth in both ways. The critical point is the point of the robot closest to the obstacle; "
        "what happens when another pair of points becomes the closest is not discussed.",
        switches.draw,
    ),
    FigureEntry(
        "bias",
        "The far bias over n",
        "While λ is close to 0, eq. (32) leaves the joints free, and the robot can follow its path.",
        resting.draw_far_bias,
    ),
    FigureEntry(
        "stability",
        "Section III along the run of Fig. 5",
        "V̇ = −eᵀ M e, eq. (25). Sufficient for the errors to tend to zero: M is positive definite, which it is if the two tasks are "
        "orthogonal, eq. (16), and the gains positive.",
        stability.draw,
    ),
    FigureEntry(
        "first_tasks",
        "Any first task: h with and without the law",
        "Eqs (9)–(13) hold for any first task x_a; the experiments have one, the distance of the arms. The outlook names constraints of "
        "the task or joint space, and the stability of a humanoid.",
        first_tasks.draw,
    ),
)


def chosen_figures(only: str) -> tuple[FigureEntry, ...]:
    """Figures of a list such as "2,5,laws"; all for "".

    Raises:
        BadSetting: unknown number or name.
    """
    asked = [word.strip().lower() for word in only.split(",") if word.strip()]
    by_word = {entry.name: entry for entry in CATALOGUE} | {
        str(entry.number): entry for entry in CATALOGUE if entry.number
    }
    for word in asked:
        if word not in by_word:
            numbers = ", ".join(str(entry.number) for entry in CATALOGUE if entry.number)
            names = ", ".join(entry.name for entry in CATALOGUE)
            raise BadSetting(f"only = {word[:40]!r} is not a figure; choose from {numbers} or {names}.")
    wanted = {by_word[word].name for word in asked}
    return tuple(entry for entry in CATALOGUE if not asked or entry.name in wanted)


def report(sections: Sequence[tuple[FigureEntry, Sequence[str]]], plan: Plan, version: str) -> str:
    """Report as Markdown for the folder of the figures. `sections`: figures with their findings."""
    lines = [
        "# The paper's figures, drawn from our own runs",
        "",
        "T. Petrič and L. Žlajpah, *Smooth Transition Between Tasks on a Kinematic Control Level: Application to Self Collision "
        "Avoidance for Two Kuka LWR Robots*, IEEE ROBIO 2011.",
        "",
        f"Made by `lwr-duet figures --seed {plan.seed}{' --quick' if plan.quick else ''}`, version {version}. Every number below comes "
        "from the runs of this call; the settings are on top of every CSV file, and the same call writes the same bytes of CSV. "
        "v, n, K and the time step are not in the paper: they are ours, as is the person who moves the arms.",
        "",
        "The text of the paper that we had has lost its zeros and ones: d_m = 0.15 m in Fig. 5 is read from damaged text (0.05 m would "
        "fit too), and so is the axis of e², read as 0 to 0.2 m².",
        "",
    ]
    if plan.quick:
        lines += ["**Quick**: shorter runs and fewer points than the figures are meant to have.", ""]
    for entry, found in sections:
        stem = entry.stem
        lines += [
            f"## {entry.heading}",
            "",
            f"![{entry.heading}]({stem}.png)",
            "",
            f"**The paper.** {entry.paper}",
            "",
        ]
        lines += ["**What we found.**", ""]
        for sentence in found:
            # A table needs its own paragraph.
            lines += [sentence, ""] if sentence.startswith("|") else [f"- {sentence}"]
        if lines[-1]:
            lines.append("")
        lines += [f"[{stem}.csv]({stem}.csv) · [{stem}.png]({stem}.png) · [{stem}.svg]({stem}.svg)", ""]
    return "\n".join(lines)
