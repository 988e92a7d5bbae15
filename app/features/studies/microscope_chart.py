"""Chart of single steps."""

import math

import numpy as np
from markupsafe import Markup

from app.features.studies.microscope import Magnified, Signal, Steps
from app.i18n.speaking import decimal, tr
from app.plots.chart import LEAST, Chart, ChartAxes, ticks_of
from app.text.templates import macros
from scenes.settings import RunSettings
from scenes.smoothness import AROUND


def microscope_html(seen: Magnified, run: RunSettings, height: int) -> Markup:
    """Chart, and the largest step at either time step. `height`: [CSS px]."""
    name, unit, scale, kind = _shown(seen.quantity, seen.joint, run)
    runs = [steps for steps in (seen.finer, seen.steps) if steps is not None]
    values = np.concatenate([steps.values for steps in runs]) * scale
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    reach = 1000.0 * seen.steps.dt * AROUND
    ticks = ticks_of(low, high)
    edge = max(0.08 * (high - low), LEAST)
    span = (low - edge, high + edge)
    x_ticks = tuple(
        (x * reach, f"{x * reach:+g}".replace("-", "−") if x else "0") for x in (-1.0, -0.5, 0.0, 0.5, 1.0)
    )
    chart = Chart(ChartAxes((-1.04 * reach, 1.04 * reach), span, x_ticks, ticks))
    for steps, css_class, width in zip(runs[::-1], (kind, "ghost"), (1.2, 1.0), strict=False):
        xs = 1000.0 * (steps.times - seen.time)
        chart.line(xs, steps.values * scale, f"{css_class} faded", width)
        chart.dots(xs, steps.values * scale, css_class, 5.5 if css_class == kind else 3.2)
    about = tr("over t − {t} s [ms]; largest step:", t=decimal(f"{seen.time:.3f}"))
    finer = "" if seen.finer is None else _largest(seen.finer, scale)
    made = macros("plots/charts.html")
    return made.steps(chart.html(height - 44), kind, name, unit, about, _largest(seen.steps, scale), finer)


def _largest(steps: Steps, scale: float) -> str:
    value = decimal(f"{scale * steps.largest:.3g}")
    return tr("{value} at {ms} ms", value=value, ms=decimal(f"{1000.0 * steps.dt:g}"))


def _shown(quantity: Signal, joint: int, run: RunSettings) -> tuple[str, str, float, str]:
    match quantity:
        case "d":
            return run.quantity.symbol, run.quantity.page_unit, 1000.0, "d"
        case "lambda":
            return "λ", "1", 1.0, "lam"
        case "dq":
            return Markup(f"q̇<sub>{joint + 1}</sub>"), "rad/s", 1.0, "u"
        case _:
            angle = run.experiment.error_unit == "rad²"
            return ("|e|", "°", math.degrees(1.0), "e") if angle else ("|e|", "mm", 1000.0, "e")
