"""Tip, status, promise, error, and the law's equation."""

import math
from collections.abc import Callable
from typing import Final

import viser
from markupsafe import Markup

from app.i18n.speaking import N_, decimal, tr
from app.page.panels.distance_rate import nearest_is_bolted, pills_html, promise_html
from app.plots.time_series import Swivel
from app.recording.run_file import SHOWN_DIGITS, made_with
from app.session.clock import Pace
from app.session.frame import Frame
from app.session.late_law import LateLawStatus
from app.session.shown import Shown
from app.text.experiment_texts import EXPERIMENT_TEXTS
from app.text.first_task_texts import FIRST_TASK_TEXTS, in_symbols, wording
from app.text.law_texts import equation_html
from app.text.lever_texts import lever_text
from app.text.templates import element, macros
from controllers.kinematics import DAMPING, null_space_projector
from controllers.limits import Authority
from controllers.tasks import TASK_DIMENSION
from scenes.first_task.wall import WallTask
from scenes.history import ArmSample, Sample
from scenes.simulation import Simulation

PERIOD: Final = 0.15
"""Time between two refreshes [s]; faster numbers cannot be read."""


LAST: Final = 1e6
"""Order after all controls."""


class Readout:
    """Blocks of text and numbers. `tip`: returns what to do and watch."""

    def __init__(self, gui: viser.GuiApi, tip: Callable[[Shown], str]) -> None:
        self._tip_text = tip
        self._tip, self._status, self._numbers, self._equation = (gui.add_html("") for _ in range(4))
        self._equation_last = gui.add_html("", order=LAST, visible=False)
        self._next = 0.0
        self._shown: tuple[object, ...] = ()

    def show(self, frame: Frame, asking: bool, equation_last: bool = False) -> None:
        """Refresh changes every `PERIOD`, or at once while the run is paused.

        Args:
            asking: True shows only the clock.
            equation_last: True shows the equation after all controls, which it then does not move.
        """
        self._equation.visible, self._equation_last.visible = not equation_last, equation_last
        if (frame.now < self._next and not frame.pace.paused) or (frame.state, asking) == self._shown:
            return
        self._shown, self._next = (frame.state, asking), frame.after(PERIOD)
        shown, simulation, sample = frame.shown, frame.simulation, frame.sample
        self._tip.content = tip_html(self._tip_text(shown), longest_tip(shown))
        law = shown.law_status
        pills = replay_html(shown) + status_html(frame.pace, simulation, sample, asking)
        pills += Markup() if frame.replayed else late_law_html(law)
        self._status.content = element("div", "", pills, class_="duet duet-status", role="status")
        pills = promise_html(simulation, sample, law.file is not None) + error_html(
            simulation, sample, frame.ghost
        )
        numbers = element("div", "", pills, class_="duet-status") if pills else tiles_html(simulation, sample)
        self._numbers.content = "" if asking else element("div", "", numbers, class_="duet")
        if law.file is not None:
            file = (
                tr(made_with(law.file, law.sha256))
                if frame.replayed
                else f"{law.file}, SHA-256 {law.sha256[:SHOWN_DIGITS]}…"
            )
            equation = macros("text/equation.html").of_file(file)
        else:
            equation = equation_html(frame.settings.run)
        self._equation.content = self._equation_last.content = element("div", "", equation, class_="duet")


def tip_html(tip: str, kept: str) -> Markup:
    """Tip in the space of `kept`, the longest one."""
    return macros("page/panels/readout.html").tip(tip, kept)


def replay_html(shown: Shown) -> Markup:
    """Replayed moment or loading run; empty while live."""
    replay = shown.replay
    if replay.coming:
        return pills_html([("past", tr("{file} is being loaded", file=replay.coming))])
    if replay.time is None:
        return Markup()
    text = N_("then: {time} s") if replay.reviewed else N_("the past: {time} s")
    return pills_html([("past", tr(text, time=decimal(f"{replay.time:.1f}")))])


def late_law_html(law: LateLawStatus) -> Markup:
    """State of the late law; empty without one."""
    file, own = law.file or law.ghost_file, law.file
    if file is None:
        return Markup()
    if law.problem:
        why = tr(law.problem)
        pill = (
            "alarm",
            tr("the arm has stopped: {why}", why=why) if own else tr("the ghost has stopped: {why}", why=why),
        )
    elif law.waits:
        pill = "halt", tr("waiting for {file}", file=file)
    elif law.slow is not None:
        needs, allowed = (decimal(f"{1e3 * seconds:.2g}") for seconds in law.slow)
        pill = (
            "halt",
            tr(
                "slowed: your law needs {needs} ms a call; real time allows {allowed} ms",
                needs=needs,
                allowed=allowed,
            ),
        )
    elif law.away:
        pill = "past", tr("{file} is missing; its last version keeps running", file=file)
    else:
        pill = "go", tr("runs {file}", file=file) if own else tr("the ghost runs {file}", file=file)
    return pills_html([pill])


# --- tiles ---------------------------------------------------------------------------------------------------------------------


def tiles_html(simulation: Simulation, sample: Sample) -> Markup:
    """Numbers of a single arm; empty with an obstacle."""
    if sample.pair >= 0:
        return Markup()
    run, arm = simulation.settings, simulation.avoiding
    J = simulation.kinematics.hand_jacobian(arm)[: TASK_DIMENSION[simulation.room.task(run)]]
    # Number of dimensions that the hand leaves free: n − m, more at a singular posture.
    free = float(null_space_projector(J, DAMPING).trace())
    angle = math.degrees(Swivel(simulation.room, arm).angle(sample.positions))
    k = run.gain * run.overdrive * run.dt
    # Each: CSS class of its colour, text, label, and whether it is alarming.
    tiles = [
        ("e", f"{sample.error * 1000.0:.1f}", "|e|, mm", False),
        ("lam", f"{free:.1f}", tr("free, tr N"), False),
        ("d", "–" if angle != angle else f"{angle:.0f}°".replace("-", "−"), tr("elbow"), False),
        ("w", f"{k:.3g}", "K dt ≥ 2" if k >= 2.0 else "K dt < 2", k >= 2.0),
    ]
    return macros("page/panels/readout.html").tiles(tiles)


def error_html(simulation: Simulation, sample: Sample, ghost: Simulation | None = None) -> Markup:
    """|e| with an obstacle, and the ghost's; empty for a single arm."""
    if sample.pair < 0:
        return Markup()
    beside = "" if ghost is None else _error_text(ghost, ghost.sample())
    return macros("page/panels/readout.html").error(_error_text(simulation, sample), beside)


def _error_text(simulation: Simulation, sample: Sample) -> str:
    if simulation.settings.experiment.error_unit != "rad²":
        return f"{sample.error * 1000.0:.0f} mm"
    error = math.degrees(sample.error)
    if simulation.settings.experiment.follows == "person" and sample.second is not None:
        orange = math.degrees(math.sqrt(sample.second.squared_error))
        return tr("{silver}° silver, {orange}° orange", silver=f"{error:.0f}", orange=f"{orange:.0f}")
    return decimal(f"{error:.1f}°")


# --- words ---------------------------------------------------------------------------------------------------------------------


def longest_tip(session: Shown) -> str:
    """Longest tip, by autopilot or visitor."""
    run = session.settings.run
    return max((EXPERIMENT_TEXTS[run.scene](run, itself)[0] for itself in (True, False)), key=len)


def tip_text(session: Shown, operated: bool = True) -> str:
    """What to do and watch; if not `operated`, only what to watch."""
    if session.replay.reviewed:
        return tr(
            "The run is stopped, and this is an earlier moment. Drag over a plot for another one. Space continues from the end."
        )
    if session.replay.time is not None:
        return tr("Recording. Space: play or pause. Full stop: one step. R: back to live.")
    run = session.settings.run
    itself = session.settings.page.autopilot and session.held is None
    tip, watched = EXPERIMENT_TEXTS[run.scene](run, itself)
    if not operated:
        who = tr("The autopilot moves the orange arm.") if itself else tr("The teacher moves the orange arm.")
        led = run.experiment.moves == "arm" and run.experiment.obstacle == "arm"
        return f"{who} {watched}" if led else watched
    simulation = session.simulation
    if (
        min(arm.joints.stop - arm.joints.start for arm in simulation.room.arms) > 5
        or simulation.keeper is None
    ):
        return tip
    return f"{tip} {tr('Five joints keep the hand’s place, not its turn: two are left for everything else, not four.')}"


def status_html(pace: Pace, simulation: Simulation, sample: Sample, asking: bool = False) -> Markup:
    """Clock and all problems; only the clock while `asking`."""
    run, law = simulation.settings, simulation.settings.law
    pills = (
        [("halt", tr("paused"))]
        if pace.paused
        else [("go", tr("{rate}× real time", rate=decimal(f"{pace.rate:.1f}")))]
    )
    if pace.slowed:
        pills.append(("halt", tr("slowed: the server is busy")))
    if asking:
        return pills_html(pills)
    reasons = _reasons(simulation, sample)
    if sample.pair < 0:
        if run.gain * run.overdrive * run.dt >= 2.0:
            pills.append(("alarm", tr("K dt ≥ 2: unstable")))
        return pills_html([*pills, *(("alarm", reason) for reason in reasons)])
    pills += [("alarm", reason) for reason in reasons]
    if simulation.start_problem is not None:
        pills.append(("alarm", in_symbols(tr(str(simulation.start_problem)), run.quantity)))
    if any(isinstance(task, WallTask) and task.held_back for task in simulation.roles.tasks):
        pills.append(("halt", tr("The wall stops before the base, which cannot give way.")))
    ball, other = simulation.room.ball is not None, FIRST_TASK_TEXTS.get(run.quantity.name)
    if law.entry.sees == "nothing":
        pills.append(("halt", tr(wording("avoidance is off", run.quantity))))
    # Along the row of the law, as on the card and in the promise.
    if (
        law.entry.retreats
        and not run.both_avoid
        and sample.law_approach > law.nominal_velocity
        and not run.adds_w
    ):
        faster = tr("the ball is faster than v") if ball else tr("the hand is faster than v")
        pills.append(("alarm", faster if other is None else tr("the wall is faster than v")))
    if sample.distance < 0.0 and other is not None:
        pills.append(("alarm", tr(other.failed)))
    elif sample.distance < 0.0:
        pills.append(("alarm", tr("the arm overlaps the ball") if ball else tr("the arms overlap")))
    return pills_html(pills)


def _reasons(simulation: Simulation, sample: Sample) -> list[str]:
    if nearest_is_bolted(simulation, sample):
        return [tr("Bolted down: a smaller d_m helps.")]
    reasons = [authority_text(sample, simulation)]
    if sample.second is not None:
        reasons.append(authority_text(sample.second, simulation, second=True))
    whys = [reason for reason in dict.fromkeys(reasons) if reason]
    if sample.pair < 0:
        return whys
    kept = simulation.settings.quantity
    said = wording("the arm cannot move away: {why}", kept)
    return [in_symbols(tr(said), kept).format(why=why) for why in whys]


def authority_text(arm: ArmSample, simulation: Simulation, second: bool = False) -> str:
    """Reason why an arm cannot obey the law, or ""."""
    match Authority(arm.authority):
        case Authority.STOP:
            return tr("{joint} near its limit", joint=tr(simulation.joint_label(arm.joint, second)))
        case Authority.SPEED:
            return tr("{joint} at its top speed", joint=tr(simulation.joint_label(arm.joint, second)))
        case Authority.LEVERAGE:
            return lever_text(arm.lever, simulation.settings.quantity)
        case _:
            return ""
