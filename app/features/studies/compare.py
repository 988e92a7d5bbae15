"""Panel with the studies' results."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Literal

import viser
from markupsafe import Markup

from app.features.studies.background_studies import BackgroundStudies
from app.features.studies.counterexample import BROKEN, Attack
from app.features.studies.counterexample_search import NAME, CounterexampleSearch
from app.features.studies.knob_search import KnobSearch
from app.features.studies.studies import Smoothness, Studies
from app.features.studies.value_texts import OF_A_STUDIED_VALUE, ONE_PAIR
from app.i18n.speaking import decimal, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.session.actions import Action
from app.session.frame import Frame
from app.session.relevant_settings import matters
from app.session.session import Session
from app.settings import ATTACK, Settings, to_query
from app.text.first_task_texts import in_symbols, said_of, wording
from app.text.templates import element, lowered, macros, tr_html
from scenes.quantities import DISTANCE, KeptQuantity
from scenes.rerun import WhatIf
from scenes.smoothness import StepStudy


class Compute(Action, newest_by=("what",)):
    """Start or stop a study, or replay its worst run."""

    what: Literal["smoothness", "same distance", "counterexample", "worst run"]


def attack_query(settings: Settings, attack: Attack) -> dict[str, str]:
    return {**to_query(replace(settings, run=attack.settings)), ATTACK: attack.text()}


class ComparePanel(PagePanel):
    """Lower part of the comparisons tab."""

    def __init__(self, page: PanelContext) -> None:
        self._studies, self._controls = page.session.parts.of(BackgroundStudies), page.controls
        page.handlers.add(Compute, self._compute)
        page.links.append(self._link)
        with page.controls.compare_tab:
            self._add_controls(page.client.gui, page.session)
        self._state: tuple[object, ...] = ()
        self._answers: tuple[object, ...] = (None, None)
        self._quantity = DISTANCE

    def _add_controls(self, gui: viser.GuiApi, session: Session) -> None:
        self._what_if = gui.add_html("")
        self._button = ChoiceButtons(
            gui,
            "how smooth",
            {"Measure": Compute("smoothness")},
            "Runs the last 10 s again at dt, dt/2, dt/4 and dt/8: the largest step of q̇ halves with dt unless the law jumps.",
            session.post,
        )
        self._smoothness = gui.add_html("")
        self._match = ChoiceButtons(
            gui,
            "same distance",
            {"Set the knob": Compute("same distance")},
            "Sets d_m, or another setting of the ghost’s law, so that it comes as near as the present law on the last 30 s; the present "
            "settings become the ghost. With a frozen ghost it sets the run’s law.",
            session.post,
        )
        self._matched = gui.add_html("")
        self._break = ChoiceButtons(
            gui,
            "try to break it",
            {"Search": Compute("counterexample"), "Watch": Compute("worst run")},
            "Searches for 20 s over start postures, ways and speeds for the run in which d falls farthest below dₘ although w ≤ v and the "
            "arm can do what the law asks for. Watch replays the worst run; Copy link then shares it.",
            session.post,
        )
        self._broken = gui.add_html("")

    def _compute(self, action: Compute) -> None:
        match action.what:
            case "smoothness":
                self._studies.measure_smoothness()
            case "same distance":
                self._studies.match_distance()
            case "counterexample":
                self._studies.counterexample.toggle()
            case "worst run":
                self._studies.counterexample.replay_worst()

    def _link(self, frame: Frame) -> Mapping[str, str] | None:
        attack = self._studies.counterexample.replayed
        if frame.shown.replay.file != NAME or attack is None:
            return None
        return attack_query(frame.live.settings, attack)

    def show(self, frame: Frame) -> None:
        settings, studies = frame.live.settings, self._studies
        questions, search, attack = studies.questions, studies.knob_search, studies.counterexample
        visible, asks = matters("ghost", settings), settings.page.what_if
        answers = questions.what_if, questions.smoothness
        state = (
            visible,
            asks,
            settings.run.quantity,
            attack.runs,
            *((one.busy, one.message) for one in (questions, search, attack)),
        )
        # Answers are compared by identity: they hold arrays, and are never changed.
        if state == self._state and all(a is b for a, b in zip(answers, self._answers, strict=True)):
            return
        self._state, self._answers = state, answers
        for block in (self._what_if, self._smoothness, self._matched, self._broken):
            block.visible = visible
        if (kept := settings.run.quantity) is not self._quantity:
            self._quantity = kept
            for row in (self._match, self._break):
                row.say(said_of(kept, OF_A_STUDIED_VALUE))
        self._button.show(visible=visible)
        self._match.show(visible=visible)
        self._what_if.content = _in_panel(self._asked(questions, settings.run.quantity) if asks else "")
        smoothness = questions.smoothness
        self._smoothness.content = _in_panel(
            _tip(tr(questions.message)) if smoothness is None else smoothness_html(smoothness)
        )
        self._matched.content = _in_panel(self._found(search, settings.run.quantity))
        offered = (0,) if attack.worst is None else (0, 1)
        self._break.show(0 if attack.busy else -1, offered, visible=visible)
        self._broken.content = _in_panel(_tip(attack_html(attack)))

    def _asked(self, questions: Studies, quantity: KeptQuantity) -> Markup:
        block = _what_if_block(questions, quantity)
        return block if questions.what_if is not None else flash_html(self._controls.places(("dm",))) + block

    def _found(self, search: KnobSearch, quantity: KeptQuantity) -> Markup:
        words = _tip(tr("Computing …") if search.busy else in_symbols(tr(search.message), quantity))
        return flash_html(self._controls.places(search.turned)) + words


def flash_html(places: tuple[tuple[str, str], ...]) -> Markup:
    """CSS that makes controls, or their closed tab, flash. `places`: see `Controls.places`."""
    rows = ",".join(
        f'div:has(>div>p>label[for="{control}"]),[data-dock-tab="{tab}"][aria-selected=false]'
        for control, tab in places
    )
    return element("style", "", Markup(f"{rows}{{animation:var(--duet-flash)}}")) if rows else Markup()


def _in_panel(block: str) -> Markup:
    return element("div", "", block, class_="duet")


def _tip(text: str) -> Markup:
    return element("p", text, class_="duet-tip") if text else Markup()


def _what_if_block(questions: Studies, quantity: KeptQuantity) -> Markup:
    if questions.what_if is not None:
        return what_if_html(questions.what_if)
    measuring = questions.smoothness is not None and not questions.smoothness.finished
    busy = questions.busy and not measuring
    waiting = (
        tr("Computing …")
        if busy
        else in_symbols(
            tr_html("Now move the flashing slider d<sub>m</sub> in the tab “Law”, or n, v or K."), quantity
        )
    )
    return _tip(waiting + Markup(" ") + tr(questions.message))


def attack_html(search: CounterexampleSearch) -> Markup:
    if search.worst is None:
        return lowered(tr("Searching …") if search.busy else tr(search.message))
    loss, promises = search.worst.loss, search.worst.attack.settings.law.entry.promises
    length = loss.lost if search.broken else loss.nearest
    run = search.worst.attack.settings
    kept = run.stages[loss.stage] if run.stages else run.quantity
    of_stage = f" {tr('It is the stage “{stage}”.', stage=tr(kept.label))}" if run.stages else ""
    counts = {"runs": search.runs, "mm": decimal(f"{1000.0 * length:.1f}") if math.isfinite(length) else "∞"}
    if not search.broken:
        none = tr(
            "{runs} runs, and none broke the promise: d_law comes to {mm} mm above d_m while its conditions hold.",
            **counts,
        )
        return lowered(in_symbols(none, kept) + of_stage)
    words = tr(
        "{runs} runs: in the worst, d_law falls {mm} mm below d_m with w ≤ v, a regular J_d and full authority.",
        **counts,
    )
    words = in_symbols(words, kept)
    if not promises:
        verdict = tr("This law makes no promise.")
    elif loss.strict > BROKEN:
        verdict = tr("All conditions held: here the promise breaks.")
    else:
        verdict = tr(wording(ONE_PAIR, kept, OF_A_STUDIED_VALUE))
    return lowered(f"{words}{of_stage} {verdict}")


def what_if_html(answer: WhatIf) -> Markup:
    joints, kept = answer.settings.experiment.error_unit == "rad²", answer.settings.quantity
    error = (
        (lambda e2: decimal(f"{math.degrees(math.sqrt(e2)):.1f}°"))
        if joints
        else (lambda e2: f"{1000.0 * math.sqrt(e2):.0f} mm")
    )
    d_m = answer.settings.law.critical_distance
    rows: tuple[tuple[str, Callable[..., str]], ...] = (
        (
            in_symbols(tr_html('least <b class="d">d</b>'), kept),
            lambda s: f"{1000.0 * s.d_min:.0f} {kept.page_unit}".replace("-", "−"),
        ),
        (
            in_symbols(tr_html('below <b class="dm">d<sub>m</sub></b>'), kept),
            lambda s: f"{100.0 * s.share_below:.0f} %",
        ),
        (tr_html('largest <b class="e">|e|</b>'), lambda s: error(s.e2_max)),
        (tr("largest step of q̇"), lambda s: decimal(f"{s.dq_step_max:.3f} rad/s")),
    )
    numbers = [(name, of(answer.before), of(answer.summary)) for name, of in rows]
    asked = in_symbols(tr_html("With d<sub>m</sub> = {mm} mm.", mm=f"{1000.0 * d_m:.0f}"), kept)
    return macros("features/studies/compare.html").what_if(f"{answer.seconds:.0f}", numbers, asked)


def smoothness_html(found: Smoothness) -> Markup:
    runs = [(tr("law"), found.law), *([(tr("ghost"), found.ghost)] if found.ghost is not None else [])]
    steps = zip(*(measured.largest for _, measured in runs), strict=True)
    rows = [
        (decimal(f"{1000.0 * dt:g} ms"), [*map(_step, largest)])
        for dt, largest in zip(found.law.dts, steps, strict=True)
    ]
    words = [f"{name[:1].upper()}{name[1:]}: {_words(measured)}" for name, measured in runs]
    return macros("features/studies/compare.html").smoothness(
        [name for name, _ in runs], rows, words, f"{found.law.seconds:.0f}"
    )


def _words(measured: StepStudy) -> str:
    first, *_, finest = (step or 0.0 for step in measured.largest)
    match measured.verdict:
        case "measuring":
            return tr("Measuring …")
        case "still":
            return tr("Nothing moved that keeps clear.")
        case "smooth":
            return tr("Smooth: half the time step, half the largest step.")
        case "jump":
            return tr(
                "A jump of {jump} rad/s: it stays, however small the time step.",
                jump=decimal(f"{finest:.2g}"),
            )
        case _:
            parts = measured.dts[0] / measured.dts[-1]
            return tr(
                "Between: at dt/{parts}, {share} % of the largest step are left; {smooth} % would be smooth, 100 % a jump.",
                parts=f"{parts:.0f}",
                share=f"{100.0 * finest / first:.0f}",
                smooth=f"{100.0 / parts:.0f}",
            )


def _step(value: float | None) -> str:
    return "…" if value is None else decimal(f"{value:.4f}")
