"""The operator's buttons and keys in the lessons."""

from collections.abc import Callable
from typing import Literal

import viser

from app.features.custom_law.law_editor import LawEditor
from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import MOST_CHOICES, Lesson
from app.features.lessons.panel.answer_boxes import Forecasts, ReasonBox, add_guess_box
from app.features.lessons.panel.lesson_html import NEXT, choice_label, rules_html
from app.features.lessons.panel.lesson_keys import LESSON_KEYS
from app.features.lessons.panel.lesson_panel import IN_LESSONS, ORDER, VERDICT
from app.features.lessons.panel.lesson_view import LessonView
from app.features.lessons.panel.null_motion_sliders import NullMotionSliders
from app.features.lessons.session import lesson_actions
from app.features.lessons.step_view import StepView
from app.i18n.speaking import N_, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.drawing_board import DrawingBoard
from app.page.panels.hotkeys import keys_of
from app.session.actions import Action, Digit, Nudge, Pause, Reset, SingleStep, Toggle
from app.session.frame import Frame
from app.text.lesson_text import plain
from app.text.templates import element
from app.web.control_events import on_press
from app.web.viser_internals import uuid_of


class AskToLeave(Action):
    """Ask before a whole class leaves the lessons; `asks=False` closes the question."""

    asks: bool = True


class LessonLawTask:
    """The step that asks for a custom law."""

    def __init__(self, view: LessonView) -> None:
        self._lessons, self._panel = view.lessons, view.panel
        self.order = ORDER["attempt"] - 1.0

    @property
    def asked(self) -> bool:
        return self._lessons.own_tests is not None

    @property
    def tab(self) -> viser.GuiTabHandle | None:
        return None if self._lessons.listing else self._panel.tab

    def run_again(self) -> None:
        self._lessons.act(lesson_actions.Press("again"))


class LessonControls(PagePanel):
    """Its handlers of Space, ., R and the arrows also act without a lesson, after those of a replay or the
    lever.
    """

    def __init__(self, page: PanelContext) -> None:
        client, handlers, view = page.client, page.handlers, page.view.part(LessonView)
        self._instead, self._handlers, self._gizmos = page.instead, handlers, page.gizmos
        self._close_question: Callable[[], None] | None = None
        self._gui, self._session, self._controls = client.gui, page.session, page.controls
        self._run, self._panel = view.lessons, view.panel
        for editor in page.made:
            if isinstance(editor, LawEditor):
                editor.task, view.panel.edits = LessonLawTask(view), True
        self._list: viser.GuiButtonHandle | None = None
        self._commands: list[viser.CommandHandle] = []
        self._shown: tuple[object, ...] = ()
        self._list_button = client.gui.add_button(
            tr("Lessons"),
            icon=viser.Icon.SCHOOL,
            hint=tr("Lessons: predict, run, compare, explain."),
            order=-4.0,
        )
        on_press(self._list_button, lambda: self._post(lesson_actions.Press("list")))
        handlers.add(lesson_actions.LessonAction, self._act)
        handlers.add(AskToLeave, lambda action: self._ask_to_leave(action.asks))
        handlers.add_first(Digit, self._choose)
        handlers.add_first(Toggle, self._keep_autopilot)
        handlers.add(Pause, self._pause)
        handlers.add(SingleStep, self._single_step)
        handlers.add(Reset, self._reset)
        handlers.add(Nudge, self._nudge)

    @property
    def needs_controls(self) -> bool:
        return self._run.open or self._run.listing

    # ---- keys --------------------------------------------------------------------------------------------------------------

    def _act(self, action: lesson_actions.LessonAction) -> None:
        # Otherwise the lesson's run would replace what is being loaded.
        if not (action == lesson_actions.Press("run") and self._session.player.coming):
            self._run.act(action)

    def _choose(self, action: Digit) -> bool:
        if self._run.open:
            self._run.act(lesson_actions.Choose(action.number - 1))
        return self._run.open

    def _keep_autopilot(self, action: Toggle) -> bool:
        """Ignore the autopilot's key while the lesson controls the movement."""
        return action.what == "autopilot" and self._run.hands_off

    def _pause(self, action: Pause) -> None:
        del action
        if self._run.open:
            self._run.act(lesson_actions.Press("run"))
        else:
            self._session.control.toggle_pause()

    def _single_step(self, action: SingleStep) -> None:
        del action
        if self._run.locked:
            self._run.act(lesson_actions.Press("run"))
        else:
            self._session.control.single_step()

    def _reset(self, action: Reset) -> None:
        del action
        self._gizmos.forget_drag()
        if self._run.open:
            self._run.act(lesson_actions.Press("again"))
        else:
            self._session.reset()

    def _nudge(self, action: Nudge) -> None:
        if not self._run.hands_off:
            self._gizmos.nudge(action)
        elif action.right:
            self._run.act(lesson_actions.Press("back") if action.right < 0 else lesson_actions.Press("next"))

    # ---- buttons -----------------------------------------------------------------------------------------------------------

    def _make(self) -> viser.GuiButtonHandle:
        assert self._panel.tab is not None
        gui, run = self._gui, self._run
        with self._panel.tab:
            listing = self._button(lesson_actions.Press("list"), 1.0)
            self._openers = [self._opener(i, lesson) for i, lesson in enumerate(run.book.lessons)]
            self._panel.openers = {
                one.id: uuid_of(b) for one, b in zip(run.book.lessons, self._openers, strict=True)
            }
            most_steps = max((len(lesson.steps) for lesson in run.book.lessons), default=0)
            self._steps = ChoiceButtons(
                gui,
                "step",
                {str(i + 1): lesson_actions.GoTo(None, i) for i in range(most_steps)},
                "Any step at any time.",
                self._post,
                order=2.0,
            )
            self._board = DrawingBoard(
                gui,
                self._session.post,
                lambda at, curve: run.act(lesson_actions.Draw(*at, curve)),
                IN_LESSONS,
            )
            self._panel.guess_box = add_guess_box(gui, self._session.post)
            self._choices = [
                self._button(lesson_actions.Choose(i), ORDER["choices"] + 1.0 + i)
                for i in range(MOST_CHOICES)
            ]
            self._start = self._button(lesson_actions.Press("run"), ORDER["choices"] + 8.0)
            self._why = self._button(lesson_actions.Press("why"), VERDICT + 0.1)
            self._own_curve = self._button(lesson_actions.Press("curve"), VERDICT + 0.2)
            self._flash = gui.add_html("", order=0.0)
            self._reason = ReasonBox(gui, self._session.post, self._panel.tab)
            self._forecasts = Forecasts(gui, self._session, run, self._panel.tab)
            self._motions = NullMotionSliders(gui, self._session, run, self._handlers)
            self._check = self._button(lesson_actions.Press("check"), ORDER["after"] + 8.0)
            self._hint = self._button(lesson_actions.Press("hint"), ORDER["hints"] + 1.0)
            self._next = self._button(lesson_actions.Press("next"), ORDER["hints"] + 5.0)
            self._nav = ChoiceButtons(
                gui,
                "",
                {"Back": lesson_actions.Press("back"), "Reset step": lesson_actions.Press("reset")},
                "Reset restarts the step." if self._instead else "B: back. N: next. Reset restarts the step.",
                self._post,
                order=ORDER["hints"] + 6.0,
            )
            self._leave = self._button(lesson_actions.Press("leave"), ORDER["hints"] + 7.0)
        return listing

    def _opener(self, index: int, lesson: Lesson) -> viser.GuiButtonHandle:
        button = self._button(lesson_actions.GoTo(index, None), ORDER["list"] + 1.0)
        button.label = f"{lesson.number}  {plain(lesson.title)}"
        return button

    def _post(self, action: lesson_actions.LessonAction) -> None:
        leaves = action == lesson_actions.Press("leave")
        self._session.post(AskToLeave() if self._instead and leaves else action)

    def _ask_to_leave(self, asks: bool) -> None:
        if self._close_question is not None and not asks:
            self._close_question()
            self._close_question = None
        if self._close_question is not None or not asks:
            return
        with self._gui.add_modal(tr("Leave the lessons?")) as modal:
            said = tr("The whole class leaves the lesson with you. Its answers are kept.")
            self._gui.add_html(element("p", said, class_="duet"))
            # The first button gets the keyboard focus.
            stay = self._gui.add_button(tr("Stay"))
            leave = self._gui.add_button(tr("Leave with the class"), color="gray")

        def leave_all() -> None:
            self._session.post(lesson_actions.Press("leave"))
            self._session.post(AskToLeave(False))

        self._close_question = modal.close
        on_press(leave, leave_all)
        on_press(stay, lambda: self._session.post(AskToLeave(False)))

    def _button(self, action: lesson_actions.LessonAction, order: float) -> viser.GuiButtonHandle:
        return on_press(self._gui.add_button("", visible=False, order=order), lambda: self._post(action))

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def show(self, frame: Frame) -> None:
        run = self._run
        # An open lesson has its own button to leave it, visible while a narrow window folds the controls.
        self._list_button.visible = bool(run.book.lessons) and not (run.open or run.listing)
        if run.open and not self._commands:
            self._commands = [
                hotkey.add_to(self._gui, self._post) for hotkey in keys_of(LESSON_KEYS, self._instead)
            ]
        elif not run.open and self._commands:
            for command in self._commands:
                command.remove()
            self._commands.clear()
        if not (run.open or run.listing):
            self._shown = ()
            return
        if self._list is None:
            self._list = self._make()
        self._motions.show(frame)
        walk, paused = run.walk, frame.live.pace.paused
        over = run.over
        state = run.version, paused, over
        if state != self._shown:
            self._shown = state
            self._arrange_list(self._list)
            if not run.listing:
                view = run.walk.view()
                self._arrange(view, paused, over)
                self._reason.show(view)
                changed = view.contrast.keys if view.contrast is not None else ()
                self._flash.content = flash_style(self._controls.places(changed))
                self._arrange_challenge(view, self._foremost(view, paused, over) == "check")
                self._arrange_settings(
                    view.step.controls if view.phase is Phase.CHALLENGE or view.yours else ()
                )
                drawing = view.step.drawing if view.phase is Phase.PREDICT else None
                self._board.show((view.lesson.id, view.step.id), drawing, walk.done.drawing)

    def _arrange_list(self, button: viser.GuiButtonHandle) -> None:
        run = self._run
        label = N_("Back to the lesson") if run.open else N_("Close the list")
        _offer(button, True, tr(label if run.listing else N_("All lessons")), "gray")
        for opener in self._openers:
            opener.visible = run.listing
        _offer(self._leave, run.open and not run.listing, tr("Leave the lessons"), "gray")
        if run.listing:
            self._steps.show(visible=False)
            self._nav.show(visible=False)
            view = run.walk.view()
            self._reason.show(None)
            self._flash.content = ""
            self._forecasts.show(view, None)
            self._arrange_settings(())
            self._board.show((view.lesson.id, view.step.id), None, ())
            for other in (
                *self._choices,
                self._start,
                self._why,
                self._own_curve,
                self._check,
                self._hint,
                self._next,
            ):
                other.visible = False

    def _arrange(self, view: StepView, paused: bool, over: bool) -> None:
        self._steps.show(view.index, tuple(range(len(view.lesson.steps))))
        asking = view.phase in (Phase.PREDICT, Phase.DO)
        for i, button in enumerate(self._choices):
            if asking and i < len(view.choices):
                chosen = i == view.done.choice
                _offer(
                    button, True, choice_label(i + 1, view.choices[i], chosen), "blue" if chosen else "gray"
                )
            else:
                button.visible = False
        again = N_("Next push") if self._run.walk.pushes else N_("Run again")
        label = N_("Pause") if not paused else again if over else N_("lesson\x04Run")
        label = N_("Run (predict first)") if view.locked else label
        runs = (asking or view.showing or view.phase is Phase.CHALLENGE) and not view.step.concept
        foremost = self._foremost(view, paused, over)
        _offer(self._start, runs, tr(label), None if foremost == "run" else "gray", disabled=view.locked)
        _offer(self._why, view.why and not view.showing, tr("Show me why"), "gray")
        _offer(self._own_curve, view.own_curve and not view.showing, tr("Run with my curve"), "gray")
        self._nav.show(offered=(0, 1) if view.can_back else (1,))
        _offer(self._next, view.can_next, next_label(view), None if foremost == "next" else "gray")

    def _foremost(self, view: StepView, paused: bool, over: bool) -> Literal["run", "check", "next"]:
        challenge = view.step.challenge if view.phase is Phase.CHALLENGE else None
        if challenge is None:
            return (
                "run"
                if view.phase is Phase.PREDICT or (not over and (view.phase is Phase.DO or view.showing))
                else "next"
            )
        if self._run.walk.done.passed:
            return "next"
        if self._run.walk.pushes and over:
            return "run"
        return "check" if over or not paused or challenge.forecasts or challenge.custom_law else "run"

    def _arrange_challenge(self, view: StepView, to_check: bool) -> None:
        challenge = view.step.challenge if view.phase is Phase.CHALLENGE else None
        self._forecasts.show(view, challenge)
        tests = self._run.own_tests
        label = tr("Check my run") if challenge is None or not challenge.forecasts else tr("Check my numbers")
        label = tr("Count this push") if challenge is not None and challenge.best_of else label
        running = tests is not None and tests.running
        if tests is not None:
            label = tr("Testing …") if running else tr("Test my law")
        there = challenge is not None and (tests is None or tests.file is not None)
        counted = self._run.walk.pushes and self._run.over
        _offer(self._check, there and not counted, label, None if to_check else "gray", disabled=running)
        label = tr("Hint {number} of {count}", number=len(view.hints) + 1, count=len(view.step.hints))
        _offer(self._hint, challenge is not None and len(view.hints) < len(view.step.hints), label, "gray")

    def _arrange_settings(self, keys: tuple[str, ...]) -> None:
        assert self._panel.tab is not None
        twins = self._controls.twins
        for place, key in enumerate(keys):
            if key not in twins:
                with self._panel.tab:
                    self._controls.add_twin(key, ORDER["choices"] + 7.0 + 0.1 * place)
        for key, control in twins.items():
            control.visible = key in keys


def flash_style(places: tuple[tuple[str, str], ...]) -> str:
    rows = ",".join(
        f'div:has(>div>p>label[for="{control}"]),[data-dock-tab="{tab}"][aria-selected=false]'
        for control, tab in places
    )
    return rules_html(f"{rows}{{animation:var(--duet-flash)}}") if rows else ""


def _offer(
    button: viser.GuiButtonHandle,
    visible: bool,
    label: str,
    color: Literal["gray", "blue"] | None = None,
    disabled: bool = False,
) -> None:
    button.label, button.color, button.disabled, button.visible = label, color, disabled, visible


def next_label(view: StepView) -> str:
    if view.showing:
        return tr("Back to the outcome")
    place = view.phases.index(view.phase)
    if place + 1 < len(view.phases):
        if view.phase is Phase.PREDICT and view.step.concept:
            return tr("Next: the reply")
        if view.phase is Phase.DO and not view.yours:
            return tr("Skip the run")
        return tr(NEXT[view.phases[place + 1].value])
    return tr("Next step") if view.index + 1 < len(view.lesson.steps) else tr("Next lesson")
