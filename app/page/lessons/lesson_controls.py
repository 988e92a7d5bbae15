"""The buttons and keys of the lessons: what is operated, by one."""

from collections.abc import Callable
from typing import Any, Final

import viser

from app.i18n.speaking import N_, tr
from app.lessons.phases import Phase
from app.lessons.session.lesson_actions import (
    Check,
    Choose,
    GoBack,
    GoOn,
    GoTo,
    Leave,
    LessonAction,
    ResetStep,
    RunAgain,
    ShowHint,
    ShowWhy,
    StartOrPause,
)
from app.lessons.session.lesson_session import LessonSession
from app.lessons.step_view import StepView
from app.page.lessons.forecast_boxes import Forecasts
from app.page.lessons.lesson_html import NEXT, choice_label
from app.page.lessons.lesson_panel import ORDER, LessonPanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.hotkeys import LESSON_KEYS, Hotkey
from app.session.actions import Action, ChooseScene, Nudge, Pause, Reset, SingleStep, Toggle
from app.session.frame import Frame
from app.session.session import Session
from app.text.lesson_text import plain

MOST_STEPS: Final = 12
MOST_CHOICES: Final = 6

_ANSWERS: Final = ("solo", "ball", "hold", "master_slave", "imitation")


class LessonControls:
    """What is operated: answers, Run, next and back, on the panel of everybody.

    Args:
        client: of the operator.
        session: in which the lessons run.
        run: the lessons.
        panel: where the buttons stand.
        notify: shows a message to the visitor.
        opened: called when the visitor opens or closes the lessons.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        run: LessonSession,
        panel: LessonPanel,
        notify: Callable[[str, str], None],
    ) -> None:
        self._client, self._session, self._run, self._panel, self._notify = client, session, run, panel, notify
        self._handles: dict[str, Any] = {}
        self._set: dict[tuple[str, str], object] = {}
        self._choices: list[viser.GuiButtonHandle] = []
        self._commands: list[viser.CommandHandle] = []
        self._shown: tuple[object, ...] = ()
        self._said_for: tuple[str, str] | None = None
        self._door = client.gui.add_button(
            tr("Lessons"),
            icon=viser.Icon.SCHOOL,
            hint=tr("Ten lessons: predict, run, compare, explain."),
            color="gray",
            order=-4.0,
        )

        @self._door.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            del event
            session.post(run.enter, "lessons")

    # ---- keys --------------------------------------------------------------------------------------------------------------

    def take(self, action: Action) -> bool:
        """Do what a key means while a lesson is open; return whether it has a meaning of its own there."""
        run = self._run
        if not run.open:
            return False
        match action:
            case ChooseScene(scene):
                run.act(Choose(_ANSWERS.index(scene)))
            case Pause():
                run.act(StartOrPause())
            case Reset():
                run.act(RunAgain())
            case SingleStep() if run.walk.locked:
                run.act(StartOrPause())
            case Nudge(right) if run.hands_off:
                if right:
                    run.act(GoBack() if right < 0 else GoOn())
            case Toggle("autopilot") if run.hands_off:
                pass
            case _:
                return False
        return True

    def _command(self, hotkey: Hotkey[LessonAction]) -> viser.CommandHandle:
        command = self._client.gui.add_command(hotkey.title, hotkey=hotkey.key, modifier=hotkey.modifier, icon=hotkey.icon)

        @command.on_trigger
        async def _(event: viser.CommandEvent) -> None:
            del event
            self._post(hotkey.action)

        return command

    # ---- buttons -----------------------------------------------------------------------------------------------------------

    def _make(self) -> None:
        assert self._panel.tab is not None
        gui, run, lessons = self._client.gui, self._run, self._run.book.lessons
        self._names = tuple(f"{lesson.number}  {plain(lesson.title)}" for lesson in lessons)
        with self._panel.tab:
            picker = self._handles["picker"] = gui.add_dropdown(
                tr("lesson"), self._names, initial_value=self._names[0], hint=tr("Any lesson at any time."), order=1.0
            )
            self._steps = ChoiceButtons(
                gui, "step", tuple(str(i + 1) for i in range(MOST_STEPS)), "Any step at any time.", self._go_step, order=2.0
            )
            for i in range(MOST_CHOICES):
                self._choices.append(self._button(f"choice {i}", Choose(i), order=ORDER["choices"] + 1.0 + i))
            self._button("run", StartOrPause(), order=ORDER["choices"] + 8.0)
            self._button("why", ShowWhy(), order=ORDER["verdict"] + 1.0)
            self._forecasts = Forecasts(gui, self._session, run)
            self._button("check", Check(), order=ORDER["after"] + 6.0)
            self._button("hint", ShowHint(), order=ORDER["hints"] + 1.0)
            self._nav = ChoiceButtons(
                gui,
                "",
                ("Back", "Reset step"),
                "B goes back, N goes on. Reset begins the step anew.",
                lambda i: self._post((GoBack(), ResetStep())[i]),
                order=ORDER["hints"] + 6.0,
            )
            self._button("next", GoOn(), order=ORDER["hints"] + 5.0)
            self._button("leave", Leave(), order=ORDER["hints"] + 7.0)

        @picker.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is None:
                return
            value = event.target.value
            if value in self._names:
                index = self._names.index(value)
                self._post(GoTo(index, 0))

    def _go_step(self, index: int) -> None:
        run = self._run
        self._session.post(lambda: run.act(GoTo(run.book.lessons.index(run.walk.lesson), index)), ("lesson", GoTo))

    def _post(self, action: LessonAction) -> None:
        self._session.post(lambda: self._run.act(action), ("lesson", type(action)))

    def _button(self, name: str, action: LessonAction, order: float) -> viser.GuiButtonHandle:
        button = self._client.gui.add_button(name, visible=False, order=order)
        self._handles[name] = button
        self._set[name, "visible"] = False

        @button.on_click
        async def _(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            del event
            self._post(action)

        return button

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def show(self, frame: Frame) -> None:
        """Bring buttons up to date, and pass on the lesson's notices."""
        del frame
        run = self._run
        while run.notes:
            self._notify(*run.notes.popleft())
        # An open lesson has its own button to leave it, which stays while a narrow window folds the controls up.
        self._door.visible = bool(run.book.lessons) and not run.open
        if not run.open:
            for command in self._commands:
                command.remove()
            self._commands.clear()
            self._shown = ()
            return
        if not self._commands:
            self._commands = [self._command(hotkey) for hotkey in LESSON_KEYS]
        if not self._handles:
            self._make()
        simulation = self._session.simulation
        walk = run.walk
        over = walk.finished(simulation) and not walk.yours
        state = run.version, self._session.paused, over
        if state == self._shown:
            return
        self._shown = state
        self._arrange(run.view(), over)

    def _arrange(self, view: StepView, over: bool) -> None:
        lessons = self._run.book.lessons
        self._write("picker", "value", self._names[lessons.index(view.lesson)])
        self._steps.offer(tuple(range(min(view.count, MOST_STEPS))))
        self._steps.mark(view.index)
        asking = view.phase in (Phase.PREDICT, Phase.DO)
        for i, button in enumerate(self._choices):
            offered = asking and i < len(view.choices)
            if offered:
                self._write(f"choice {i}", "label", choice_label(i + 1, view.choices[i], i == view.chosen))
                self._write(f"choice {i}", "color", "orange" if i == view.chosen else "gray")
            self._write(f"choice {i}", "visible", offered)
            del button
        runs = asking or view.showing or view.phase is Phase.CHALLENGE
        paused = self._session.paused
        label = N_("Pause") if not paused else N_("Run again") if over else N_("lesson\x04Run")
        label = N_("Run (predict first)") if view.locked else label
        self._write("run", "label", tr(label))
        self._write("run", "disabled", view.locked)
        self._write("run", "visible", runs)
        self._write("why", "label", tr("Show me why"))
        self._write("why", "color", "blue")
        self._write("why", "visible", view.why and not view.showing)
        self._arrange_challenge(view)
        self._write("hint", "label", tr("Hint {number} of {count}", number=len(view.hints) + 1, count=len(view.step.hints)))
        self._write("hint", "color", "gray")
        self._write("hint", "visible", view.phase is Phase.CHALLENGE and view.more_hints)
        self._nav.offer((0, 1) if view.can_back else (1,))
        self._write("next", "label", next_label(view))
        self._write("next", "color", None if view.phase is not Phase.DO or over else "gray")
        self._write("next", "visible", view.can_next)
        self._write("leave", "label", tr("Leave the lessons"))
        self._write("leave", "color", "gray")
        self._write("leave", "visible", True)

    def _arrange_challenge(self, view: StepView) -> None:
        challenge = view.step.challenge if view.phase is Phase.CHALLENGE else None
        self._forecasts.show(view, challenge)
        tests = self._run.own_tests
        label = tr("Check my run") if challenge is None or not challenge.forecasts else tr("Check my numbers")
        if tests is not None:
            label = tr("Testing …") if tests.running else tr("Test my law")
        self._write("check", "label", label)
        self._write("check", "disabled", tests is not None and tests.running)
        self._write("check", "visible", challenge is not None and (tests is None or tests.file is not None))

    def _write(self, name: str, prop: str, value: object) -> None:
        if self._set.get((name, prop), _UNSET) != value:
            self._set[name, prop] = value
            setattr(self._handles[name], prop, value)


_UNSET: Final = object()


def next_label(view: StepView) -> str:
    """Return what stands on the button that goes on."""
    if view.showing:
        return tr("Back to the outcome")
    place = view.phases.index(view.phase)
    if place + 1 < len(view.phases):
        if view.phase is Phase.DO and not view.yours:
            return tr("Skip the run")
        return tr(NEXT[view.phases[place + 1].value])
    return tr("Next step") if view.index + 1 < view.count else tr("Next lesson")
