"""Links that a visitor passes on: to the page as it is now, and for a second person who is to hold the other arm, with a code of it."""

import secrets
from collections.abc import Mapping
from dataclasses import replace
from typing import Final
from urllib.parse import urlencode

import viser
from markupsafe import Markup

from app.i18n.speaking import tr
from app.lessons.session.lesson_session import LessonSession
from app.page.panels import PagePanel
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action
from app.session.counterexample_search import NAME
from app.session.frame import Frame, freeze
from app.session.session import Session
from app.settings import ATTACK, GUEST, Settings, to_query
from app.text.templates import macros, tr_html
from app.web.address import address_known_to, qr_svg
from app.web.control_events import on_press
from app.web.request import frames_of, request_address
from scenes.counterexample import Attack

PERIOD: Final = 0.5
"""Time between two writes of the link [s]; while a slider is dragged it need not follow."""

OF_LESSONS: Final = ("scene", "rig", "robot", "autopilot", "ghost", "whatif", "plot", "speed", "lever")
"""What a step decides by itself, and a link to it need not say."""


def attack_query(settings: Settings, attack: Attack) -> dict[str, str]:
    """Return what a link says that replays an attack to break the promise."""
    return {**to_query(replace(settings, run=attack.settings)), ATTACK: attack.text()}


def link_query(settings: Settings, lessons: LessonSession) -> dict[str, str]:
    """Return what a link to the present page says."""
    if not lessons.open:
        return to_query(settings)
    walk = lessons.walk
    query = to_query(settings, walk.setup.settings(Settings()))
    query = {key: text for key, text in query.items() if key not in OF_LESSONS}
    return {"lesson": walk.lesson.id, "step": str(walk.lesson.steps.index(walk.step) + 1), **query}


def link_to(address: str, query: Mapping[str, str]) -> str:
    """Return the link: address of the page, such as http://localhost:8080, and what it says."""
    return f"{address}/?{urlencode(query)}"


class LinkBox:
    """A line with the link, and a button that copies it.

    Args:
        client: who gets it; its container is open.
        session, lessons: what the link opens again.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, lessons: LessonSession) -> None:
        self._lessons = lessons
        self._address, self._frames = request_address(client), frames_of(client)
        self._box = client.gui.add_html("")
        self._next = 0.0
        self.show(freeze(session, 0.0))

    def show(self, frame: Frame) -> None:
        """Bring the link up to date, every `PERIOD`."""
        if frame.now < self._next:
            return
        self._next = frame.after(PERIOD)
        settings = frame.live.settings
        attack = None if frame.studies is None else frame.studies.counterexample.replayed
        if frame.shown.replayed_file == NAME and attack is not None:
            query = attack_query(settings, attack)
        else:
            query = link_query(settings, self._lessons)
        link = link_to(self._address, query)
        self._box.content = macros("page/panels/copy.html").link(link, self._frames)


class Invite(Action):
    """Invite a second person, or end the invitation."""

    on: bool


class InviteBox(PagePanel):
    """A folder with the invitation; there where two people can hold an arm each, and as long as one is open. Its container is open.

    Args:
        handlers: of the page.
        order: of the folder in its container.

    Attributes:
        offered: whether there is room for it; an open invitation is shown all the same.
    """

    def __init__(self, client: viser.ClientHandle, session: Session, handlers: ActionHandlers, order: float) -> None:
        gui, self._session = client.gui, session
        self._address = address_known_to(client)
        self._shown, self.offered = ("", False, True), True
        self._folder = gui.add_folder(tr("Two people, one arm each"), order=order, expand_by_default=False)
        with self._folder:
            self._place = gui.add_html("")
            self._invite = gui.add_button(tr("Invite a second person"), icon=viser.Icon.USER_PLUS)
            self._end = gui.add_button(tr("End the invitation"), color="gray", visible=False)
        on_press(self._invite, lambda: session.post(Invite(True)))
        on_press(self._end, lambda: session.post(Invite(False)))
        handlers.add(Invite, self._open_or_end)

    def _open_or_end(self, action: Invite) -> None:
        session = self._session
        session.invitation = (session.invitation or secrets.token_hex(8)) if action.on else ""

    def show(self, frame: Frame) -> None:
        """Show the link, and whether a guest has come by it."""
        live = frame.live
        word, here, for_two = live.invitation, live.guest is not None, live.settings.run.experiment.for_two
        self._folder.visible = bool(word) or (self.offered and for_two)
        if (word, here, for_two) != self._shown:
            self._shown = word, here, for_two
            self._invite.visible, self._end.visible = not word, bool(word)
            self._place.content = self._html(word, here, for_two)

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
