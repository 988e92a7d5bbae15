"""Operation of a session."""

from collections.abc import Sequence
from typing import Any, Final

import viser

from app.i18n.speaking import tr
from app.page.handles.gizmos import Gizmos
from app.page.panel_context import P, PanelContext, PanelMaker
from app.page.panels.controls import Controls
from app.page.panels.hotkeys import Hotkey, KeyHelp, hotkeys, keys_of
from app.page.panels.law_ticks import LawTicks
from app.page.panels.link_box import LinkBox
from app.page.panels.plot_controls import DetailsChooser, MomentChooser
from app.page.panels.replay_bar import ReplayBar
from app.page.panels.scene_words import SceneWords
from app.page.panels.view_row import ViewRow
from app.page.picture_size import PHONE, canvas_size
from app.page.view import View
from app.session import actions
from app.session.action_handlers import ActionHandlers
from app.session.frame import Frame
from app.session.session import Session
from controllers.errors import BadSetting
from scenes.laws import DEFAULT_LAW, NO_AVOIDANCE
from scenes.settings import values

CALM: Final = 0.1
"""Wall time between two updates of unused controls [s]."""

PANELS: Final[list[PanelMaker]] = [
    DetailsChooser,
    LawTicks,
    MomentChooser,
    ViewRow,
    lambda page: SceneWords(page.client, page.view, page.handlers),
]


class Operation:
    """Operator's part of a page.

    Args:
        instead, private, owners: see `PanelContext`.
        whole: True shows all settings; later the visitor's choice.

    Attributes:
        handlers: of the page's actions; they override the session's until the page closes.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        view: View,
        instead: tuple[Hotkey[Any], ...] = (),
        whole: bool = True,
        private: bool = False,
        owners: bool = False,
        panels: Sequence[PanelMaker] = (),
        key_help: Sequence[KeyHelp] = (),
    ) -> None:
        self.whole, self._instead = whole, instead
        self._client, self._session, self._view = client, session, view
        self.handlers = handlers = ActionHandlers()
        self._controls = Controls(
            client.gui, session, handlers, instead, canvas_size(client)[0] <= PHONE, key_help
        )
        self._keep = client.gui.add_folder(
            tr("Keep and replay"), order=self._controls.below_clock, expand_by_default=False
        )
        with self._keep:
            replay_bar = ReplayBar(client.gui, session, handlers)
        hands_off = lambda: session.parts.hands_off  # noqa: E731
        self._gizmos = gizmos = Gizmos(
            client, session.hand, lambda: view.stage.yours, hands_off, handlers, lambda: view.stage.wall
        )
        self._page = page = PanelContext(
            client,
            session,
            view,
            handlers,
            self._controls,
            gizmos,
            self._keep,
            private,
            owners,
            instead,
            [replay_bar],
        )
        for make in (*PANELS, *panels):
            panel = make(page)
            if panel is not None:
                page.made.append(panel)
        with self._keep:
            self._link = LinkBox(client, session, page.links)
        for hotkey in keys_of(hotkeys(), instead):
            hotkey.add_to(client.gui, session.post)
        handlers.add(actions.SetSetting, lambda action: self._set(action.key, action.value))
        handlers.add(actions.Digit, lambda action: self._set("scene", action.scene))
        handlers.add(actions.Toggle, self._toggle)
        handlers.add(actions.ShowAll, self._show_all)
        handlers.add(actions.FirstView, lambda _: view.look(client))
        session.handlers.cover(handlers)
        self._next = 0.0

    def _set(self, key: str, value: object) -> None:
        try:
            self._session.change(key, value)
        except BadSetting as error:
            self._session.notify("This value is not possible", str(error))
            self._controls.write_again()

    def _show_all(self, action: actions.ShowAll) -> None:
        self.whole = action.whole

    def _toggle(self, action: actions.Toggle) -> None:
        session = self._session
        present = values(session.settings)
        match action.what:
            case "avoidance":
                session.change("law", NO_AVOIDANCE if present["law"] == DEFAULT_LAW else DEFAULT_LAW)
            case "ghost":
                session.change("ghost", "frozen" if present["ghost"] == "off" else "off")
            case what:
                session.change(what, not present[what])

    def panel(self, kind: type[P]) -> P:
        """See `PanelContext.panel`."""
        return self._page.panel(kind)

    def notify_problems(self, problems: tuple[str, ...]) -> None:
        for problem in problems[:5]:
            self._session.notify("A part of the link was left out", problem)

    def show(self, frame: Frame, dirty: bool = True) -> None:
        """Update handles and controls, and show notices.

        `dirty`: False if nothing was done or has arrived.
        """
        self._gizmos.show(frame)
        notices = self._session.notices
        while notices:
            title, text = notices.popleft()
            self._client.add_notification(tr(title), tr(text), color="orange", auto_close_seconds=8.0)
        if frame.now < self._next and not (dirty or frame.pace.paused or frame.replayed):
            return
        self._next = frame.after(CALM)
        busy = frame.replayed or any(panel.needs_controls for panel in self._page.made)
        plays = not (self._instead or busy)
        self._controls.fold(self.whole, plays)
        self._view.equation_last = self._controls.small
        self._keep.visible = self.whole or not plays
        for panel in (self._controls, *self._page.made):
            panel.show(frame)
        self._link.show(frame, self._keep.visible)

    def close(self) -> None:
        self._session.handlers.uncover(self.handlers)
        for panel in self._page.made:
            panel.close()
