"""The host's invitation: link and QR code."""

import secrets

import viser
from markupsafe import Markup

from app.features.second_person.second_place import SecondPlace
from app.i18n.speaking import tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.link_box import link_to
from app.session.actions import Action
from app.session.frame import Frame
from app.settings import JOIN
from app.text.templates import macros, tr_html
from app.web.address import address_known_to, qr_svg
from app.web.control_events import on_press


class Invite(Action):
    on: bool


class InviteBox(PagePanel):
    """Visible while an invitation is open, or in an experiment for two."""

    def __init__(self, page: PanelContext) -> None:
        gui, session = page.client.gui, page.session
        self._place, self._keep = session.parts.of(SecondPlace), page.keep
        self._address = address_known_to(page.client)
        self._shown = ("", False, True)
        self._folder = gui.add_folder(
            tr("Two people, one arm each"), order=page.controls.below_clock, expand_by_default=False
        )
        with self._folder:
            self._link = gui.add_html("")
            self._invite = gui.add_button(tr("Invite a second person"), icon=viser.Icon.USER_PLUS)
            self._end = gui.add_button(tr("End the invitation"), color="gray", visible=False)
        on_press(self._invite, lambda: session.post(Invite(True)))
        on_press(self._end, lambda: session.post(Invite(False)))
        page.handlers.add(Invite, self._open_or_end)

    def _open_or_end(self, action: Invite) -> None:
        self._place.word = (self._place.word or secrets.token_hex(8)) if action.on else ""

    def show(self, frame: Frame) -> None:
        word, here = self._place.word, self._place.guest is not None
        for_two = frame.live.settings.run.experiment.for_two
        # Offered together with “Keep and replay”.
        self._folder.visible = bool(word) or (self._keep.visible and for_two)
        if (word, here, for_two) != self._shown:
            self._shown = word, here, for_two
            self._invite.visible, self._end.visible = not word, bool(word)
            self._link.content = self._html(word, here, for_two)

    def _html(self, word: str, here: bool, for_two: bool) -> Markup:
        if not word:
            return Markup()
        link = link_to(self._address.url.rstrip("/"), {JOIN: word})
        if here and not for_two:
            text = tr("The second person is here. In the experiment “Hold” they hold the other arm again.")
        elif here:
            text = tr("The second person is here, and holds the other arm.")
        elif self._address.private:
            text = tr_html(
                "Only this computer can open the link. Start with <code>--host 0.0.0.0</code> to admit others."
            )
        else:
            text = tr(
                "Send the link, or have the code read by a camera. The first who comes holds the other arm."
            )
        return macros("features/second_person/invite.html").place(
            link, text, qr_svg(link, tr("QR code of the link"))
        )


def invite_box(page: PanelContext) -> InviteBox | None:
    """None on the page of a class or a group."""
    return InviteBox(page) if page.private else None
