"""What is said in numbers and words: four tiles, the status, and eq. (32) with the values of this moment."""

from functools import cache
from typing import Final

import viser
from ziamath import zmath
from ziamath.config import config

from app.page.theme import PALETTES
from app.session import Pace, Session
from app.settings import Theme
from controllers.budget import distance_rate, resting_distance
from controllers.limits import Authority
from scenes.history import Sample
from scenes.simulation import Simulation

PERIOD: Final = 0.15
"""Wall time between two refreshes [s]; a number that changes faster cannot be read."""


@cache
def equation_svg(theme: Theme) -> str:
    """Return eq. (32) as SVG with its symbols in their colours; glyphs are paths, so it looks the same everywhere."""
    p = PALETTES[theme]
    lam, v = rf"\textcolor{{{p.activation}}}{{\lambda}}", rf"\textcolor{{{p.velocity}}}{{v}}"
    tex = rf"\dot q = J_d^{{\#}}\,{lam}\,{v} + \left(I - {lam}\,J_d^{{\#}} J_d\right)\dot q_n"
    # Shared <symbol> ids of several equations on one page would collide.
    config.svg2 = False
    svg = zmath.Latex(tex, size=18).svg()
    return svg.replace('fill="black"', 'fill="currentColor"').replace(
        "<svg ", '<svg fill="currentColor" style="max-width:88%;height:auto" ', 1
    )


class Readout:
    """The block of tiles, status and equation, each written anew only when its text changes.

    Args:
        gui: of whoever sees it; the caller has opened the container.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._blocks = {name: gui.add_html("") for name in ("tip", "status", "tiles", "equation", "live")}
        self._texts: dict[str, str] = {}
        self._next = 0.0

    def show(self, session: Session, sample: Sample, now: float, force: bool = False) -> None:
        """Refresh if it is time. `now`: wall time [s]."""
        if now < self._next and not force:
            return
        self._next = now + PERIOD
        simulation, law = session.simulation, session.settings.run.law
        self._write("tip", f'<div class="duet duet-tip">{tip_html(session)}</div>')
        self._write(
            "status", f'<div class="duet duet-status" role="status">{status_html(session.pace, simulation, sample)}</div>'
        )
        self._write("tiles", f'<div class="duet">{tiles_html(simulation, sample)}</div>')
        on = law.law == "smooth_priority"
        equation = equation_svg(session.settings.page.theme) if on else "q̇ = q̇<sub>n</sub> &nbsp; (the task alone)"
        self._write("equation", f'<div class="duet"><div class="duet-eq">{equation}<span class="no">(32)</span></div></div>')
        self._write("live", f'<div class="duet">{live_html(simulation, sample)}</div>')

    def _write(self, name: str, text: str) -> None:
        if self._texts.get(name) != text:
            self._texts[name] = text
            self._blocks[name].content = text


def tiles_html(simulation: Simulation, sample: Sample) -> str:
    """Return d, λ, |e| and w against v as tiles."""
    law = simulation.settings.law
    below = sample.distance < law.critical_distance - 1e-4
    faster = sample.approach > law.nominal_velocity and law.law == "smooth_priority" and not law.feed_forward
    tiles = (
        ("d", f"{sample.distance * 1000.0:.0f}" if sample.pair >= 0 else "–", "d, mm" + (" below d<sub>m</sub>" if below else ""), below),
        ("lam", f"{sample.activation:.2f}", "λ", False),
        ("e", f"{sample.error * 1000.0:.0f}", "|e|, mm", False),
        (
            "w",
            f"{sample.approach + 0.0:.2f}" if abs(sample.approach) >= 0.005 else "0.00",
            f"w of v {law.nominal_velocity:.2f}",
            faster,
        ),
    )
    return (
        '<div class="duet-tiles">'
        + "".join(
            f'<div{" class=bad" if bad else ""}><b class="{name}">{value}</b><span>{label}</span></div>'
            for name, value, label, bad in tiles
        )
        + "</div>"
    )


def tip_html(session: Session) -> str:
    """Return one sentence on what to do and what to watch."""
    yours, other = session.simulation.guided.name, session.simulation.avoiding.name
    keeps = f"The silver {other} arm keeps its hand in the ring, and keeps clear."
    if session.settings.page.autopilot and session.held is None:
        return f"The autopilot moves the orange {yours} arm; take its hand at the arrows. {keeps}"
    return f"Drag the orange {yours} arm at the arrows, or its elbow at the arc. {keeps}"


def status_html(pace: Pace, simulation: Simulation, sample: Sample) -> str:
    """Return the state of the clock and everything that is wrong, as pills."""
    law = simulation.settings.law
    pills = [("halt", "paused")] if pace.paused else [("go", f"{pace.rate:.1f}× real time")]
    if pace.slowed:
        pills.append(("halt", "slowed: this machine cannot keep up"))
    reason = authority_text(Authority(sample.authority), sample.joint, simulation)
    if reason:
        pills.append(("alarm", f"out of authority: {reason}"))
    if law.law == "unprotected":
        pills.append(("halt", "avoidance is off"))
    elif sample.approach > law.nominal_velocity and not law.feed_forward:
        pills.append(("alarm", "the hand is faster than v"))
    if sample.distance < 0.0:
        pills.append(("alarm", "the arms overlap"))
    return "".join(f'<span class="{kind}">{text}</span>' for kind, text in pills)


def authority_text(authority: Authority, joint: int, simulation: Simulation, second: bool = False) -> str:
    """Return why an arm cannot do what the law asks of it, "" if it can."""
    match authority:
        case Authority.STOP:
            return f"{simulation.joint_label(joint, second)} near its limit"
        case Authority.SPEED:
            return f"{simulation.joint_label(joint, second)} at its top speed"
        case Authority.LEVERAGE:
            return "no joint can move this point away"
        case _:
            return ""


def live_html(simulation: Simulation, sample: Sample) -> str:
    """Return the distance budget ḋ = λ v − (1 − λ) u − w with this moment's numbers, and d*."""
    law = simulation.settings.law
    lam, v, u, w = sample.activation, law.nominal_velocity, sample.pull, sample.law_approach
    if law.law == "unprotected":
        body = f'ḋ = −<b class="u">u</b> − <b class="w">w</b> = <b class="d">{-u - w:+.3f}</b> m/s'
        return f'<div class="duet-live">{body}</div>'
    rate = distance_rate(lam, v + (w if law.feed_forward else 0.0), u, w)
    rest = resting_distance(law.critical_distance, law.order, v, u, w)
    rest_text = "no rest, w &gt; v" if rest != rest else "∞" if rest > 9.0 else f"{rest * 1000.0:.0f} mm"
    lam_, v_, u_, w_, d_ = (f'<b class="{name}">' + "{}</b>" for name in ("lam", "v", "u", "w", "d"))
    sharp = "J<sub>d</sub><sup>#</sup>"
    law_now = f"q̇ = {sharp}·{lam_}·{v_} + (I − {lam_}·{sharp}J<sub>d</sub>) q̇<sub>n</sub>".format(
        f"{lam:.2f}", f"{v:.2f}", f"{lam:.2f}"
    )
    formula = f"{d_} = {lam_}{v_} − (1−{lam_}){u_} − {w_}".format("ḋ", "λ", "v", "λ", "u", "w")
    numbers = f"= {lam_}·{v_} − {lam_}·{u_} − {w_} = {d_} m/s".format(
        f"{lam:.2f}", f"{v:.2f}", f"{1.0 - lam:.2f}", _signed(u), _signed(w), f"{rate:+.3f}"
    )
    resting = f'rests at <b class="rest">d*</b> = <b class="rest">{rest_text}</b>'
    return f'<div class="duet-live">{law_now}<hr>{formula}<br>{numbers}<br>{resting}</div>'


def _signed(value: float) -> str:
    return f"({value:.2f})" if value <= -0.005 else f"{abs(value):.2f}"
