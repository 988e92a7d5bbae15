"""Line of contact ḋ = λ v − (1 − λ) u − w."""

from math import inf

import numpy as np

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import At, Reading, Row, Value, at, quantity
from app.i18n.speaking import N_
from app.plots.time_series import resting_at_end
from controllers import budget
from controllers.activation import activation
from scenes.settings import RunSettings, specs, values

FAR = 1000.0


@quantity(N_("setting"), "", 3, live=True, settings=True)
def setting(evidence: Evidence, key: str) -> Value:
    """SI units; the index of a choice."""
    value, spec = values(evidence.settings).get(key), specs().get(key)
    if value is None or spec is None or spec.read is not None:
        return None
    return float(spec.choices.index(value)) if spec.choices else float(value)


@quantity(N_("λ"), "", 2, live=True)
def activation_now(evidence: Evidence) -> Value:
    return float(evidence.column("lambda")[-1])


@quantity(N_("λ at d = {ratio} dₘ"), "", 3, obstacle=True)
def activation_met(evidence: Evidence, ratio: float) -> Reading:
    """At the first crossing, interpolated."""
    d, lam, met = (
        evidence.column("law_d"),
        evidence.column("lambda"),
        ratio * evidence.settings.law.critical_distance,
    )
    crossed = np.flatnonzero((d[1:] - met) * (d[:-1] - met) <= 0.0)
    if not len(crossed):
        return None
    k = int(crossed[0])
    way = float(d[k + 1] - d[k])
    part = (met - float(d[k])) / way if way else 0.0
    return At(float(lam[k]) + part * float(lam[k + 1] - lam[k]), k)


@quantity(N_("(dₘ/d)ⁿ at d = {ratio} dₘ"), "", 3, settings=True)
def activation_formula(evidence: Evidence, ratio: float) -> Value:
    """Eq. (31)."""
    law = evidence.settings.law
    return activation(ratio * law.critical_distance, law.critical_distance, law.order)


@quantity(N_("u"), "m/s", 2, live=True)
def pull_now(evidence: Evidence) -> Value:
    return float(evidence.column("u")[-1])


@quantity(N_("d*"), "mm", 0, live=True, obstacle=True)
def rest_now(evidence: Evidence) -> Value:
    """d* = d_m [(u + v)/(u + w)]^(1/n) for the newest u and w; None under a law without this rest."""
    if not evidence.settings.law.entry.rests:
        return None
    return resting_at_end(evidence.settings, evidence.table)


def balance(run: RunSettings, inside: float) -> float:
    """d where λ(d) v = (1 − λ(d)) K (d − inside) [m]; ∞ if d exceeds `FAR`."""
    d_m, n, v = run.law.critical_distance, run.law.order, run.law.nominal_velocity

    def rate(d: float) -> float:
        lam = activation(d, d_m, n)
        return budget.distance_rate(lam, v, run.gain * (d - inside), 0.0)

    if v == 0.0:
        return max(d_m, inside)
    if rate(FAR) > 0.0:
        return inf
    # Slow to import, and rarely needed.
    from scipy.optimize import brentq

    return float(brentq(rate, d_m, FAR, xtol=1e-12))  # pyright: ignore[reportArgumentType]


@quantity(N_("d where λv = (1 − λ)K(d − d_goal)"), "mm", 1, settings=True)
def stand_off_formula(evidence: Evidence, gap: float) -> Value:
    """Rest of a hand drawn straight to a goal `gap` from the obstacle [m]."""
    return balance(evidence.settings, gap)


@quantity(N_("displacement by λv = (1 − λ)K e"), "mm", 1, settings=True)
def bias_formula(evidence: Evidence, gap: float) -> Value:
    """Distance of that rest from the goal."""
    return balance(evidence.settings, gap) - gap


@quantity(N_("largest n λ (v + u) dt / d"), "", 2, obstacle=True)
def euler_number(evidence: Evidence) -> Value:
    """Explicit Euler chatters where it stays above 2."""
    run, d = evidence.settings, evidence.column("law_d")
    above = d >= run.law.critical_distance
    if not above.any():
        return None
    speeds = evidence.column("lambda") * (run.law.nominal_velocity + evidence.column("u"))
    return float((run.law.order * run.dt * speeds[above] / d[above]).max())


def _fall(evidence: Evidence) -> Row:
    d = evidence.column("law_d")
    below = np.flatnonzero(d[:-1] < evidence.settings.law.critical_distance)
    if not len(below):
        return None
    return int(below[np.diff(d)[below].argmin()])


@quantity(N_("loss of distance below dₘ"), "m/s", 3, obstacle=True)
def loss_rate(evidence: Evidence) -> Reading:
    return at(-np.diff(evidence.column("law_d")) / evidence.settings.dt, _fall(evidence))


@quantity(N_("w − v at that moment"), "m/s", 3, obstacle=True)
def loss_formula(evidence: Evidence) -> Reading:
    """At the fastest fall below d_m, where λ = 1."""
    row = _fall(evidence)
    if row is None:
        return None
    return At(
        budget.distance_loss_rate(
            evidence.settings.law.nominal_velocity, float(evidence.column("w_law")[row])
        ),
        row,
    )
