"""A slider for a moment of a run, which both the visitor and the run move: neither undoes what the other one has just done."""

import math
from collections.abc import Callable
from typing import Final

import viser

from app.i18n.speaking import tr
from app.session.actions import Action
from app.session.session import Session
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of

HANDS_OFF: Final = 0.4
"""Time without a write after the visitor has moved it [s]."""


class Seek(Action, newest_by=("slider",)):
    """Go to a moment of the run [s]. `slider`: its name."""

    slider: str
    time: float


class Scrubber:
    """The slider; hidden at first.

    Args:
        seek: takes the moment that the visitor has chosen [s], on the session's thread.
        name: of the slider among the session's actions.
        step: of the slider [s].
        period: time between two writes while the moment goes on [s].
        order: its place in the open container, None for the end.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        seek: Callable[[float], None],
        name: str,
        step: float,
        period: float,
        order: float | None = None,
    ) -> None:
        self._seek, self._name, self._step, self._period = seek, name, step, period
        self._clock = self._next = 0.0
        hint = tr("Any moment of what is kept, on the clock of the run.")
        self._slider = gui.add_slider(tr("moment [s]"), 0.0, 1.0, step, 0.0, visible=False, hint=hint, order=order)
        on_entry(self._slider, lambda time: session.post(Seek(name, time)))

    @property
    def id(self) -> str:
        """By which the page knows the slider."""
        return uuid_of(self._slider)

    def rest(self) -> None:
        """Write the moment at once."""
        self._next = self._clock

    def take(self, action: Action) -> bool:
        """Do an action if it is about this slider; return whether it was."""
        if not (isinstance(action, Seek) and action.slider == self._name):
            return False
        self._next = self._clock + HANDS_OFF
        self._seek(action.time)
        return True

    def show(self, now: float, span: tuple[float, float, float] | None) -> None:
        """Bring it up to date.

        Args:
            now: wall time [s].
            span: where the slider begins and ends, and the moment [s]; None while there is none to choose.
        """
        self._clock, slider = now, self._slider
        slider.visible = span is not None
        if span is not None and now >= self._next:
            self._next = now + self._period
            digits = -math.floor(math.log10(self._step))
            begin, end, time = (round(each, digits) for each in span)
            # A slider of no length has no place for its knob.
            end = max(end, begin + self._step)
            slider.min, slider.max = begin, end
            if abs(slider.value - time) > 0.4 * self._step:
                slider.value = min(max(time, begin), end)
