"""Sliders for null-space motions."""

import math
from typing import Final

import viser

from app.features.lessons.panel.lesson_panel import ORDER
from app.features.lessons.session.lesson_session import LessonSession
from app.i18n.speaking import N_, tr
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action
from app.session.frame import Frame
from app.session.session import Session
from app.web.control_events import on_entry
from scenes.solo import MOTIONS, NullMotions
from scenes.targets import JointTarget

FARTHEST: Final = 60.0
"""Ends of a slider [°]."""

LABELS: Final = (
    N_("swing the elbow"),
    N_("turn the hand, x"),
    N_("turn the hand, y"),
    N_("turn the hand, z"),
)


class MoveInNullSpace(Action, newest_by=("motion",)):
    """Move along a null-space motion (0-based) to `way` from the start [rad]."""

    motion: int
    way: float


class NullMotionSliders:
    """The sliders, in the caller's open container."""

    def __init__(
        self, gui: viser.GuiApi, session: Session, run: LessonSession, handlers: ActionHandlers
    ) -> None:
        self._session, self._run = session, run
        self._motions: NullMotions | None = None
        self._of: object = None
        self._sliders = [self._make(gui, i) for i in range(MOTIONS)]
        handlers.add(MoveInNullSpace, self._move)

    def _make(self, gui: viser.GuiApi, motion: int) -> viser.GuiSliderHandle[float]:
        hint = tr("Motion {number} of 4 in the null space: the hand stays where it is.", number=motion + 1)
        place = ORDER["after"] + 2.0 + motion
        slider = gui.add_slider(
            tr(LABELS[motion]), -FARTHEST, FARTHEST, 1.0, 0.0, visible=False, hint=hint, order=place
        )

        def take(value: float) -> None:
            if math.isfinite(value):
                self._session.post(
                    MoveInNullSpace(motion, math.radians(min(max(value, -FARTHEST), FARTHEST)))
                )

        return on_entry(slider, take)

    def _move(self, action: MoveInNullSpace) -> None:
        session = self._session
        if not self._offered:
            return
        if self._motions is None:
            simulation = session.simulation
            self._motions = NullMotions(simulation.room, simulation.avoiding, simulation.positions)
        session.hand.hold(JointTarget(self._motions.go(action.motion, action.way)))

    @property
    def _offered(self) -> bool:
        walk = self._run.walk
        shown = self._run.open and not self._run.listing
        return shown and walk.step.challenge is not None and walk.step.challenge.null_motions and walk.yours

    def show(self, frame: Frame) -> None:
        """A new run, or another mover of the arm, resets the sliders."""
        offered, of = self._offered, (self._run.walk.run_id, frame.live.simulation)
        if of != self._of or not (offered and isinstance(frame.live.held, JointTarget)):
            self._of, self._motions = of, None
            for slider in self._sliders:
                slider.value = 0.0
        for slider in self._sliders:
            slider.visible = offered
