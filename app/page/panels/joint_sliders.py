"""Sliders that lead an arm in another way than by its hand: by the master's joints, and, where a challenge offers them, by the motions that
are left while the hand stays where it is."""

import math
from functools import partial
from typing import Final

import numpy as np
import viser

from app.i18n.speaking import N_, tr
from app.lessons.session.lesson_session import LessonSession
from app.page.lessons.lesson_panel import ORDER
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action, MoveJoint
from app.session.frame import Frame
from app.session.session import Session
from app.web.control_events import on_entry
from scenes.simulation import Simulation
from scenes.solo import MOTIONS, NullMotions
from scenes.targets import JointTarget

PERIOD: Final = 0.5
"""Wall time between two looks at where the arm is [s]."""


class JointSliders:
    """One slider a joint of the guided arm, in degrees; in view where a slave follows its joints.

    They follow the arm while none is moved; moving one holds the arm at the angles of all of them.
    """

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._gui, self._session = gui, session
        self._sliders: list[viser.GuiSliderHandle[float]] = []
        self._of: object = None
        self._next = 0.0
        self._container = gui.add_folder(tr("your arm's joints [°]"), expand_by_default=False, visible=False)

    def _make(self, simulation: Simulation) -> None:
        """Make as many sliders as the guided arm has joints, with its limits."""
        for slider in self._sliders:
            slider.remove()
        arm, model = simulation.guided, simulation.room.model
        low, high = np.degrees(model.lowerPositionLimit[arm.joints]), np.degrees(model.upperPositionLimit[arm.joints])
        present = np.degrees(simulation.positions[arm.joints])
        self._sliders = []
        for i, (label, a, b, q) in enumerate(zip(arm.labels, low.tolist(), high.tolist(), present.tolist(), strict=True)):
            with self._container:
                hint = tr("joint {number}", number=i + 1)
                slider = self._gui.add_slider(tr(label), math.floor(a), math.ceil(b), 0.5, round(2.0 * q) / 2.0, hint=hint)
            self._sliders.append(on_entry(slider, partial(self._move, i)))

    def _move(self, joint: int, degrees: float) -> None:
        self._session.post(MoveJoint(joint, math.radians(degrees)))

    def show(self, frame: Frame) -> None:
        """Follow the experiment and the arm."""
        simulation = frame.live.simulation
        shown = simulation.settings.experiment.follows == "arm"
        self._container.visible = shown
        if not shown or frame.now < self._next:
            return
        self._next = frame.after(PERIOD)
        of = simulation.room, simulation.guided.name
        if of != self._of:
            self._of = of
            self._make(simulation)
        if isinstance(frame.live.held, JointTarget):
            return
        for slider, angle in zip(self._sliders, np.degrees(simulation.positions[simulation.guided.joints]).tolist(), strict=True):
            if abs(slider.value - angle) > 0.5:
                slider.value = float(round(2.0 * angle) / 2.0)


FARTHEST: Final = 60.0
"""Either end of a slider for a null-space motion [°]."""

LABELS: Final = (N_("swing the elbow"), N_("turn the hand, x"), N_("turn the hand, y"), N_("turn the hand, z"))


class MoveInNullSpace(Action, newest_by=("motion",)):
    """Lead the arm along a motion, from 0, to a way from where the first one began [rad]."""

    motion: int
    way: float


class NullMotionSliders:
    """The sliders. The caller has opened their container.

    Args:
        run: the lessons; a fresh run begins with all sliders at 0.
        handlers: of the page.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, run: LessonSession, handlers: ActionHandlers) -> None:
        self._session, self._run = session, run
        self._motions: NullMotions | None = None
        self._of: object = None
        self._sliders = [self._make(gui, i) for i in range(MOTIONS)]
        handlers.add(MoveInNullSpace, self._move)

    def _make(self, gui: viser.GuiApi, motion: int) -> viser.GuiSliderHandle[float]:
        hint = tr("Motion {number} of 4 in the null space: the hand stays where it is.", number=motion + 1)
        place = ORDER["after"] + 2.0 + motion
        slider = gui.add_slider(tr(LABELS[motion]), -FARTHEST, FARTHEST, 1.0, 0.0, visible=False, hint=hint, order=place)

        def take(value: float) -> None:
            if math.isfinite(value):
                self._session.post(MoveInNullSpace(motion, math.radians(min(max(value, -FARTHEST), FARTHEST))))

        return on_entry(slider, take)

    def _move(self, action: MoveInNullSpace) -> None:
        """Lead the arm along a motion, where the sliders are offered."""
        session = self._session
        if not self._offered:
            return
        if self._motions is None:
            simulation = session.simulation
            self._motions = NullMotions(simulation.room, simulation.avoiding, simulation.positions)
        session.hold(JointTarget(self._motions.go(action.motion, action.way)))

    @property
    def _offered(self) -> bool:
        walk = self._run.walk
        shown = self._run.open and not self._run.listing
        return shown and walk.step.challenge is not None and walk.step.challenge.null_motions and walk.yours

    def show(self, frame: Frame) -> None:
        """Offer the sliders where they belong; they go back to 0 in a fresh run, and when the arm is taken by something else."""
        offered, of = self._offered, (self._run.walk.run_id, frame.live.simulation)
        if of != self._of or not (offered and isinstance(frame.live.held, JointTarget)):
            self._of, self._motions = of, None
            for slider in self._sliders:
                slider.value = 0.0
        for slider in self._sliders:
            slider.visible = offered
