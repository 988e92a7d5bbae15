"""Invites a second person to hold the other arm: a link, a code of it, and who is there."""

import secrets

import viser
from markupsafe import Markup

from app.i18n.speaking import tr
from app.page.panels.link_box import link_to
from app.page.panels.page_panel import PagePanel
from app.session.actions import Action
from app.session.frame import NO_INVITATION, Frame
from app.session.session import Session
from app.settings import GUEST
from app.text.templates import macros, tr_html
from app.web.control_events import on_press
from app.web.request import address_known_to, qr_svg


class Invite(Action):
    """Invite a second person, or end the invitation."""

    on: bool


class InviteBox(PagePanel):
    """A folder with the invitation; there where two people can hold an arm each, and as long as one is open. Its container is open.

    Attributes:
        offered: whether there is room for it; an open invitation is shown all the same.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, order: float) -> None:
        gui, self._session = client.gui, session
        self._address = address_known_to(client)
        self._shown, self.offered = (NO_INVITATION, True), True
        self._folder = gui.add_folder(tr("Two people, one arm each"), order=order, expand_by_default=False)
        with self._folder:
            self._place = gui.add_html("")
            self._invite = gui.add_button(tr("Invite a second person"), icon=viser.Icon.USER_PLUS)
            self._end = gui.add_button(tr("End the invitation"), color="gray", visible=False)
        on_press(self._invite, lambda: session.post(Invite(True)))
        on_press(self._end, lambda: session.post(Invite(False)))

    def take(self, action: Action) -> bool:
        """Invite, or end the invitation."""
        if not isinstance(action, Invite):
            return False
        session = self._session
        session.invitation = (session.invitation or secrets.token_hex(8)) if action.on else ""
        return True

    def show(self, frame: Frame) -> None:
        """Show the link, and whether a guest has come by it."""
        invitation, for_two = frame.invitation, frame.live.settings.run.experiment.for_two
        self._folder.visible = bool(invitation.word) or (self.offered and for_two)
        if (invitation, for_two) != self._shown:
            self._shown = invitation, for_two
            self._invite.visible, self._end.visible = not invitation.word, bool(invitation.word)
            self._place.content = self._html(*invitation, for_two)

    def _html(self, word: str, here: bool, for_two: bool) -> Markup:
        if not word:
            return Markup()
        link = link_to(self._address.url.rstrip("/"), {GUEST: word})
        if here and not for_two:
            text = tr("The second person is here. In the experiment “Hold” they hold the other arm again.")
        elif here:
            text = tr("The second person is here, and holds the other arm.")
        elif self._address.private:
            text = tr_html("Only this computer can open the link. Start with <code>--host 0.0.0.0</code> to let others in.")
        else:
            text = tr("Send the link, or have the code read by a camera. The first who comes holds the other arm.")
        return macros("page/panels/invite.html").place(link, text, qr_svg(link, tr("QR code of the link")))
