"""Resting distance, far bias and threshold: closed forms against the whole loop."""

from itertools import islice
from typing import Final

import numpy as np

from app.features.figures.drawn_figure import COLOURS, DASHES, Drawn, Plan, csv_head, sheet
from app.features.figures.fig5_hold import approach
from controllers import budget
from controllers.kinematics import Array, Kinematics
from controllers.laws.situation import Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.proximity import ProximityDetector
from scenes.headless import Run, Summary, run
from scenes.history import COLUMN
from scenes.roles import NO_TARGETS, paced
from scenes.room import build_room
from scenes.settings import RunSettings
from scenes.two_arms import Autopilot

CRITICAL_DISTANCE: Final = 0.15
ORDER: Final = 2.0
VELOCITY: Final = 0.3
PULL: Final = 0.2
"""Default d_m [m], n, v and u [m/s], as in the closed form's example."""

STEP: Final = 0.005
"""dt [s]."""


class ContactRun:
    """The left hand avoids the right forearm, which approaches."""

    def __init__(self, law: SmoothPriority) -> None:
        room = build_room("table")
        self._law = law
        self._kinematics = Kinematics(room.model, room.arms)
        self._detector = ProximityDetector(self._kinematics, room.geometry)
        self._pair = self._detector.pair_names.index(("left hand", "right forearm"))
        self._left, self._right = room.arms[0].joints, room.arms[1].joints
        self._q = room.start.copy()
        self._row = np.zeros(room.model.nv)

    def measure(self) -> float:
        """d of the pair now [m]."""
        self._kinematics.update(self._q)
        self._detector.detect()
        self._row = self._detector.row(self._pair)
        return float(self._detector.distances()[self._pair])

    def start_at(self, distance: float) -> None:
        """Move both arms to a distance [m] by Newton steps."""
        for _ in range(100):
            missing = distance - self.measure()
            step = min(max(missing, -0.02), 0.02) / 2.0
            for joints in (self._left, self._right):
                self._q[joints] += self._along(joints, step)
            if abs(missing) < 1e-12:
                return

    def run(self, seconds: float, approach: float) -> float:
        """d [m] after `seconds` [s] of the pull and an approach w [m/s]."""
        distance = self.measure()
        for _ in range(round(seconds / STEP)):
            row = self._row[self._left]
            situation = Situation(
                self._q[self._left], self._along(self._left, -PULL), row, distance, approach
            )
            step = self._law(situation) * STEP
            self._q[self._right] += self._along(self._right, -approach) * STEP
            self._q[self._left] += step
            distance = self.measure()
        return distance

    def _along(self, joints: slice, speed: float) -> Array:
        """Smallest velocity (n,) that changes d at a speed [m/s]."""
        row = self._row[joints]
        return row * (speed / row.dot(row))


def closed_form(n: float, v: float, w: float) -> float:
    """d* [m], or nan."""
    return budget.resting_distance(CRITICAL_DISTANCE, n, v, PULL, w)


def settled(n: float, v: float, w: float) -> float:
    """Resting d [m], from 15 mm beyond, after five time constants, at most 10 s."""
    contact = ContactRun(SmoothPriority(CRITICAL_DISTANCE, n, v))
    contact.start_at(closed_form(n, v, w) + 0.015)
    return contact.run(min(5.0 * budget.settling_time(CRITICAL_DISTANCE, n, v, PULL, w), 10.0), w)


def draw(plan: Plan) -> Drawn:
    sweeps = {
        "n": (
            np.linspace(1, 20, 200),
            plan.either((1, 2, 3, 4, 6, 8, 10, 14, 20), (4, 10)),
            "order $n$",
            (1, 20),
        ),
        "v": (
            np.linspace(0.02, 0.6, 200),
            plan.either((0.05, 0.1, 0.2, 0.3, 0.4, 0.5), (0.1, 0.3)),
            "speed $v$ [m/s]",
            (0, 0.6),
        ),
        "w": (
            np.linspace(0, 0.3, 200),
            plan.either((0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3), (0.1, 0.3)),
            "approach $w$ [m/s]",
            (0, 0.4),
        ),
    }
    figure = sheet(2.75)
    panels = figure.subplots(1, 3, sharey=True)
    rows: list[tuple[str, float, float, float]] = []
    for axes, (over, (grid, dots, label, span)) in zip(panels, sweeps.items(), strict=True):
        point = {"n": ORDER, "v": VELOCITY, "w": 0.0}
        line = [closed_form(**(point | {over: float(x)})) for x in grid]
        axes.plot(grid, line, color=COLOURS.resting, linestyle=DASHES[0])
        points = [point | {over: float(x)} for x in dots]
        found = [(over, each[over], closed_form(**each), settled(**each)) for each in points]
        rests = [rest for *_, rest in found]
        axes.plot(
            dots,
            rests,
            "o",
            color=COLOURS.distance,
            markersize=5,
            markeredgecolor="white",
            clip_on=False,
            zorder=3,
        )
        axes.axhline(CRITICAL_DISTANCE, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
        axes.set(xlabel=label, xlim=span, ylim=(0.1, 0.4))
        rows += found
    panels[0].set(ylabel="resting distance $d^*$ [m]", xticks=(1, 10, 20))
    panels[0].text(
        19.6, CRITICAL_DISTANCE - 0.012, "$d_m$", color=COLOURS.critical, fontsize=12, ha="right", va="top"
    )
    panels[1].set(xticks=(0, 0.3, 0.6))
    panels[2].set(xticks=(0, 0.2, 0.4))
    panels[2].axvspan(VELOCITY, 0.4, color=COLOURS.approach, alpha=0.1, linewidth=0)
    panels[2].text(
        0.35,
        0.25,
        "no rest:\n$w>v$",
        color=COLOURS.approach,
        ha="center",
        va="center",
        rotation=90,
        fontsize=9.5,
    )
    worst = max(abs(closed - rest) for *_, closed, rest in rows)
    sentences = [
        "d* = d_m [(u + v)/(u + w)]^(1/n). "
        + ", ".join(f"{1000 * closed_form(n, VELOCITY, 0.0):.1f} mm (n = {n})" for n in (1, 2, 10))
        + f" for d_m = 150 mm, v = {VELOCITY}, u = {PULL} m/s and an obstacle at rest.",
        f"The whole loop (two arms, hand against forearm, dt = 5 ms) comes to rest within {1000 * worst:.2f} mm of it in all "
        f"{len(rows)} runs.",
        "A larger n or w brings the rest nearer to d_m, a larger v farther away; w = v is the last that has one, and it is d_m.",
    ]
    settings = {"dm": CRITICAL_DISTANCE, "n": ORDER, "v": VELOCITY, "u": PULL, "w": 0.0, "dt": STEP}
    return Drawn(
        figure, ["over", "value", "d_rest_closed_form", "d_rest_measured"], rows, settings, sentences
    )


def expected_bias(run: Run) -> float:
    """|e| of the closed form for the last posture of a run [m].

    At rest ḋ = 0 with w = 0, so u = λ v / (1 − λ), and q̇_n = J^# K e is parallel to J_d:
    K e = −u J J_dᵀ / (J_d J_dᵀ).
    """
    simulation, law = run.simulation, run.simulation.settings.law
    kinematics, arm = simulation.kinematics, simulation.avoiding
    kinematics.update(simulation.positions)
    near = simulation.detector.detect(*law.proximity)
    row = near.row[arm.joints]
    along = np.linalg.norm(kinematics.hand_jacobian(arm)[:3] @ row) / float(row @ row)
    lam = simulation.law.activation(near.law_distance)
    pull = budget.far_bias_speed(
        near.law_distance, law.critical_distance, law.order, law.nominal_velocity
    ) / (1.0 - lam)
    return float(pull * along / simulation.settings.gain)


def draw_far_bias(plan: Plan) -> Drawn:
    orders = plan.either((1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0), (2.0, 6.0))
    length = plan.either(60.0, 20.0)
    base = plan.settings({"pairs": "soft"}, rig="table")
    rows: list[list[float]] = []
    for n in orders:
        run = plan.run(plan.settings({"pairs": "soft", "order": n}, rig="table"), length, NO_TARGETS)
        d = float(run.table[-1, COLUMN["d"]])
        rows.append(
            [n, d, float(run.table[-1, COLUMN["lambda"]]), run.summary.e2_end**0.5, expected_bias(run)]
        )
    table = np.array(rows)
    figure = sheet(2.9)
    axes = figure.subplots()
    axes.plot(
        table[:, 0],
        1000 * table[:, 4],
        color=COLOURS.error,
        linestyle=DASHES[0],
        linewidth=1.5,
        label="closed form",
    )
    axes.plot(
        table[:, 0],
        1000 * table[:, 3],
        "o",
        color=COLOURS.error,
        markersize=6,
        markeredgecolor="white",
        label="whole loop",
    )
    axes.set(
        yscale="log",
        xlabel="order $n$",
        ylabel="displacement $|e|$ [mm]",
        xlim=(0, 20.5),
        xticks=(1, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20),
    )
    axes.legend(loc="upper right")
    worst = float(np.abs(table[:, 3] / table[:, 4] - 1.0).max())
    found = [
        f"No arm is guided, and the arms stand {1000 * table[-1, 1]:.0f} mm apart (d_m = {1000 * base.law.critical_distance:.0f} mm), yet "
        "the hand is not where it belongs: "
        + ", ".join(f"{1000 * e:.2g} mm (n = {n:g})" for n, e in table[:, (0, 3)])
        + f" after {length:g} s.",
        "At rest λ v = (1 − λ) u, so that |e| = λ v |J J_dᵀ| / ((1 − λ) K |J_d|²); the whole loop agrees with it within "
        f"{100 * worst:.2g} %.",
        "So the joints are never quite unconstrained, since λ is never 0; with a large n it is too small to see.",
    ]
    columns = ["n", "d", "lambda", "e", "e_closed_form"]
    return Drawn(figure, columns, rows, csv_head(base, "n", seconds=length), found)


SCRIPT: Final = 46.0
"""Length of the scripted inputs [s]."""

LOOKS: Final = {
    False: {"marker": "o", "color": COLOURS.distance, "linestyle": DASHES[0], "label": "paper's law"},
    True: {"marker": "s", "color": COLOURS.velocity, "linestyle": DASHES[1], "label": "$w$ added to $v$"},
}
"""Knowledge of w → line style."""


def _at_pace(settings: RunSettings, seconds: float, pace: float) -> tuple[float, Summary]:
    person = Autopilot(build_room(settings.rig), settings.guided, settings.seed)
    made = run(settings, seconds, paced(person, pace))
    return approach(made), made.summary


def draw_threshold(plan: Plan) -> Drawn:
    paces = plan.either(
        (0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.3, 2.7, 3.2, 3.8), (1.0, 3.8)
    )
    base = plan.settings(rig="table", hand_speed=1.0)
    v, critical = base.law.nominal_velocity, base.law.critical_distance
    calls = [
        (
            plan.settings({"feed_forward": feed_forward}, rig="table", hand_speed=1.0),
            plan.either(SCRIPT, 20.0) / pace,
            pace,
        )
        for feed_forward in LOOKS
        for pace in paces
    ]
    made = iter(plan.each(_at_pace, calls))
    results = {feed_forward: list(islice(made, len(paces))) for feed_forward in LOOKS}
    figure = sheet(3.1)
    axes = figure.subplots()
    for feed_forward, look in LOOKS.items():
        runs = results[feed_forward]
        xs, ys = [v / w for w, _ in runs], [summary.d_min for _, summary in runs]
        axes.plot(xs, ys, markersize=5, markeredgecolor="white", **look)
    axes.axhline(critical, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    axes.axvline(1.0, color=COLOURS.approach, linestyle=DASHES[2], linewidth=1.3)
    axes.set(
        xscale="log",
        xlabel="$v/w$, retreat over the fastest approach",
        ylabel="smallest distance [m]",
        ylim=(0, 0.2),
    )
    axes.set_yticks(np.arange(0, 0.21, 0.05))
    axes.set_xticks([0.4, 0.5, 0.7, 1, 1.5, 2, 3], ["0.4", "0.5", "0.7", "1", "1.5", "2", "3"], minor=False)
    axes.set_xticks([], minor=True)
    axes.text(0.985, 0.012, "$w>v$  ", color=COLOURS.approach, ha="right", fontsize=10.5)
    axes.text(1.015, 0.012, "  $w<v$", color=COLOURS.approach, ha="left", fontsize=10.5)
    axes.text(
        axes.get_xlim()[1],
        critical - 0.004,
        "$d_m$",
        color=COLOURS.critical,
        ha="right",
        va="top",
        fontsize=12,
    )
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.12))
    paper, fed = results[False], results[True]
    kept = [summary.d_min for w, summary in paper if w <= v]
    lost = [(w, summary.d_min) for w, summary in paper if summary.d_min < critical]
    found = [
        f"Smallest distance of the {len(kept)} runs with w ≤ v: {1000 * min(kept):.1f} mm, d_m = {1000 * critical:.0f} mm."
        if kept
        else "",
        f"Above, it is lost at the rate w − v: d_m is first passed at w = {min(lost)[0]:.3f} m/s (v = {v:.2f} m/s), and at "
        f"w = {max(lost)[0]:.2f} m/s the arms come as near as {1000 * max(lost)[1]:.0f} mm. A short push somewhat faster than v still "
        "ends above d_m, since d* > d_m leaves a margin."
        if lost
        else "",
        f"With the approach added to v (ours) no run comes nearer than {1000 * min(summary.d_min for _, summary in fed):.1f} mm, "
        f"up to w = {max(w for w, _ in fed):.2f} m/s.",
    ]
    rows = [
        [int(feed), pace, w, v / w, summary.d_min, summary.share_below]
        for feed, runs in results.items()
        for pace, (w, summary) in zip(paces, runs, strict=True)
    ]
    assert np.isfinite([row[4] for row in rows]).all()
    columns = ["w_added", "pace", "w_max", "v_over_w", "d_min", "share_below"]
    return Drawn(figure, columns, rows, csv_head(base), [sentence for sentence in found if sentence])
