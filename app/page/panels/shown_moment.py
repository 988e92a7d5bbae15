"""The moment of a run that stands or is replayed: its line in the plots over time, and its name."""

import json
from typing import Final

from markupsafe import Markup

from app.i18n.speaking import decimal, tr
from app.plots.bins import BIN
from app.session.frame import Frame
from app.text.templates import element

NEAR: Final = 0.02
"""A moment is called by the name of one that is so near [s]."""


def moment_html(frame: Frame, span: tuple[float, float] | None) -> Markup:
    """Return where the moment that is shown, and the one worth a look, are on the axes of the plots over time, and what they are called.

    Args:
        span: ends of these axes [s]; None while there are none.
    """
    if span is None or not (frame.pace.paused or frame.replayed):
        return Markup()
    shown, (begin, end) = frame.shown, span
    # By this the script knows which time is where.
    made = element("i", hidden="", data_duet_span=f"{begin:.3f} {end:.3f}")
    if shown.replay_time is None:
        return made
    at = shown.replay_time

    def place(time: float) -> str:
        return f"{100.0 * min(max((time - begin) / (end - begin), 0.0), 1.0):.2f}%"

    words = f"{decimal(f'{at:.2f}')} s"
    # The plots may end a bin before the newest moment; one that is farther outside has no line there.
    inside = begin - BIN <= at <= end + BIN
    rules = [f"--duet-moment:{place(at)}", "--duet-moment-line:''"] if inside else []
    if (mark := shown.mark) is not None and begin <= mark.time <= end:
        when = f"{decimal(f'{mark.time:.1f}')} s"
        name = f"{tr(mark.name)}, {when}"
        words = name if abs(at - mark.time) < NEAR else words
        # The name stands on the side with more room.
        late, left = mark.time > 0.5 * (begin + end), place(mark.time)
        rules += [
            f"--duet-mark:{left}",
            f"--duet-mark-name:{css_text(name)}",
            f"--duet-mark-time:{css_text(when)}",
            f"--duet-mark-room:{left if late else f'calc(100% - {left})'}",
            f"--duet-mark-align:{'end' if late else 'start'}",
            f"--duet-mark-shift:{'-100%' if late else '0%'}",
            f"--duet-mark-side:{'0 1.5px 0 0' if late else '0 0 0 1.5px'}",
        ]
    rules.append(f"--duet-moment-words:{css_text(words)}")
    return made + Markup(f"<style>:root{{{';'.join(rules)}}}</style>")


def css_text(words: str) -> str:
    """Return words as a string of CSS inside a style element."""
    return json.dumps(words, ensure_ascii=False).replace("<", "\\3c ")
