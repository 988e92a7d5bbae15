"""The lever that sets λ, moved by `contact_lever.js` and keys."""

from typing import Final

from app.features.lever.card_lever import CardLever
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.session.actions import Nudge, SetSetting
from app.session.frame import Frame
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of
from scenes.laws import LEVER_LAW

NOTCH: Final = 0.1
"""Change by a key."""


class LeverPanel(PagePanel):
    """Hidden box for the script; ↑ and ↓ move the lever, too."""

    def __init__(self, page: PanelContext) -> None:
        client, session, view, handlers = page.client, page.session, page.view, page.handlers
        self._session = session
        box = client.gui.add_slider("", 0.0, 1.0, 0.01, 0.0, visible=False)
        self._box = on_entry(box, lambda share: session.post(SetSetting("lever", share)))
        view.part(CardLever).box = uuid_of(box)
        handlers.add_first(Nudge, self._move)

    def _move(self, nudge: Nudge) -> bool:
        """← and → do nothing while a part moves the hand."""
        law = self._session.settings.run.law
        if law.law != LEVER_LAW:
            return False
        if nudge.up and not (nudge.right or nudge.away):
            self._session.change("lever", min(max(round(law.hand_lever + nudge.up * NOTCH, 6), 0.0), 1.0))
            return True
        return self._session.parts.hands_off and not self._session.paused

    def show(self, frame: Frame) -> None:
        """Write changes into the box; entering its present value would not count."""
        self._box.value = frame.live.settings.run.law.hand_lever
