"""Control of a drawn or typed λ(d)."""

from typing import Final

import viser

from app.i18n.speaking import N_, tr
from app.page.panels.drawing_board import DrawingBoard, Place
from app.plots.curve_chart import Curve
from app.plots.drawing_axes import Drawing, activation_axes, law_curve
from app.session.actions import SetSetting
from app.session.session import Session
from app.settings import Settings
from app.text.templates import element
from app.web.control_events import on_entry
from controllers.curve import curve_through, read_curve
from controllers.errors import BadSetting

_FARTHEST: Final = 0.4
"""Right end of the board [unit of the first task]."""


class CurveControl:
    """Board above a text box; an invalid text changes nothing."""

    def __init__(
        self, gui: viser.GuiApi, session: Session, key: str, label: str, hint: str, value: str
    ) -> None:
        self._key, self._session, self._trouble, self.known = key, session, "", ""
        self._board = DrawingBoard(gui, session.post, self.draw)
        self._drawing: Drawing | None = None
        self.drawn: Curve = ()
        self.box = on_entry(gui.add_text(label, value, hint=hint), self.take)
        self.note = gui.add_html("", visible=False)

    def take(self, text: str) -> None:
        try:
            curve, self._trouble = read_curve(text), ""
        except BadSetting as error:
            self._trouble = str(error)
        else:
            self._session.post(SetSetting(self._key, curve))

    def draw(self, place: Place, drawn: Curve) -> None:
        del place
        if self._drawing is not None:
            self.drawn = drawn
        if self._drawing is not None and drawn:
            self.known, self._trouble = law_curve(self._drawing, drawn), ""
            self._session.post(SetSetting(self._key, self.known))

    def show(self, settings: Settings, visible: bool) -> None:
        law = settings.run.law
        self.box.visible = visible
        self._drawing = None
        if visible:
            self._drawing = activation_axes(law.critical_distance, (0.0, _FARTHEST), settings.run.quantity)
        if visible and law.curve != self.known:
            self.known, self._trouble, curve = law.curve, "", curve_through(law.curve)
            assert self._drawing is not None
            self.drawn = tuple(curve.height(d) for d in self._drawing.columns)
        self._board.show(("law", "curve"), self._drawing, self.drawn)
        if visible and not self._trouble and _one_form(self.box.value) != law.curve:
            self.box.value = law.curve
        words = self._trouble or (
            "" if self.drawn else N_("The last curve is used until you draw another one.")
        )
        self.note.visible = visible and bool(words)
        self.note.content = element(
            "div", tr(words), class_="duet duet-tip", role="alert" if self._trouble else "status"
        )


def _one_form(text: str) -> str:
    try:
        return read_curve(text)
    except BadSetting:
        return ""
