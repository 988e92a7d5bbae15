"""Figs 6 and 7: arms that follow joint angles."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from app.features.figures.drawn_figure import COLOURS, DASHES, INK, Drawn, Plan, csv_head, sheet, stack
from app.features.figures.fig5_hold import FELT, kept, switches
from controllers.kinematics import Array
from scenes.experiments import IMITATION, MASTER_SLAVE
from scenes.headless import Run
from scenes.history import COLUMN
from scenes.settings import RunSettings

SLOW: Final = 0.02
"""Slow retreat v [m/s], too slow for one arm alone."""

SHOWN: Final = 4


def master_slave(plan: Plan) -> Drawn:
    settings = plan.settings({"pairs": "single"}, scene=MASTER_SLAVE)
    length = plan.either(30.0, 8.0)
    run = plan.shared(settings, length)
    slave = run.simulation.avoiding
    time, d = run.table[:, COLUMN["t"]], run.table[:, COLUMN["d"]]
    figure, panels = stack(6.4, 1 + SHOWN, ratios=(1.35, 1, 1, 1, 1))
    _distance(panels[0], time, d, settings.law.critical_distance, length)
    wanted, actual = _angles(run, slave.joints)
    for i, axes in enumerate(panels[1:]):
        _joint(axes, time, wanted[:, i], actual[:, i], COLOURS.joints[i], f"$q_{i + 1}$ [rad]")
    panels[1].legend(
        handles=panels[1].lines, labels=["master", "slave"], loc="lower right", bbox_to_anchor=(1.0, 0.93), ncols=2,
        borderaxespad=0.0,
    )  # fmt: skip
    panels[-1].set(xlabel="time [s]", xlim=(0, length))
    gap = np.degrees(np.abs(wanted - actual))
    far = run.table[:, COLUMN["lambda"]] < FELT
    found = [
        kept(run),
        "Both arms give way, the master too. The slave copies it mirrored; the master is drawn as the slave should be.",
        f"The slave is off by up to {gap.max():.1f}° in one joint"
        + (f", by up to {gap[far].max():.1f}° while λ < {FELT:g}." if far.any() else "."),
        _slow(plan, settings, length),
        _smooth(run),
    ]
    names = [f"q{i + 1}" for i in range(wanted.shape[1])]
    columns = [
        "t",
        "d",
        "lambda",
        *(f"master_{name}" for name in names),
        *(f"slave_{name}" for name in names),
    ]
    return Drawn(figure, columns, _rows(run, wanted, actual), csv_head(settings, seconds=length), found)


def imitation(plan: Plan) -> Drawn:
    run, length = imitation_run(plan)
    settings, arms = run.simulation.settings, run.simulation.room.arms
    time, d = run.table[:, COLUMN["t"]], run.table[:, COLUMN["d"]]
    figure = sheet(6.6)
    layout: list[Any] = [["d", "d"], *([f"{arm.name}{i}" for arm in arms] for i in range(SHOWN))]
    panels = figure.subplot_mosaic(layout, sharex=True, height_ratios=(1.3, *[1.0] * SHOWN))
    figure.align_ylabels()
    _distance(panels["d"], time, d, settings.law.critical_distance, length)
    columns, blocks, gaps = ["t", "d", "lambda"], [], []
    for arm in arms:
        wanted, actual = _angles(run, arm.joints)
        for i in range(SHOWN):
            axes = panels[f"{arm.name}{i}"]
            _joint(axes, time, wanted[:, i], actual[:, i], COLOURS.joints[i], f"$q_{i + 1}$ [rad]")
        panels[f"{arm.name}0"].set_title(f"{arm.name} arm", fontsize=10.0, pad=3.0)
        panels[f"{arm.name}{SHOWN - 1}"].set(xlabel="time [s]", xlim=(0, length))
        labels = [f"{arm.name}_{{}}{i + 1}" for i in range(wanted.shape[1])]
        columns += [*(label.format("qd") for label in labels), *(label.format("q") for label in labels)]
        blocks += [wanted, actual]
        gaps.append(float(np.degrees(np.nanmax(np.abs(wanted - actual)))))
    figure.legend(panels["left0"].lines, ["desired", "actual"], loc="outside upper right", ncols=2)
    found = [
        kept(run),
        f"Both arms give way. Largest difference between a desired and an actual angle: {gaps[0]:.1f}° (left), {gaps[1]:.1f}° "
        "(right). Desired is what the person shows, behind the low-pass and the rate limit; it is dashed here, the other way round than "
        "in the paper.",
        _slow(plan, settings, length),
        _smooth(run),
    ]
    return Drawn(figure, columns, _rows(run, *blocks), csv_head(settings, seconds=length), found)


def imitation_run(plan: Plan) -> tuple[Run, float]:
    """Run of Figs 7 and 8, and its length [s]."""
    # A short run begins with the approach of the arms.
    settings = plan.settings({"pairs": "single"}, scene=IMITATION, clip=plan.either("medley", "clap"))
    length = plan.either(40.0, 8.0)
    return plan.shared(settings, length), length


def _smooth(run: Run) -> str:
    # Of both arms.
    largest = np.abs(np.diff(run.simulation.history.velocities(run.table), axis=0)).max()
    return (
        f"The largest step of q̇ is {largest:.3f} rad/s at dt = {1000 * run.simulation.settings.dt:g} ms, with "
        f"{switches(run)} changes of the closest pair while λ > {FELT:g}."
    )


def _slow(plan: Plan, settings: RunSettings, length: float) -> str:
    slow = replace(settings, law=replace(settings.law, nominal_velocity=SLOW))
    both = plan.run(slow, length).summary.d_min
    alone = plan.run(replace(slow, avoid="free"), length).summary.d_min
    return (
        f"When both give way d ≥ d_m needs no fast retreat: with v = {SLOW:g} m/s the minimum still is {1000 * both:.1f} mm. If only "
        f"one of them does, it is {1000 * alone:.1f} mm on the same input: then w ≤ v decides."
    )


def _angles(run: Run, joints: slice) -> tuple[Array, Array]:
    """Desired and actual angles (rows, n) [rad]."""
    history = run.simulation.history
    return history.desired(run.table)[:, joints], history.positions(run.table)[:, joints]


def _rows(run: Run, *blocks: Array) -> Sequence[Sequence[float]]:
    return np.column_stack([run.table[:, [COLUMN[name] for name in ("t", "d", "lambda")]], *blocks]).tolist()


def _distance(axes: Axes, time: Array, d: Array, critical: float, length: float) -> None:
    axes.axhline(critical, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    axes.plot(time, d, color=COLOURS.distance)
    axes.text(0.006 * length, critical - 0.012, "$d_m$", color=COLOURS.critical, fontsize=12, va="top")
    axes.set(ylim=(0, 0.4), yticks=(0, 0.2, 0.4), ylabel="$d$ [m]")


def _joint(axes: Axes, time: Array, wanted: Array, actual: Array, colour: str, label: str) -> None:
    axes.plot(time, wanted, color=INK, linestyle=DASHES[1], linewidth=1.0, zorder=3.0)
    axes.plot(time, actual, color=colour, linewidth=1.8)
    low, high = float(np.nanmin([wanted, actual])), float(np.nanmax([wanted, actual]))
    middle, half = (low + high) / 2.0, max((high - low) / 2.0, 0.1)
    axes.set(ylabel=label, ylim=(middle - 1.15 * half, middle + 1.15 * half))
    axes.locator_params(axis="y", nbins=3)
