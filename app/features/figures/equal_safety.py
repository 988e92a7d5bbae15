"""Laws at equal safety: largest e² over smallest distance, one curve per knob."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from app.features.figures.drawn_figure import COLOURS, DASHES, MARKERS, SERIES, Drawn, Plan, csv_head, sheet
from app.features.figures.laws_compared import JUMPS, growth
from app.features.studies.law_knobs import LawKnob, knobs
from controllers.kinematics import Array
from scenes.headless import Summary
from scenes.laws import LAWS
from scenes.settings import RunSettings, specs

SEEDS: Final = 5

ZOOM: Final = (0.13, 0.18)
"""Range of the second panel [m]."""


@dataclass(frozen=True)
class KnobCurve:
    """A knob's runs: values (points,), d_min and e² (seeds, points)."""

    knob: LawKnob
    values: Array
    d_min: Array
    e2: Array
    rows: list[list[object]]

    @property
    def label(self) -> str:
        setting = self.knob.setting
        return f"{LAWS[self.knob.law].short}{' with w' if setting.feed_forward else ''}, over {specs()[setting.key].label}"

    def at(self, d_min: float) -> Array:
        """e² (seeds,) at a smallest distance [m²], interpolated; nan if no knob value gives it."""
        return np.array([_between(d_min, d, e2) for d, e2 in zip(self.d_min, self.e2, strict=True)])

    def value_at(self, d_min: float) -> float:
        """Knob value for a mean smallest distance [m], or nan."""
        return _between(d_min, self.d_min.mean(0), self.values)


def _between(at: float, xs: Array, ys: Array) -> float:
    order = np.argsort(xs)
    return float(np.interp(at, xs[order], ys[order], left=np.nan, right=np.nan))


@dataclass(frozen=True)
class Price:
    """Cost of a law at the common smallest distance.

    Attributes:
        value: of its knob.
        e2: (seeds,) [m²].
        acceleration: largest q̈ [rad/s²].
        growth: p of q̈ ∝ dt^−p.
        step: median wall time [µs].
    """

    curve: KnobCurve
    value: float
    e2: Array
    acceleration: float
    growth: float
    step: float


def draw(plan: Plan) -> Drawn:
    length, dt = plan.either(30.0, 10.0), 0.01
    base = plan.settings(dt=dt)
    d_m = base.law.critical_distance
    curves = _curves(plan, base, length)
    figure = sheet(7.2, 6.4)
    whole, near = figure.subplots(2, 1, height_ratios=(1.0, 1.15))
    for curve in curves:
        draw_curve(whole, near, curve)
    for axes in (whole, near):
        axes.axvline(d_m, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
        axes.set_ylabel("largest $e^2$ [m²]")
    whole.set(xlim=(-0.1, 0.32), ylim=(0, 0.2))
    whole.axvspan(*ZOOM, color=COLOURS.faint, alpha=0.12, linewidth=0)
    near.set(xlim=ZOOM, ylim=_span(curves), xlabel="smallest $d$ [m]; below: the grey part, means only")
    figure.legend(*near.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8.5)
    prices = [price for curve in curves if (price := _price(plan, curve, base, length)) is not None]
    columns = ["law", "w_added", "knob", "value", "seed", "d_min", "e2_max", "ddq_max"]
    settings = csv_head(base, "law", "ff", "seed", seconds=length)
    return Drawn(
        figure,
        columns,
        [row for curve in curves for row in curve.rows],
        settings,
        findings(curves, prices, base),
    )


def _curves(plan: Plan, base: RunSettings, length: float) -> list[KnobCurve]:
    every = plan.either(slice(None), slice(1, None, 3))
    persons = range(plan.seed, plan.seed + plan.either(SEEDS, 2))
    points = [
        (knob, seed, value) for knob in knobs() for seed in persons for value in knob.setting.points[every]
    ]
    summaries = plan.summaries(
        [knob.at(replace(base, seed=seed), value) for knob, seed, value in points], length
    )
    runs = list(zip(points, summaries, strict=True))
    return [
        _curve(knob, [(seed, value, s) for (of, seed, value), s in runs if of == knob]) for knob in knobs()
    ]


def _curve(knob: LawKnob, runs: list[tuple[int, float, Summary]]) -> KnobCurve:
    persons = len({seed for seed, _, _ in runs})
    d_min, e2 = (
        np.array([getattr(s, name) for _, _, s in runs]).reshape(persons, -1) for name in ("d_min", "e2_max")
    )
    name, setting = knob.law, knob.setting
    rows: list[list[object]] = [
        [name, int(setting.feed_forward), setting.key, value, seed, s.d_min, s.e2_max, s.ddq_max]
        for seed, value, s in runs
    ]
    return KnobCurve(knob, np.array([value for _, value, _ in runs[: d_min.shape[1]]]), d_min, e2, rows)


def draw_curve(whole: Axes, near: Axes, curve: KnobCurve) -> None:
    knob = curve.knob
    place = list(dict.fromkeys(other.law for other in knobs())).index(knob.law)
    colour, marker = SERIES[place % len(SERIES)], MARKERS[place % len(MARKERS)]
    paper = place == 0 and knob.setting.key == "dm" and not knob.setting.feed_forward
    dash = DASHES[1] if knob.setting.feed_forward else DASHES[2] if knob.second else DASHES[0]
    for d, e2 in zip(curve.d_min, curve.e2, strict=True):
        whole.plot(d, e2, color=colour, linewidth=0.6, alpha=0.3, zorder=1.5)
    label = curve.label.replace("d_m", "$d_m$").replace("d_0", "$d_0$").replace("k_r", "$k_r$")
    for axes in (whole, near):
        axes.plot(
            curve.d_min.mean(0), curve.e2.mean(0), color=colour, linestyle=dash, marker=marker, markersize=5.0,
            markeredgecolor="white", markeredgewidth=0.5, linewidth=2.4 if paper else 1.5, zorder=3.0 if paper else 2.0, label=label,
        )  # fmt: skip


def _span(curves: list[KnobCurve]) -> tuple[float, float]:
    d, e2 = (np.concatenate([getattr(curve, name).mean(0) for curve in curves]) for name in ("d_min", "e2"))
    inside = e2[(d > ZOOM[0] - 0.02) & (d < ZOOM[1] + 0.02)]
    if not len(inside):
        return 0.0, 0.2
    low, high = np.percentile(inside, (0, 90)).tolist()
    return max(0.0, low - 0.01), high + 0.01


def _price(plan: Plan, curve: KnobCurve, base: RunSettings, length: float) -> Price | None:
    """None if no knob value keeps d_m on average, or for few seeds."""
    d_m = base.law.critical_distance
    value, e2 = curve.value_at(d_m), curve.at(d_m)
    if np.isnan(value) or np.isnan(e2).mean() > 0.5:
        return None
    steps = (base.dt, base.dt / 2.0)
    summaries: list[Summary] = [
        plan.run(replace(curve.knob.at(base, value), dt=dt), length).summary for dt in steps
    ]
    p = round(growth(summaries, steps), 2) + 0.0
    return Price(curve, value, e2, summaries[-1].ddq_max, p, min(s.step_us_median for s in summaries))


def findings(curves: list[KnobCurve], prices: list[Price], base: RunSettings) -> list[str]:
    d_m = base.law.critical_distance
    lines = [
        f"| law, at d_min = {1000 * d_m:.0f} mm | knob | e²_max [m²], mean (least to largest) | max q̈ [rad/s²] | p in q̈ ∝ dt^−p | "
        "step [µs] | needs w |",
        "|---|---|---|---|---|---|---|",
    ]
    persons = common(prices)
    for price in sorted(prices, key=lambda price: float(price.e2[persons].mean()) if persons.any() else 0.0):
        e2, spec = price.e2[persons], specs()[price.curve.knob.setting.key]
        error = f"{e2.mean():.4f} ({e2.min():.4f} to {e2.max():.4f})" if len(e2) else "–"
        knob = f"{spec.label} = {price.value:.3g} {spec.unit}".rstrip()
        lines.append(
            f"| {price.curve.label} | {knob} | {error} | {price.acceleration:.3g} | {price.growth:.2f} | {price.step:.0f} | "
            f"{'yes' if price.curve.knob.setting.feed_forward else 'no'} |"
        )
    sentences = [
        "\n".join(lines),
        f"Every law on the same motion of {len(curves[0].d_min)} persons; its knob is set so that the smallest distance is d_m on "
        f"average, and e² is read there, person by person: of the {np.count_nonzero(persons)} for whom every law of the table keeps d_m. "
        f"q̈ and p are of the first person, at dt = {500 * base.dt:g} ms; p near 1 is a "
        "jump.",
    ]
    paper = next((price for price in prices if price.curve is curves[0]), None)
    if paper is not None:
        sentences += [verdict(paper, other) for other in prices if other is not paper]
    kept = {price.curve.label for price in prices}
    sentences += [_out_of_reach(curve, curves[0], d_m) for curve in curves if curve.label not in kept]
    return sentences


def common(prices: list[Price]) -> NDArray[np.bool_]:
    """Seeds (seeds,) at which all laws keep the distance."""
    return ~np.isnan(np.sum([price.e2 for price in prices], axis=0)) if prices else np.zeros(0, np.bool_)


def _out_of_reach(curve: KnobCurve, paper: KnobCurve, d_m: float) -> str:
    d_min = curve.d_min.mean(0)
    nearest = int(np.abs(d_min - d_m).argmin())
    there = _between(float(d_min[nearest]), paper.d_min.mean(0), paper.e2.mean(0))
    against = "" if np.isnan(there) else f", against {there:.4f} m² of the paper's law at that distance"
    reached = np.count_nonzero(~np.isnan(curve.at(d_m)))
    if reached and d_min.min() <= d_m <= d_min.max():
        return f"{curve.label}: with the values of the knob that were tried it keeps d_m for {reached} of {len(curve.d_min)} persons only."
    return (
        f"{curve.label}: no value of the knob that was tried brings the smallest distance to d_m, only to {1000 * d_min.min():.0f} to "
        f"{1000 * d_min.max():.0f} mm; at {1000 * d_min[nearest]:.0f} mm e² is {curve.e2.mean(0)[nearest]:.4f} m²{against}."
    )


def verdict(paper: Price, other: Price) -> str:
    both = ~np.isnan(paper.e2) & ~np.isnan(other.e2)
    if not both.any():
        return f"{other.curve.label}: there is no person for whom both laws keep d_m."
    ratio = float(other.e2[both].mean() / paper.e2[both].mean())
    wins = int(np.count_nonzero(other.e2[both] < paper.e2[both]))
    word = (
        "**is better than the paper's law**" if ratio < 0.98 else "is worse" if ratio > 1.02 else "is as good"
    )
    costs = [
        f"q̈ is {other.acceleration / paper.acceleration:.2g} times as large",
        f"a step takes {other.step / paper.step:.2g} times",
    ]
    if other.growth > JUMPS and paper.growth <= JUMPS:
        costs.append("its q̇ jumps")
    if other.curve.knob.setting.feed_forward:
        costs.append("it needs the obstacle's speed w")
    return (
        f"{other.curve.label} {word}: e² is {ratio:.2f} times the paper's law's, smaller for {wins} of {int(both.sum())} persons; "
        + ", ".join(costs)
        + "."
    )
