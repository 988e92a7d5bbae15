"""Section III of the paper in words and numbers."""

import math
from typing import Final

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import decimal, tr
from app.session.frame import Contact
from app.text.lever_texts import lever_text
from app.text.templates import macros, tr_html
from controllers.kinematics import Array
from controllers.laws.situation import lever
from controllers.stability import Analysis, analyse, barrier
from controllers.tasks import TASK_DIMENSION, pose_error, position_error
from scenes.history import COLUMN, Sample
from scenes.law_answers import LawOfFile
from scenes.quantities import DISTANCE, KeptQuantity
from scenes.simulation import Simulation

NO_ERROR: Final = 5e-4
"""Smaller errors count as zero [m or rad]."""

DIED_OUT: Final = 5e-3
"""A smaller error that changes by less than this per second has died out [m or rad]."""

AT_REST: Final = 1e-3
"""An error with a smaller rate is constant [m/s or rad/s]."""

STILL: Final = 0.5 * NO_ERROR**2
"""A smaller V or rate of V counts as zero [m² or rad², or per second]."""


def stability_html(
    analysis: Analysis,
    error_norm: float,
    error_rate: float,
    V: float,
    V_rate: float,
    W: float | None,
    quantity: KeptQuantity = DISTANCE,
) -> Markup:
    """Two sentences and their numbers.

    Args:
        error_norm, error_rate: |e_b| of the task [m], or [rad] for a posture task, and its rate per second.
        W: barrier function; None for a hand task, which has none.
    """
    eigenvalue, mode = (
        _fixed(v, n, sign=True) for v, n in ((analysis.smallest_eigenvalue, 2), (analysis.slowest_mode, 3))
    )
    words = tr("orthogonal") if analysis.orthogonal else tr("not orthogonal")
    return macros("plots/charts.html").stability(
        condition_text(analysis, quantity),
        error_text(analysis, error_norm, error_rate),
        numbers=f"sym(M) {eigenvalue}, M {mode} 1/s",
        ranks=ranks_text(analysis),
        coupling="0" if analysis.rank_a == 0 else f"{_fixed(analysis.coupling, 2)}: {words}",
        survival=_fixed(analysis.survival, 3),
        lyapunov=f"{_small(V)}, {_small(V_rate, sign=True)}{_trend(V_rate)}",
        barrier="" if W is None else _barrier_text(W),
    )


def condition_text(analysis: Analysis, quantity: KeptQuantity = DISTANCE) -> str:
    """Does the paper's sufficient condition, sym(M) > 0, hold now?"""
    if analysis.activation == 0.0 and analysis.condition_holds:
        return tr_html("<b>The paper’s condition holds:</b> λ = 0, nothing disturbs the task.")
    if analysis.condition_holds:
        why = (
            tr("avoidance and task are orthogonal") if analysis.orthogonal else tr("every error makes V fall")
        )
        return tr_html("<b>The paper’s condition holds:</b> {why}.", why=why)
    why = lever_text(lever(analysis.lever * analysis.lever), quantity) or tr("not every error makes V fall")
    return tr_html("<b>The paper’s condition does not hold:</b> {why}.", why=why)


def error_text(analysis: Analysis, error_norm: float, error_rate: float) -> str:
    if not (math.isfinite(error_norm) and math.isfinite(error_rate)):
        return tr("The error is not known.")
    scale, unit = (180.0 / math.pi, "°") if analysis.joint_task else (1000.0, " mm")
    if error_norm < NO_ERROR and error_rate < AT_REST:
        return tr("There is no error to bring down.")
    holds = analysis.condition_holds
    size = Markup('<b class="e">|e|</b> = {}{}').format(
        _fixed(error_norm * scale, 0 if unit != "°" else 1), unit
    )
    speed = f"{_fixed(error_rate * scale, 0 if unit != '°' else 1, sign=True)}{unit}/s"
    if analysis.independent and error_norm < DIED_OUT and abs(error_rate) < DIED_OUT:
        return tr_html("The error has died out: {size}.", size=size)
    if abs(error_rate) < AT_REST:
        if analysis.independent:
            return tr_html("The error stays as it is: {size}.", size=size)
        return tr_html(
            "The error stays as it is: {size}, because avoidance and task are dependent.", size=size
        )
    if error_rate > 0.0:
        grows = tr("The error grows even so") if holds else tr("The error grows")
        return Markup("{}: {}, {}.").format(grows, size, speed)
    shrinks = tr("The error shrinks") if holds else tr("The error still shrinks")
    return Markup("{}: {}, {}.").format(shrinks, size, speed)


def ranks_text(analysis: Analysis) -> str:
    """Eq. (14) or (15) with its numbers, and the angle between independent tasks."""
    a, b, stack = analysis.rank_a, analysis.rank_b, analysis.rank_stack
    if a == 0:
        return tr_html("{stack} = 0 + {b}, for J<sub>a</sub> = 0", stack=stack, b=b)
    if not analysis.independent:
        return tr_html("{stack} &lt; {a} + {b}, dependent", stack=stack, a=a, b=b)
    return tr(
        "{stack} = {a} + {b}, independent by {angle}°",
        stack=stack,
        a=a,
        b=b,
        angle=_fixed(math.degrees(analysis.angle), 1),
    )


def _barrier_text(W: float) -> str:
    if math.isnan(W):
        return tr_html("not defined: |J<sub>d</sub>| is too small")
    if math.isinf(W):
        return Markup("∞: d ≤ d<sub>m</sub>")
    return tr_html("{W}, ∞ at d<sub>m</sub>", W=_fixed(W, 4))


def _trend(rate: float) -> str:
    if not math.isfinite(rate) or abs(rate) < STILL:
        return ""
    return f": {tr('falls') if rate < 0.0 else tr('rises')}"


def _fixed(value: float, digits: int, sign: bool = False) -> str:
    if not math.isfinite(value):
        return "–" if math.isnan(value) else "∞" if value > 0.0 else "−∞"
    text = f"{value:+.{digits}f}" if sign else f"{value:.{digits}f}"
    if not text.strip("+-0."):
        text = text.lstrip("+-")
    return decimal(text.replace("-", "−"))


def _small(value: float, sign: bool = False) -> str:
    if not STILL <= abs(value) < 1e-3:
        return _fixed(value, 5, sign)
    number, _, exponent = f"{value:.1e}".partition("e")
    return f"{_fixed(float(number), 1, sign)}·10⁻{'⁰¹²³⁴⁵⁶⁷⁸⁹'[-int(exponent)]}"


SPAN: Final = 0.3
"""Time for the error's rate [s]."""


def section_html(simulation: Simulation, sample: Sample, now: Contact) -> Markup:
    run, law = simulation.settings, simulation.settings.law
    if not law.entry.of_section_iii or isinstance(simulation.law, LawOfFile):
        return _nothing(
            "Section III is about eq. (12). Of this law it says nothing; take smooth priority to see it."
        )
    if run.one_row:
        return _nothing("Section III is about one arm and its task; here one row is shared by both arms.")
    if not keeps_its_task_clear(simulation):
        return _nothing("Section III is about one arm and its task; here the arm that you lead keeps clear.")
    error, J = task_error(simulation, sample)
    gain = run.gain
    analysis = analyse(now.row, J, sample.activation, gain, gain, damped=True)
    speed = law.nominal_velocity + (now.approach if run.adds_w else 0.0)
    e = analysis.error(speed, error)
    W = None
    if J is None and law.entry.promises:
        W = barrier(
            error, gain, now.row, now.distance, law.critical_distance, law.order, law.nominal_velocity
        )
    return stability_html(
        analysis,
        sample.error,
        error_rate(simulation),
        analysis.lyapunov(e),
        analysis.lyapunov_rate(e),
        W,
        run.quantity,
    )


def keeps_its_task_clear(simulation: Simulation) -> bool:
    """True if the first arm that keeps clear has the shown task."""
    return simulation.roles.avoiders(simulation.settings.avoid)[0] is simulation.roles.task


def task_error(simulation: Simulation, sample: Sample) -> tuple[Array, Array | None]:
    """e_b (m,) of the shown task [m, rad] and its Jacobian J_b (m, n); None for joints."""
    arm, keeper = simulation.avoiding, simulation.keeper
    if keeper is None:
        return sample.desired[arm.joints] - sample.positions[arm.joints], None
    pose = simulation.kinematics.hand_pose(arm)
    J = keeper.task_jacobian
    if J is None:
        # The hand has no task yet.
        J = simulation.kinematics.hand_jacobian(arm)[
            : TASK_DIMENSION[simulation.room.task(simulation.settings)]
        ]
    return position_error(pose, keeper.place) if len(J) == 3 else pose_error(
        pose, keeper.place, keeper.place_rotation
    ), J


def error_rate(simulation: Simulation) -> float:
    """Recent rate of |e| [m/s or rad/s]; nan before the second step."""
    table = simulation.history.table(round(SPAN / simulation.settings.dt) + 1)
    if len(table) < 2:
        return float("nan")
    # In a replay rows may be further apart.
    times = table[:, COLUMN["t"]]
    first, last = table[min(int(np.searchsorted(times, times[-1] - SPAN - 1e-9)), len(table) - 2)], table[-1]
    change = np.sqrt(last[COLUMN["e2"]]) - np.sqrt(first[COLUMN["e2"]])
    return float(change / (last[COLUMN["t"]] - first[COLUMN["t"]]))


def _nothing(sentence: str) -> Markup:
    return macros("plots/charts.html").nothing(tr(sentence))
