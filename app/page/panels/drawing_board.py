"""Axes to draw on, with `drawing.js`."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import field

import viser
from markupsafe import Markup

from app.i18n.speaking import tr
from app.plots.curve_chart import Curve, CurveAxis
from app.plots.drawing_axes import AXES, Drawing, axes_text, board_svg, curve_from_text
from app.session.actions import Action
from app.text.templates import macros
from app.web.control_events import on_entry

Place = tuple[str, str]
"""Two names that identify a curve."""


def board_html(place: Place, drawing: Drawing, drawn: Curve, sent: int = 0) -> Markup:
    """`sent`: number of earlier boards; a new board replaces what is drawn meanwhile."""
    heights = [None if v is None else round(drawing.y.fraction(v), 3) for v in drawn]
    return macros("page/panels/drawing_board.html").board(
        svg=board_svg(drawing, drawn),
        sent=sent,
        what=axes_text(drawing),
        at="/".join(place),
        curve=json.dumps(heights),
        x=_axis_data(drawing.x, AXES[drawing.x_name].digits + 1),
        y=_axis_data(drawing.y, AXES[drawing.y_name].digits),
    )


def _axis_data(axis: CurveAxis, digits: int) -> str:
    return json.dumps([axis.symbol, axis.low * axis.factor, axis.high * axis.factor, axis.unit, digits])


class TakeDrawing(Action, newest_by=("board",)):
    """`text`: as the script sends it."""

    board: DrawingBoard = field(repr=False)
    text: str


class DrawingBoard:
    """Board in the open container of a page.

    Args:
        post: queues an action; called on the network's thread.
        order: of the board and of its hidden box; None for the end.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        post: Callable[[Action], None],
        draw: Callable[[Place, Curve], None],
        order: tuple[float, float] | tuple[None, None] = (None, None),
    ) -> None:
        self._draw = draw
        self._shown: tuple[Place, Drawing] | None = None
        self._known: Curve = ()
        self._sent = 0
        self._board = gui.add_html("", order=order[0], visible=False)
        self._box = gui.add_text(tr("drawing"), "", order=order[1], visible=False)
        on_entry(self._box, lambda text: post(TakeDrawing(self, text)))

    def take(self, text: str) -> None:
        """Ignores a curve that was drawn for another place."""
        at, _, heights = text.partition(" ")
        if self._shown is None or at != "/".join(self._shown[0]):
            # The last drawing may arrive when the student is already elsewhere.
            return
        place, drawing = self._shown
        curve = curve_from_text(drawing, heights)
        if curve is not None:
            self._known = curve
            self._draw(place, curve)

    def show(self, place: Place, drawing: Drawing | None, drawn: Curve) -> None:
        """Update the board; hide it if `drawing` is None."""
        shown = None if drawing is None else (place, drawing)
        # A board that is being drawn on is left alone: it already shows what came from it.
        if drawing is not None and (shown != self._shown or drawn != self._known):
            self._known = drawn
            self._sent += 1
            self._board.content = board_html(place, drawing, drawn, self._sent)
        self._shown = shown
        self._board.visible = self._box.visible = drawing is not None
