"""Sliders that move the master's joints."""

import math
from functools import partial
from typing import Final

import numpy as np
import viser

from app.i18n.speaking import tr
from app.session.actions import MoveJoint
from app.session.frame import Frame
from app.session.session import Session
from app.web.control_events import on_entry
from scenes.simulation import Simulation
from scenes.targets import JointTarget

PERIOD: Final = 0.5
"""Time between two updates from the arm [s]."""


class JointSliders:
    """One slider [°] per joint of the guided arm, if a slave follows it; moving one holds all angles."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._gui, self._session = gui, session
        self._sliders: list[viser.GuiSliderHandle[float]] = []
        self._of: object = None
        self._next = 0.0
        self._container = gui.add_folder(tr("your arm's joints [°]"), expand_by_default=False, visible=False)

    def _make(self, simulation: Simulation) -> None:
        for slider in self._sliders:
            slider.remove()
        arm, model = simulation.guided, simulation.room.model
        low, high = (
            np.degrees(model.lowerPositionLimit[arm.joints]),
            np.degrees(model.upperPositionLimit[arm.joints]),
        )
        present = np.degrees(simulation.positions[arm.joints])
        self._sliders = []
        for i, (label, a, b, q) in enumerate(
            zip(arm.labels, low.tolist(), high.tolist(), present.tolist(), strict=True)
        ):
            with self._container:
                hint = tr("joint {number}", number=i + 1)
                slider = self._gui.add_slider(
                    tr(label), math.floor(a), math.ceil(b), 0.5, round(2.0 * q) / 2.0, hint=hint
                )
            self._sliders.append(on_entry(slider, partial(self._move, i)))

    def _move(self, joint: int, degrees: float) -> None:
        self._session.post(MoveJoint(joint, math.radians(degrees)))

    def show(self, frame: Frame) -> None:
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
        for slider, angle in zip(
            self._sliders, np.degrees(simulation.positions[simulation.guided.joints]).tolist(), strict=True
        ):
            if abs(slider.value - angle) > 0.5:
                slider.value = float(round(2.0 * angle) / 2.0)
