"""Replay with a scrubber, and the files to save or load: the run, a table, pictures, a page that plays, Python."""

import html
import json
from collections.abc import Callable
from typing import Final

import viser

from app.export.export_queue import KINDS, ExportQueue
from app.i18n.speaking import tr
from app.page import STATIC
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.copy_button import copy_button
from app.page.panels.scrubber import Scrubber
from app.runtime.job_pool import Jobs
from app.session.actions import Action, Pause
from app.session.frame import Frame
from app.session.session import Session
from app.web.viser_internals import HotkeyKey
from scenes.inputs import KEEP

KEY: Final[HotkeyKey] = "9"
"""What the script `replay_box.js` presses with Alt and Shift as soon as a moment is about to be typed beside the scrubber.

A replay that plays writes its moment into that box ten times a second, and would overwrite what is being typed. Only the browser
knows where the focus is, and a value that is not possible yet (the 1 of 12.5) never reaches the server.
"""

LENGTHS: Final[dict[str, float]] = {"10 s": 10.0, "30 s": 30.0, "1 min": 60.0, "All": KEEP}
"""What is said → how much of the newest part of the run is meant [s]."""

LABELS: Final = ("Run", "CSV", "PNG", "SVG", "HTML", "Python")
"""Of the buttons, in the order of `app.export.export_queue.KINDS`."""

HINT: Final = (
    "Run: a file that can be loaded again. CSV: every step. PNG, SVG: the plots. HTML: a page that plays scene and plots offline. "
    "Python: lines that make the run again."
)

WRITE: Final = 0.1
"""Time between two writes of the moment while the replay plays [s]."""

_STYLE: Final = (STATIC / "replay.css").read_text(encoding="utf-8")


def replay_style(loaded: str) -> str:
    """Return a style that says all over the page that this is no live run. `loaded`: name of the file that is shown, or ""."""
    words = tr("This is a loaded run") if loaded else tr("This is the past")
    return f"<style>body::after{{content:{json.dumps(words, ensure_ascii=False)}}}{_STYLE}</style>"


class ReplayBar:
    """All controls of the shelf.

    Args:
        background: where everything is computed.
        send: gives the visitor a file: name and content.

    Attributes:
        shelf: what they operate.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        background: Jobs,
        send: Callable[[str, bytes], None],
        notify: Callable[[str, str], None],
    ) -> None:
        self._gui, self._session, self._send, self._notify = gui, session, send, notify
        self.shelf = shelf = ExportQueue(session, background)
        session.player = self._player = player = shelf.player
        self._length = LENGTHS["30 s"]

        def operate(button: int) -> None:
            match button:
                case 0:
                    player.watch(self._length)
                case 1:
                    player.take(Pause())
                case _:
                    player.leave()

        self._replay = ChoiceButtons(
            gui,
            "replay",
            ("Watch", "Play", "Back to live"),
            "The run waits while you look at what was; Space plays and rests, . goes one step.",
            lambda i: session.post(lambda: operate(i), ("replay", i)),
        )
        self._replay.show(offered=(0,))
        self._scrubber = Scrubber(gui, session, player.seek, "moment", 0.01, WRITE)
        # By this the script finds the box.
        self._mark = f'<i hidden data-duet-moment="{html.escape(self._scrubber.id)}"></i>'
        self._state = gui.add_html(self._mark)
        self._rest_key: viser.CommandHandle | None = None
        lengths = tuple(LENGTHS)
        self._lengths = ChoiceButtons(
            gui, "the last", lengths, "How much of the run is meant, to watch and to save.", self._choose
        )
        self._lengths.show(lengths.index("30 s"))
        self._save = ChoiceButtons(
            gui, "save as", LABELS, HINT, lambda i: session.post(lambda: shelf.ask(KINDS[i], self._length), ("save", i))
        )
        self._upload = gui.add_upload_button(
            tr("Load a run"),
            icon=viser.Icon.UPLOAD,
            color="gray",
            hint=tr("A file saved with Run: it is made again, compared with what came out then, and replayed."),
        )

        @self._upload.on_upload
        async def _(event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
            file = event.target.value
            session.post(lambda: shelf.load(file.content, file.name), "load")

    def take(self, action: Action) -> bool:
        """Do an action if it is about the replay; return whether it was."""
        return self._player.take(action)

    def close(self) -> None:
        """Back to live; drop everything that is being computed."""
        self._offer_rest(False)
        self._player.leave()
        self.shelf.close()
        self._session.player = None

    def _choose(self, index: int) -> None:
        def choose() -> None:
            self._length = tuple(LENGTHS.values())[index]
            self._lengths.show(index)

        self._session.post(choose, "length")

    def _offer_rest(self, offered: bool) -> None:
        """Listen to `KEY`, or not."""
        if self._rest_key is not None and not offered:
            self._rest_key.remove()
            self._rest_key = None
        elif self._rest_key is None and offered:
            title, icon = tr("Replay: stand still"), viser.Icon.PLAYER_PAUSE
            self._rest_key = self._gui.add_command(title, hotkey=KEY, modifier="alt+shift", icon=icon)

            @self._rest_key.on_trigger
            async def _(_: viser.CommandEvent) -> None:
                self._session.post(self._rest, "rest")

    def _rest(self) -> None:
        if self._player.replay is not None:
            self._player.replay.playing = False
            # Where it rests is written at once, and then nothing more.
            self._scrubber.rest()

    def show(self, frame: Frame) -> None:
        """Hand over what is ready, and bring the controls up to date."""
        shelf, replay = self.shelf, self._player.replay
        for file in shelf.take_files():
            self._send(*file)
        for news in shelf.take_news():
            self._notify(*news)
        if (snippet := shelf.take_snippet()) is not None:
            self._show_snippet(snippet)
        playing = replay is not None and replay.playing
        self._replay.show(1 if playing else -1, (0,) if replay is None else (1, 2))
        self._offer_rest(replay is not None)
        self._scrubber.show(frame.now, None if replay is None else (replay.begin, replay.end, replay.time))
        text = self._words()
        said = f'<div class="duet duet-state" role="status">{html.escape(text)}</div>' if text else ""
        self._state.content = self._mark + said

    def _words(self) -> str:
        shelf = self.shelf
        if shelf.busy:
            return tr("Making {what} …", what=tr(shelf.busy))
        if self._player.replay is None:
            return ""
        if self._player.loaded:
            return tr("This is {file}, not the live run.", file=self._player.loaded)
        return tr("This is the past; the live run waits.")

    def _show_snippet(self, snippet: str) -> None:
        with self._gui.add_modal(tr("This run in Python")) as modal:
            self._gui.add_html(
                '<div class="duet"><pre style="max-height:50vh;overflow:auto;white-space:pre-wrap;overflow-wrap:anywhere;'
                f'font-size:12px" tabindex="0">{html.escape(snippet)}</pre>{copy_button(tr("Copy"), "pre")}</div>'
            )
            close = self._gui.add_button(tr("Close"))

        @close.on_click
        async def _(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            modal.close()
