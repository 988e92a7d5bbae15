"""What was computed beside the run, in numbers: what if, and how smooth the law and its ghost are."""

import math
from collections.abc import Callable

import viser

from app.i18n.speaking import tr
from app.page.panels.choice_buttons import ChoiceButtons
from app.session.frame import Frame
from app.session.relevant_settings import matters
from app.session.session import Session
from app.session.studies import Smoothness
from scenes.experiments import EXPERIMENTS
from scenes.rerun import WhatIf
from scenes.smoothness import Measured


class ComparePanel:
    """The lower part of the tab on comparisons."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._what_if = gui.add_html("")
        self._button = ChoiceButtons(
            gui,
            "how smooth",
            ("Measure",),
            "Runs the last 10 s again at dt, dt/2, dt/4 and dt/8: the largest step of q̇ halves with dt unless the law jumps.",
            lambda _: session.post(session.measure_smoothness, "measure"),
        )
        self._smoothness = gui.add_html("")
        self._match = ChoiceButtons(
            gui,
            "same distance",
            ("Set the knob",),
            "Sets d_m, or another setting of the ghost’s law, so that it comes as near as the present law on the last 30 s; the present "
            "settings become the ghost. Beside a frozen ghost it sets the run’s law.",
            lambda _: session.post(session.match_distance, "match"),
        )
        self._matched = gui.add_html("")
        self._state: tuple[object, ...] = ()
        self._answers: tuple[object, ...] = (None, None)

    def show(self, frame: Frame) -> None:
        """Bring it up to date; hide it where there is nothing to compare."""
        del frame
        session = self._session
        visible = matters("ghost", session.settings)
        answers = session.what_if, session.studies.smoothness
        state = visible, session.studies.busy, session.studies.message, session.settings.page.what_if
        state = *state, session.knob_search.busy, session.knob_search.message
        # Answers are compared by identity: they hold arrays, and are never changed.
        if state == self._state and all(a is b for a, b in zip(answers, self._answers, strict=True)):
            return
        self._state, self._answers = state, answers
        self._what_if.visible = self._smoothness.visible = self._matched.visible = visible
        self._button.show(visible=visible)
        self._match.show(visible=visible)
        self._what_if.content = f'<div class="duet">{_what_if_block(session)}</div>'
        self._smoothness.content = f'<div class="duet">{_smoothness_block(session)}</div>'
        self._matched.content = f'<div class="duet">{_match_block(session)}</div>'


def _what_if_block(session: Session) -> str:
    if not session.settings.page.what_if:
        return ""
    if session.what_if is not None:
        return what_if_html(session.what_if)
    measuring = session.studies.smoothness is not None and not session.studies.smoothness.finished
    waiting = tr("Now move d<sub>m</sub>, n, v, K or another setting of the law.")
    if session.studies.busy and not measuring:
        waiting = tr("Computing …")
    return f'<p class="duet-tip">{waiting} {tr(session.studies.message)}</p>'


def _smoothness_block(session: Session) -> str:
    if session.studies.smoothness is None:
        return f'<p class="duet-tip">{tr(session.studies.message)}</p>' if session.studies.message else ""
    return smoothness_html(session.studies.smoothness)


def _match_block(session: Session) -> str:
    search = session.knob_search
    said = tr("Computing …") if search.busy else tr(search.message)
    return f'<p class="duet-tip">{said}</p>' if said else ""


def what_if_html(answer: WhatIf) -> str:
    """Return how the last seconds were, and how they would have been."""
    joints = EXPERIMENTS[answer.settings.scene].error_unit == "rad²"
    error = (lambda e2: f"{math.degrees(math.sqrt(e2)):.1f}°") if joints else (lambda e2: f"{1000.0 * math.sqrt(e2):.0f} mm")
    d_m = answer.settings.law.critical_distance
    rows: tuple[tuple[str, Callable[..., str]], ...] = (
        (tr('least <b class="d">d</b>'), lambda s: f"{1000.0 * s.d_min:.0f} mm"),
        (tr('below <b class="dm">d<sub>m</sub></b>'), lambda s: f"{100.0 * s.share_below:.0f} %"),
        (tr('largest <b class="e">|e|</b>'), lambda s: error(s.e2_max)),
        (tr("largest step of q̇"), lambda s: f"{s.dq_step_max:.3f} rad/s"),
    )
    body = "".join(f"<tr><td>{name}</td><td>{of(answer.before)}</td><td>{of(answer.summary)}</td></tr>" for name, of in rows)
    coarse = tr("Coarse, in steps of {ms} ms; the exact answer follows.", ms=f"{1000.0 * answer.settings.dt * answer.stride:g}")
    draft = " " + coarse if answer.stride > 1 else ""
    last = tr("last {s} s", s=f"{answer.seconds:.0f}")
    return (
        f'<table class="duet-numbers"><tr><th>{last}</th><th>{tr("as it was")}</th><th>{tr("what if")}</th></tr>'
        f'{body}</table><p class="duet-tip">{tr("With d<sub>m</sub> = {mm} mm.", mm=f"{1000.0 * d_m:.0f}")}{draft}</p>'
    )


def smoothness_html(found: Smoothness) -> str:
    """Return the largest step of q̇ at every time step, and what it says."""
    runs = [(tr("law"), found.law), *([(tr("ghost"), found.ghost)] if found.ghost is not None else [])]
    head = "".join(f"<th>{name}</th>" for name, _ in runs)
    body = "".join(
        f"<tr><td>{1000.0 * dt:g} ms</td>" + "".join(f"<td>{_step(measured.largest[i])}</td>" for _, measured in runs) + "</tr>"
        for i, dt in enumerate(found.law.dts)
    )
    words = "<br>".join(f"{name[:1].upper()}{name[1:]}: {_words(measured)}" for name, measured in runs)
    return (
        f'<table class="duet-numbers"><tr><th>dt</th>{head}</tr>{body}</table>'
        f'<p>{words}</p><p class="duet-tip">{tr("Largest step of q̇ [rad/s] in the last {s} s.", s=f"{found.law.seconds:.0f}")}</p>'
    )


def _words(measured: Measured) -> str:
    """Return the verdict as a sentence."""
    first, *_, finest = (step or 0.0 for step in measured.largest)
    match measured.verdict:
        case "measuring":
            return tr("Measuring …")
        case "still":
            return tr("Nothing moved that keeps clear.")
        case "smooth":
            return tr("Smooth: half the time step, half the largest step.")
        case "jump":
            return tr("A jump of {jump} rad/s: it stays, however small the time step.", jump=f"{finest:.2g}")
        case _:
            parts = measured.dts[0] / measured.dts[-1]
            return tr(
                "Between: at dt/{parts}, {share} % of the largest step are left; {smooth} % would be smooth, 100 % a jump.",
                parts=f"{parts:.0f}",
                share=f"{100.0 * finest / first:.0f}",
                smooth=f"{100.0 / parts:.0f}",
            )


def _step(value: float | None) -> str:
    return "…" if value is None else f"{value:.4f}"
