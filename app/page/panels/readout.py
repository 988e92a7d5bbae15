"""What is said in numbers and words: the tip, the status, the promise, the error, and the law's equation."""

import math
from html import escape
from typing import Final, NamedTuple

import viser

from app.i18n.speaking import tr
from app.page.panels.promise_pills import pills_html, promise_html
from app.session.clock import Pace
from app.session.elbow_swivel import Swivel
from app.session.frame import Frame
from app.session.relevant_settings import both_avoid
from app.session.shown import Shown
from app.session.student_law import LawStatus
from app.text.equations import equation_html
from controllers.kinematics import DAMPING, null_space_projector
from controllers.limits import Authority
from controllers.tasks import TASK_DIMENSION
from scenes.history import Sample
from scenes.settings import RunSettings
from scenes.simulation import Simulation

PERIOD: Final = 0.15
"""Wall time between two refreshes [s]; a number that changes faster cannot be read."""

RETREATING: Final = (
    *("smooth_priority", "strict_priority", "strict_switched", "null_space_avoidance"),
    *("intermediate_value", "task_activation", "continuous_inverse"),
)
"""Laws that lose distance to an obstacle faster than v."""


class Tile(NamedTuple):
    """One number.

    Attributes:
        kind: class of CSS, for its colour.
        value: as text.
        label: under it, as HTML.
        bad: whether it is one to worry about.
    """

    kind: str
    value: str
    label: str
    bad: bool = False


class Readout:
    """Tip, status, promise, numbers and equation, one block each."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._tip, self._status, self._numbers, self._equation = (gui.add_html("") for _ in range(4))
        self._next = 0.0
        self._shown: tuple[object, ...] = ()

    def show(self, frame: Frame) -> None:
        """Refresh what has changed: every `PERIOD` while the run goes on, and at once while it rests."""
        if (frame.now < self._next and not frame.pace.paused) or frame.state == self._shown:
            return
        self._shown, self._next = frame.state, frame.now + PERIOD
        shown, simulation, sample = frame.shown, frame.simulation, frame.sample
        self._tip.content = f'<div class="duet duet-tip">{tip_html(shown)}</div>'
        pills = replay_html(shown) + status_html(frame.pace, simulation, sample) + custom_law_html(shown.student_law)
        self._status.content = f'<div class="duet duet-status" role="status">{pills}</div>'
        pills = promise_html(simulation, sample, shown.student_law.file is not None) + error_html(simulation, sample, frame.ghost)
        numbers = f'<div class="duet-status">{pills}</div>' if pills else tiles_html(simulation, sample)
        self._numbers.content = f'<div class="duet">{numbers}</div>'
        if shown.student_law.file is not None:
            law = f'<div class="duet-eq">q̇ = law(situation)</div>{escape(shown.student_law.file)}'
            self._equation.content = f'<div class="duet">{law}</div>'
            return
        self._equation.content = f'<div class="duet">{equation_html(frame.settings.run)}</div>'


def replay_html(shown: Shown) -> str:
    """Return a pill with the moment that is replayed; nothing while live."""
    if shown.replay_time is None:
        return ""
    return f'<span class="past">{tr("the past: {time} s", time=f"{shown.replay_time:.1f}")}</span>'


def custom_law_html(law: LawStatus) -> str:
    """Return a pill that says what runs the student's law, or why nothing does; nothing where there is none."""
    file = law.file or law.ghost_file
    if file is None:
        return ""
    file, why = escape(file), escape(tr(law.problem))
    if why:
        still = tr("the arm stands still: {why}", why=why) if law.file else tr("the ghost stands still: {why}", why=why)
        return f'<span class="alarm">{still}</span>'
    if law.waits:
        return f'<span class="halt">{tr("waiting for {file}", file=file)}</span>'
    if law.slow is not None:
        needs, allowed = (f"{1e3 * seconds:.2g}" for seconds in law.slow)
        slow = tr("slowed: your law needs {needs} ms a call; real time allows {allowed} ms", needs=needs, allowed=allowed)
        return f'<span class="halt">{slow}</span>'
    if law.away:
        return f'<span class="past">{tr("{file} is gone; what it said last runs on", file=file)}</span>'
    return f'<span class="go">{tr("runs {file}", file=file) if law.file else tr("the ghost runs {file}", file=file)}</span>'


# --- tiles ---------------------------------------------------------------------------------------------------------------------


def tiles_html(simulation: Simulation, sample: Sample) -> str:
    """Return the numbers of an arm that stands alone as tiles; nothing where the card of the line of contact has them."""
    if sample.pair >= 0:
        return ""
    return '<div class="duet-tiles">' + "".join(_tile_html(tile) for tile in _alone_tiles(simulation, sample)) + "</div>"


def _tile_html(tile: Tile) -> str:
    return f'<div{" class=bad" if tile.bad else ""}><b class="{tile.kind}">{tile.value}</b><span>{tile.label}</span></div>'


def error_html(simulation: Simulation, sample: Sample, ghost: Simulation | None = None) -> str:
    """Return |e| of an arm with an obstacle as a pill, and the ghost's; nothing of an arm that stands alone."""
    if sample.pair < 0:
        return ""
    beside = "" if ghost is None else f" ({tr('ghost')} {_error_text(ghost, ghost.sample())})"
    return f'<span><b class="e">|e|</b> {_error_text(simulation, sample)}{beside}</span>'


def _error_text(simulation: Simulation, sample: Sample) -> str:
    if simulation.error_unit != "rad²":
        return f"{sample.error * 1000.0:.0f} mm"
    error = math.degrees(sample.error)
    if simulation.settings.scene == "imitation" and sample.second is not None:
        left, right = error, math.degrees(math.sqrt(sample.second.squared_error))
        if simulation.avoiding.name == "right":
            left, right = right, left
        return tr("{left}° left, {right}° right", left=f"{left:.0f}", right=f"{right:.0f}")
    return f"{error:.1f}°"


def _alone_tiles(simulation: Simulation, sample: Sample) -> list[Tile]:
    run, arm = simulation.settings, simulation.avoiding
    J = simulation.kinematics.hand_jacobian(arm)[: TASK_DIMENSION[run.task]]
    # It counts the dimensions that the hand leaves free: n − m, and more at a singular posture.
    free = float(null_space_projector(J, DAMPING).trace())
    angle = math.degrees(Swivel(simulation.room, arm).angle(sample.positions))
    k = run.gain * run.overdrive * run.dt
    return [
        Tile("e", f"{sample.error * 1000.0:.1f}", "|e|, mm"),
        Tile("lam", f"{free:.1f}", tr("free, tr N")),
        Tile("d", "–" if angle != angle else f"{angle:.0f}°".replace("-", "−"), tr("elbow")),
        Tile("w", f"{k:.3g}", "K dt ≥ 2" if k >= 2.0 else "K dt &lt; 2", k >= 2.0),
    ]


# --- words ---------------------------------------------------------------------------------------------------------------------


def tip_html(session: Shown) -> str:
    """Return one or two sentences on what to do and what to watch."""
    if session.replay_time is not None:
        return tr("What you see is over. Space plays it and rests, . goes one step, R goes back to live.")
    run = session.settings.run
    itself = session.settings.page.autopilot and session.held is None
    match run.scene:
        case "solo":
            return _solo_tip(run, itself)
        case "ball":
            what = {"hand": tr("its hand"), "elbow": tr("its elbow"), "arm": tr("all of it")}[run.point]
            does = tr("The arm takes its hand from A to B and back, and keeps {what} clear of the ball.", what=what)
            crosses = itself and run.ball == "cross"
            return f"{does} {tr('The ball crosses the path by itself; drag it.') if crosses else tr('Drag the ball.')}"
        case "hold":
            keeps = _hold_words(run)
            if itself:
                return f"{tr('The autopilot moves the orange arm; pull it anywhere to take over.')} {keeps}"
            return f"{tr('Pull the orange arm anywhere.')} {keeps}"
        case "master_slave":
            follows = (
                tr("The silver arm follows it in a mirror, and {avoids}.", avoids=_who_avoids(run))
                if run.following == "mirrored"
                else tr("The silver arm follows it joint by joint, and {avoids}.", avoids=_who_avoids(run))
            )
            does = (
                tr("The autopilot moves the orange arm, the master; pull it anywhere to take over.")
                if itself
                else tr("Pull the orange arm, the master, anywhere.")
            )
            return f"{does} {follows}"
        case _:
            does = tr(
                "Both arms follow the person by four angles each, and {avoids}. See-through: where they ought to be.",
                avoids=_who_avoids(run),
            )
            return f"{does} {tr('Pull the arms of the figure anywhere.')}"


def _solo_tip(run: RunSettings, itself: bool) -> str:
    if run.path == "circle":
        return tr("The hand draws a circle. Take K down to 0 and it drifts; raise K times and dt until K dt &gt; 2.")
    drag = tr("Pull the arm at its elbow, or its hand to another place.")
    does = tr("The autopilot swings the elbow; pull the arm anywhere to take over.") if itself else drag
    return f"{does} {tr('The elbow moves in the null space of the hand: |e| stays small.')}"


def _hold_words(run: RunSettings) -> str:
    if run.avoid == "guided":
        return tr("It keeps clear of the silver arm, which keeps its hand in the ring.")
    if run.avoid == "both":
        return tr("The silver arm keeps its hand in the ring, and both keep clear.")
    return tr("The silver arm keeps its hand in the ring, and keeps clear.")


def _who_avoids(run: RunSettings) -> str:
    return {
        "paper": tr("both keep clear of each other"),
        "both": tr("both keep clear of each other"),
        "free": tr("keeps clear") if run.scene == "master_slave" else tr("the other one keeps clear"),
        "guided": tr("the master keeps clear") if run.scene == "master_slave" else tr("your own one keeps clear"),
    }[run.avoid]


def status_html(pace: Pace, simulation: Simulation, sample: Sample) -> str:
    """Return the state of the clock and everything that is wrong, as pills."""
    run, law = simulation.settings, simulation.settings.law
    pills = [("halt", tr("paused"))] if pace.paused else [("go", tr("{rate}× real time", rate=f"{pace.rate:.1f}"))]
    if pace.slowed:
        pills.append(("halt", tr("slowed: the server is busy")))
    if sample.pair < 0:
        if run.gain * run.overdrive * run.dt >= 2.0:
            pills.append(("alarm", tr("K dt ≥ 2: unstable")))
        reason = authority_text(Authority(sample.authority), sample.joint, simulation)
        if reason:
            pills.append(("alarm", reason))
        return pills_html(pills)
    pills += [("alarm", tr("out of authority: {why}", why=reason)) for reason in _reasons(simulation, sample)]
    if law.law == "unprotected":
        pills.append(("halt", tr("avoidance is off")))
    if law.law in RETREATING and not both_avoid(run) and sample.approach > law.nominal_velocity and not law.feed_forward:
        faster = tr("the ball is faster than v") if run.scene == "ball" else tr("the hand is faster than v")
        pills.append(("alarm", faster))
    if sample.distance < 0.0:
        pills.append(("alarm", tr("the arm overlaps the ball") if run.scene == "ball" else tr("the arms overlap")))
    return pills_html(pills)


def _reasons(simulation: Simulation, sample: Sample) -> list[str]:
    """Return why arms cannot do what the law asks of them."""
    reasons = [authority_text(Authority(sample.authority), sample.joint, simulation)]
    if sample.second is not None:
        reasons.append(authority_text(Authority(sample.second.authority), sample.second.joint, simulation, second=True))
    return [reason for reason in dict.fromkeys(reasons) if reason]


def authority_text(authority: Authority, joint: int, simulation: Simulation, second: bool = False) -> str:
    """Return why an arm cannot do what the law asks of it, "" if it can."""
    match authority:
        case Authority.STOP:
            return tr("{joint} near its limit", joint=tr(simulation.joint_label(joint, second)))
        case Authority.SPEED:
            return tr("{joint} at its top speed", joint=tr(simulation.joint_label(joint, second)))
        case Authority.LEVERAGE:
            return tr("no joint moves this point")
        case _:
            return ""
