"""The master's joints as sliders: another way to lead it than by its hand."""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import viser

from app.i18n.speaking import tr
from app.session.actions import Action, MoveJoint
from app.session.frame import Frame
from app.session.session import Session
from scenes.targets import JointTarget

PERIOD: Final = 0.5
"""Wall time between two looks at where the arm is [s]."""


class JointSliders:
    """One slider a joint of the guided arm, in degrees; in view where a slave follows its joints.

    They follow the arm while none is moved; moving one holds the arm at the angles of all of them.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, post: Callable[[Action], None]) -> None:
        self._gui, self._session, self._post = gui, session, post
        self._sliders: list[viser.GuiSliderHandle[float]] = []
        self._of: object = None
        self._next = 0.0
        self._container = gui.add_folder(tr("your arm's joints [°]"), expand_by_default=False, visible=False)

    def _make(self) -> None:
        """Have as many sliders as the guided arm has joints, with its limits."""
        for slider in self._sliders:
            slider.remove()
        simulation = self._session.simulation
        arm, model = simulation.guided, simulation.room.model
        low, high = np.degrees(model.lowerPositionLimit[arm.joints]), np.degrees(model.upperPositionLimit[arm.joints])
        present = np.degrees(simulation.positions[arm.joints])
        self._sliders = []
        for i, (label, a, b, q) in enumerate(zip(arm.labels, low.tolist(), high.tolist(), present.tolist(), strict=True)):
            with self._container:
                hint = tr("joint {number}", number=i + 1)
                slider = self._gui.add_slider(tr(label), math.floor(a), math.ceil(b), 0.5, round(2.0 * q) / 2.0, hint=hint)
            self._sliders.append(slider)
            self._listen(i, slider)

    def _listen(self, joint: int, slider: viser.GuiSliderHandle[float]) -> None:
        @slider.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # What the server writes comes back here too, without a client.
            if event.client_id is None:
                return
            value = float(event.target.value)
            if math.isfinite(value):
                self._post(MoveJoint(joint, math.radians(value)))

    def show(self, frame: Frame) -> None:
        """Follow the experiment and the arm."""
        simulation = self._session.simulation
        shown = simulation.settings.scene == "master_slave"
        self._container.visible = shown
        if not shown or frame.now < self._next:
            return
        self._next = frame.now + PERIOD
        of = simulation.room, simulation.guided.name
        if of != self._of:
            self._of = of
            self._make()
        if isinstance(self._session.held, JointTarget):
            return
        for slider, angle in zip(self._sliders, np.degrees(simulation.positions[simulation.guided.joints]).tolist(), strict=True):
            if abs(slider.value - angle) > 0.5:
                slider.value = float(round(2.0 * angle) / 2.0)
