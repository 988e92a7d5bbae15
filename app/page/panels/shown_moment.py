"""The shown moment of a run."""

import json
import math
from collections.abc import Callable
from typing import Final

import viser
from markupsafe import Markup

from app.i18n.speaking import decimal, tr
from app.plots.bins import BIN
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action
from app.session.frame import Frame
from app.session.session import Session
from app.text.templates import element
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of

HANDS_OFF: Final = 0.4
"""Time without a write after the visitor moves the slider [s]."""


class Seek(Action):
    """Go to a moment of the run [s]; each slider has its own subclass."""

    time: float


class Scrubber:
    """Slider, hidden at first.

    Args:
        seek: takes the chosen moment [s], on the session's thread.
        step: of the slider [s].
        period: between two writes [s].
        order: None for the end.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        handlers: ActionHandlers,
        kind: type[Seek],
        seek: Callable[[float], None],
        step: float,
        period: float,
        order: float | None = None,
    ) -> None:
        self._seek, self._step, self._period = seek, step, period
        self._clock = self._next = 0.0
        hint = tr("Any moment of what is kept, on the clock of the run.")
        self._slider = gui.add_slider(
            tr("moment [s]"), 0.0, 1.0, step, 0.0, visible=False, hint=hint, order=order
        )
        on_entry(self._slider, lambda time: session.post(kind(time)))
        handlers.add(kind, self._go_to)

    @property
    def id(self) -> str:
        return uuid_of(self._slider)

    def rest(self) -> None:
        self._next = self._clock

    def _go_to(self, action: Seek) -> None:
        self._next = self._clock + HANDS_OFF
        self._seek(action.time)

    def show(self, now: float, span: tuple[float, float, float] | None) -> None:
        """`now`: wall time [s]; `span`: ends of the slider and the moment [s]; None hides it."""
        self._clock, slider = now, self._slider
        slider.visible = span is not None
        if span is not None and now >= self._next:
            self._next = now + self._period
            digits = -math.floor(math.log10(self._step))
            begin, end, time = (round(each, digits) for each in span)
            # A slider of zero length has no place for its knob.
            end = max(end, begin + self._step)
            slider.min, slider.max = begin, end
            if abs(slider.value - time) > 0.4 * self._step:
                slider.value = min(max(time, begin), end)


NEAR: Final = 0.02
"""Distance within which a moment has the mark's name [s]."""

WIDEST: Final = 0.7
"""Mean width of a wide font's character [font sizes]."""


def moment_html(frame: Frame, span: tuple[float, float] | None) -> Markup:
    """Marks of moments on the plots over time. `span`: ends of the time axis [s], or None."""
    if span is None or not (frame.pace.paused or frame.replayed):
        return Markup()
    shown, (begin, end) = frame.shown, span
    # The script finds the time at a place by this.
    made = element("i", hidden="", data_duet_span=f"{begin:.3f} {end:.3f}")
    if shown.replay.time is None:
        return made
    at = shown.replay.time

    def place(time: float) -> str:
        return f"{100.0 * min(max((time - begin) / (end - begin), 0.0), 1.0):.2f}%"

    words = f"{decimal(f'{at:.2f}')} s"
    # The plots may end a bin before the newest moment; a moment farther outside has no line there.
    inside = begin - BIN <= at <= end + BIN
    rules = [f"--duet-moment:{place(at)}", "--duet-moment-line:''"] if inside else []
    narrow = ""
    if (mark := shown.replay.mark) is not None and begin <= mark.time <= end:
        when = f"{decimal(f'{mark.time:.1f}')} s"
        name = f"{tr(mark.name)}, {when}"
        words = name if abs(at - mark.time) < NEAR else words
        rules += [
            f"--duet-mark:{place(mark.time)}",
            f"--duet-mark-name:{css_text(name)}",
            f"--duet-mark-time:{css_text(when)}",
        ]
        # A plot too narrow for the name shows the time alone.
        narrow = f"@container (max-width:{len(name) * WIDEST:.1f}em){{.u-over::before{{content:var(--duet-mark-time)}}}}"
    rules.append(f"--duet-moment-words:{css_text(words)}")
    return made + Markup(f"<style>:root{{{';'.join(rules)}}}{narrow}</style>")


def css_text(words: str) -> str:
    return json.dumps(words, ensure_ascii=False).replace("<", "\\3c ")
