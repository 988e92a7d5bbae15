"""A guest's page, with the handles of one arm."""

from contextlib import suppress
from time import perf_counter
from typing import Final

import viser

from app.features.lever.card_lever import CardLever
from app.features.second_person.second_hand import SecondHand
from app.features.second_person.second_place import SecondPlace
from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import tab_id
from app.i18n.reader_language import look_of, mark_html
from app.i18n.speaking import N_, set_language, spoken, tr
from app.page.handles.gizmos import Gizmos
from app.page.page_assets import configure_theme
from app.page.panels.hotkeys import hotkeys
from app.page.panels.scene_words import SceneWords
from app.page.view import View
from app.session.action_handlers import ActionHandlers
from app.session.actions import Describe, FirstView, Nudge, SwingElbow
from app.session.frame import Frame, freeze
from app.session.shown import Shown
from app.settings import JOIN
from app.text.templates import macros
from app.web.request import browser_language, request_query
from scenes.laws import NO_AVOIDANCE

CLOSED: Final = N_(
    "This invitation is not open: your host is away, or has ended it. As soon as it opens, this page continues."
)
AWAY: Final = N_("Your host is away. As soon as they are back, this page continues.")
TAKEN: Final = N_("Another guest holds this arm. As soon as they leave, it is yours.")
ENDED: Final = N_("Your host has ended this invitation.")


class Guest:
    """Belongs to the frame loop's thread. `word`: of the link."""

    def __init__(self, context: AppContext, client: viser.ClientHandle) -> None:
        query = request_query(client)
        self.client, self.word, self._tab = client, query.get(JOIN, ""), tab_id(query)
        self._context = context
        self._look = look_of(query, browser_language(client), context.options.settings)
        self._handlers = ActionHandlers()
        self._hand: SecondHand | None = None
        self._host: Visitor | None = None
        self._said, self._sent = "", False

    def build(self, host: Visitor | None) -> Pieces:
        """Show the host's session, or why there is no place."""
        client, look = self.client, self._look
        set_language(look.language)
        with client.atomic():
            self._over = client.gui.add_html(mark_html(spoken()))
            if host is None or not self._can_take(host):
                configure_theme(client.gui, look.theme)
                return
            session, self._host = host.session, host
            place_of(host).guest = self
            self._view = View(
                client,
                session,
                lambda: [client],
                look=look,
                folds=False,
                tip=guest_tip,
                overlays=(CardLever,),
            )
            yield
            self._view.show(freeze(session, perf_counter()))
            yield
            handlers = self._handlers
            hand = self._hand = SecondHand(session, handlers.do)
            hands_off = lambda: self._host is None or self._host.session.parts.hands_off  # noqa: E731
            self._gizmos = Gizmos(client, hand, lambda: self._view.stage.other, hands_off, handlers)
            self._words = SceneWords(client, self._view, handlers)
            handlers.add(Nudge, self._gizmos.nudge)
            handlers.add(FirstView, lambda _: self._view.look(client))
            for hotkey in hotkeys():
                if isinstance(hotkey.action, (Nudge, SwingElbow, FirstView, Describe)):
                    hotkey.add_to(client.gui, hand.post)
            self._view.welcome(client)
        session.wake()

    def _can_take(self, host: Visitor) -> bool:
        """True if the place is free, or the same tab's."""
        before = place_of(host).guest
        return before is None or (isinstance(before, Guest) and before._tab == self._tab is not None)

    def follow(self, host: Visitor | None) -> None:
        """Continue with the host, wait, or reconnect. `host`: None while absent."""
        mine = None if self._host is None else self._host.session
        if self._host is not None and (
            place_of(self._host).guest is not self or place_of(self._host).word != self.word
        ):
            # The same tab has connected again, or the host has ended the invitation.
            self._say(TAKEN if place_of(self._host).word == self.word else ENDED)
            self.leave()
            self._host = self._hand = mine = None
        if self._said == ENDED:
            return
        if host is None:
            self._say(CLOSED if mine is None else AWAY)
        elif host.session is mine:
            self._host, host.beside = host, (*host.beside, self)
            self._say("")
        elif mine is None and place_of(host).guest is not None:
            self._say(TAKEN)
        else:
            self.come_again()

    def _say(self, text: str) -> None:
        if text != self._said:
            self._said = text
            set_language(self._look.language)
            with suppress(Exception), self.client.atomic():
                self._over.content = mark_html(spoken()) + (
                    macros("features/second_person/guest.html").waiting(tr(text)) if text else ""
                )

    def come_again(self) -> None:
        """Reconnect the page to the host."""
        self.leave()
        if not self._sent:
            self._sent = True
            self._context.server.send_elsewhere(self.client)

    def leave(self) -> None:
        if self._host is not None and place_of(self._host).guest is self:
            place_of(self._host).guest = self._host.session.hand.other = None
            self._host.session.wake()

    def act(self) -> None:
        if self._hand is not None:
            self._hand.posts.do()

    def show(self, frame: Frame) -> None:
        """Errors here never reach the host's page."""
        set_language(self._look.language)
        with self._context.guarded("a frame of a guest's page failed", self.client.client_id):
            with self.client.atomic():
                self._view.show(frame)
                self._gizmos.show(frame)
                self._words.show(frame)
            self.client.flush()


def place_of(host: Visitor) -> SecondPlace:
    return host.session.parts.of(SecondPlace)


def guest_tip(shown: Shown) -> str:
    run = shown.settings.run
    if shown.replay.time is not None:
        return tr("Recording: your host looks at an earlier moment.")
    if not run.experiment.for_two:
        return tr("Here only your host holds something. In the experiment “Hold” the silver arm is yours.")
    yours = tr("You hold the silver arm, and your host the orange one: pull yours by any link.")
    yours = f"{yours} {tr('Your hand goes back to its ring; pull the elbow to see the arm give way.')}"
    both = run.both_avoid and run.law.law != NO_AVOIDANCE
    return f"{yours} {tr('Both keep clear: try to touch each other.')}" if both else yours
