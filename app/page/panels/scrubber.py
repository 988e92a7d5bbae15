"""A slider for a moment of a run, which both the visitor and the run move: neither undoes what the other one has just done."""

import math
from collections.abc import Callable
from typing import Final

import viser

from app.i18n.speaking import tr
from app.session.session import Session
from app.web.viser_internals import uuid_of

HANDS_OFF: Final = 0.4
"""Time without a write after the visitor has moved it [s]."""

CROSSING: Final = 0.3
"""What was written this long ago may meet on its way what the visitor does [s]."""


class Scrubber:
    """The slider; hidden at first.

    Args:
        seek: takes the moment that the visitor has chosen [s], on the session's thread.
        control: the name of the control among the session's actions.
        step: of the slider [s].
        period: time between two writes while the moment goes on [s].
        order: its place in the open container, None for the end.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        seek: Callable[[float], None],
        control: str,
        step: float,
        period: float,
        order: float | None = None,
    ) -> None:
        self._seek, self._step, self._period = seek, step, period
        self._clock = self._next = 0.0
        self._written, self._crossed = -CROSSING, False
        hint = tr("Any moment of what is kept, on the clock of the run.")
        self._slider = gui.add_slider(tr("moment [s]"), 0.0, 1.0, step, 0.0, visible=False, hint=hint, order=order)

        @self._slider.on_update
        async def _(event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
            # What the server writes comes back here too, without a client.
            if event.client_id is not None:
                time = event.target.value
                session.post(lambda: self._drag(time), control)

    @property
    def id(self) -> str:
        """By which the page knows the slider."""
        return uuid_of(self._slider)

    def rest(self) -> None:
        """Write the moment at once."""
        self._next = self._clock

    def _drag(self, time: float) -> None:
        self._next = self._clock + HANDS_OFF
        self._crossed = self._clock - self._written < CROSSING
        self._seek(time)

    def show(self, now: float, span: tuple[float, float, float] | None) -> None:
        """Bring it up to date.

        Args:
            now: wall time [s].
            span: where the slider begins and ends, and the moment [s]; None while there is none to choose.
        """
        self._clock = now
        self._slider.visible = span is not None
        if span is not None and now >= self._next:
            self._next = now + self._period
            digits = -math.floor(math.log10(self._step))
            begin, end, time = (round(each, digits) for each in span)
            self._write(begin, end, time)

    def _write(self, begin: float, end: float, time: float) -> None:
        slider = self._slider
        # A slider of no length has no place for its knob.
        end = max(end, begin + self._step)
        slider.min, slider.max = begin, end
        if self._crossed or abs(slider.value - time) > 0.4 * self._step:
            value = min(max(time, begin), end)
            # What crossed the visitor's value on its way stands in their browser now; viser sends nothing that is no change.
            slider.value = math.nextafter(value, math.inf) if value == slider.value else value
            self._written, self._crossed = self._clock, False
