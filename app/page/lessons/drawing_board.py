"""Axes to draw on, by mouse, finger or keys: for a prediction, and for a λ(d) of one's own. The script `drawing.js` does the drawing."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import field
from typing import Final

import viser
from markupsafe import Markup

from app.i18n.speaking import N_, tr
from app.lessons.curve_drawing import AXES, Drawing, activation_axes, axes_text, board_svg, curve_from_text, law_curve
from app.page.lessons.lesson_panel import ORDER
from app.plots.curve_chart import Curve, CurveAxis
from app.session.actions import Action, SetSetting
from app.session.session import Session
from app.settings import Settings
from app.text.templates import element, macros
from app.web.control_events import on_entry
from controllers.curve import curve_through, read_curve
from controllers.errors import BadSetting
from scenes.setting_spec import Spec

IN_LESSONS: Final = (ORDER["drawing"] + 0.1, ORDER["drawing"] + 0.2)
"""Where a step's board stands in its panel."""

Place = tuple[str, str]
"""Names of a lesson and a step."""


def board_html(place: Place, drawing: Drawing, drawn: Curve, sent: int = 0) -> Markup:
    """Return the board, with what was drawn before. `sent`: times before; what is drawn on the page meanwhile gives way to a new board."""
    heights = [None if v is None else round(drawing.y.fraction(v), 3) for v in drawn]
    return macros("page/lessons/drawing_board.html").board(
        svg=board_svg(drawing, drawn),
        sent=sent,
        what=axes_text(drawing),
        at="/".join(place),
        curve=json.dumps(heights),
        x=_axis_data(drawing.x, AXES[drawing.x_name].digits + 1),
        y=_axis_data(drawing.y, AXES[drawing.y_name].digits),
    )


def _axis_data(axis: CurveAxis, digits: int) -> str:
    """Return what the script needs to say a value: symbol, ends and unit as they are shown, digits."""
    return json.dumps([axis.symbol, axis.low * axis.factor, axis.high * axis.factor, axis.unit, digits])


class TakeDrawing(Action, newest_by=("board",)):
    """Take what is drawn on a board. `text`: as the script sends it."""

    board: DrawingBoard = field(repr=False)
    text: str


class DrawingBoard:
    """The board on one student's page. The caller has opened its container.

    Args:
        post: has an action done on the thread to which all but the callback belongs.
        draw: takes the names of lesson and step, and the curve.
        order: of the board among what stands in its container, and of the hidden box right behind it; None for the end.
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
        """Hand over the curve that the script has sent, unless it belongs to another step."""
        at, _, heights = text.partition(" ")
        if self._shown is None or at != "/".join(self._shown[0]):
            # What is drawn last may arrive when the student is already in the next step.
            return
        place, drawing = self._shown
        curve = curve_from_text(drawing, heights)
        if curve is not None:
            self._known = curve
            self._draw(place, curve)

    def show(self, place: Place, drawing: Drawing | None, drawn: Curve) -> None:
        """Offer the board of a step, with what was drawn there; None for no board."""
        shown = None if drawing is None else (place, drawing)
        # A board that is being drawn on is left alone: it shows already what came from it.
        if drawing is not None and (shown != self._shown or drawn != self._known):
            self._known = drawn
            self._sent += 1
            self._board.content = board_html(place, drawing, drawn, self._sent)
        self._shown = shown
        self._board.visible = self._box.visible = drawing is not None


_FARTHEST: Final = 0.4
"""Right end of the board [m]."""


class CurveControl:
    """A board over a box of text; a text that is no curve is said to be none below it, and changes nothing.

    Attributes:
        box: of the points.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, label: str, spec: Spec, value: str) -> None:
        self._key, self._session, self._trouble, self._known = spec.key, session, "", ""
        self._board = DrawingBoard(gui, session.post, self._draw)
        self._drawing: Drawing | None = None
        self._drawn: Curve = ()
        self.box = on_entry(gui.add_text(label, value, hint=tr(spec.help)), self._take)
        self._note = gui.add_html("", visible=False)

    def _take(self, text: str) -> None:
        try:
            curve, self._trouble = read_curve(text), ""
        except BadSetting as error:
            self._trouble = str(error)
        else:
            self._session.post(SetSetting(self._key, curve))

    def _draw(self, place: Place, drawn: Curve) -> None:
        del place
        if self._drawing is not None:
            self._drawn = drawn
        if self._drawing is not None and drawn:
            self._known, self._trouble = law_curve(self._drawing, drawn), ""
            self._session.post(SetSetting(self._key, self._known))

    def show(self, settings: Settings, visible: bool) -> None:
        """Show the curve of the settings, unless it is the one that is being drawn or typed."""
        law = settings.run.law
        self.box.visible = visible
        self._drawing = activation_axes(law.critical_distance, (0.0, _FARTHEST)) if visible else None
        if visible and law.curve != self._known:
            self._known, self._trouble, curve = law.curve, "", curve_through(law.curve)
            assert self._drawing is not None
            self._drawn = tuple(curve.height(d) for d in self._drawing.columns)
        self._board.show(("law", "curve"), self._drawing, self._drawn)
        if visible and not self._trouble and _one_form(self.box.value) != law.curve:
            self.box.value = law.curve
        words = self._trouble or ("" if self._drawn else N_("The last curve goes on until you draw another one."))
        self._note.visible = visible and bool(words)
        self._note.content = element("div", tr(words), class_="duet duet-tip", role="alert" if self._trouble else "status")


def _one_form(text: str) -> str:
    """Return a text of points as the settings have it; "" if it is none."""
    try:
        return read_curve(text)
    except BadSetting:
        return ""
