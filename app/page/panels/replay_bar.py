"""Controls of replays."""

from typing import Final, Literal

import viser
from markupsafe import Markup

from app.i18n.speaking import N_, tr
from app.page import STATIC
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.shown_moment import Scrubber, Seek, css_text
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action
from app.session.frame import Frame
from app.session.session import Session
from app.session.shown import Shown
from app.text.templates import element
from app.web.control_events import on_press
from app.web.viser_internals import HotkeyKey
from scenes.inputs import KEEP

KEY: Final[HotkeyKey] = "9"
"""Key by which `replay_box.js` pauses a replay before a moment is typed, because the replay would
overwrite it. Only the browser knows the focus."""

LENGTHS: Final[dict[str, float]] = {"10 s": 10.0, "30 s": 30.0, "1 min": 60.0, N_("All"): KEEP}
"""Label → newest part of the run [s]."""

WRITE: Final = 0.1
"""Time between two writes of the moment [s]."""

_STYLE: Final = (STATIC / "replay.css").read_text(encoding="utf-8")
_REVIEW: Final = (STATIC / "review.css").read_text(encoding="utf-8")


class OperateReplay(Action, newest_by=("what",)):
    what: Literal["watch", "play", "leave", "rest"]


class SeekReplay(Seek): ...


class ChooseLength(Action):
    """Index in `LENGTHS`."""

    index: int


def replay_style(shown: Shown) -> Markup:
    """Style that marks a replay, or the shown moment of a paused run."""
    if shown.replay.reviewed:
        return Markup(f"<style>body::after{{content:var(--duet-moment-words)}}{_STYLE}{_REVIEW}</style>")
    words = tr("This is a loaded run") if shown.replay.file else tr("This is the past")
    return Markup(f"<style>body::after{{content:{css_text(words)}}}{_STYLE}</style>")


class ReplayBar(PagePanel):
    """Controls of replays. `length`: replayed newest part of the run [s]."""

    def __init__(self, gui: viser.GuiApi, session: Session, handlers: ActionHandlers) -> None:
        self._gui, self._session, self._player = gui, session, session.player
        self.length = LENGTHS["30 s"]

        self._replay = ChoiceButtons(
            gui,
            "replay",
            {
                "Watch": OperateReplay("watch"),
                "Play": OperateReplay("play"),
                "Back to live": OperateReplay("leave"),
            },
            "The live run waits while you look back. Space: play or pause. Full stop: one step.",
            session.post,
        )
        self._replay.show(offered=(0,))
        self._scrubber = Scrubber(gui, session, handlers, SeekReplay, session.player.seek, 0.01, WRITE)
        # The script finds the box by this.
        self._mark = element("i", hidden="", data_duet_moment=self._scrubber.id)
        self._state = gui.add_html(self._mark)
        self._rest_key: viser.CommandHandle | None = None
        self._lengths = ChoiceButtons(
            gui,
            "the last",
            {said: ChooseLength(i) for i, said in enumerate(LENGTHS)},
            "How much of the run is meant, to watch and to save.",
            session.post,
        )
        self._lengths.show(list(LENGTHS).index("30 s"))
        handlers.add(OperateReplay, self._operate)
        handlers.add(ChooseLength, self._choose_length)

    def _operate(self, action: OperateReplay) -> None:
        match action.what:
            case "watch":
                self._player.watch(self.length)
            case "play":
                self._player.toggle()
            case "leave":
                self._player.leave()
            case "rest":
                self._rest()

    def _choose_length(self, action: ChooseLength) -> None:
        self.length = tuple(LENGTHS.values())[action.index]
        self._lengths.show(action.index)

    def close(self) -> None:
        self._offer_rest(False)
        self._player.leave()

    def _offer_rest(self, offered: bool) -> None:
        if self._rest_key is not None and not offered:
            self._rest_key.remove()
            self._rest_key = None
        elif self._rest_key is None and offered:
            title, icon = tr("Replay: pause"), viser.Icon.PLAYER_PAUSE
            self._rest_key = self._gui.add_command(title, hotkey=KEY, modifier="alt+shift", icon=icon)
            on_press(self._rest_key, lambda: self._session.post(OperateReplay("rest")))

    def _rest(self) -> None:
        if self._player.replay is not None:
            self._player.replay.playing = False
            # The final moment is written at once, and then nothing more.
            self._scrubber.rest()

    def show(self, frame: Frame) -> None:
        replay = self._player.replay
        playing = replay is not None and replay.playing
        self._replay.show(1 if playing else -1, (0,) if replay is None else (1, 2))
        self._offer_rest(replay is not None)
        self._scrubber.show(frame.now, None if replay is None else (replay.begin, replay.end, replay.time))
        text = self._words()
        self._state.content = (
            self._mark + element("div", text, class_="duet duet-state", role="status") if text else self._mark
        )

    def _words(self) -> str:
        if self._player.replay is None:
            return ""
        if self._player.loaded:
            return tr("This is {file}, not the live run.", file=self._player.loaded)
        if self._player.reviewing:
            return tr("The run is stopped; this is an earlier moment.")
        return tr("This is the past; the live run waits.")
