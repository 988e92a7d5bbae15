"""Buttons that save or load a run."""

from dataclasses import field
from functools import partial
from typing import Final

import viser

from app.features.exports.export_queue import ExportQueue, FileKind
from app.i18n.speaking import N_, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.choice_buttons import ChoiceButtons
from app.page.panels.replay_bar import ReplayBar
from app.session.actions import Action
from app.session.frame import Frame
from app.text.templates import element, macros
from app.web.control_events import on_file, on_press

EXPORTS: Final[dict[str, FileKind]] = {
    N_("Run"): "run",
    "CSV": "csv",
    "PNG": "png",
    "SVG": "svg",
    "HTML": "html",
    "Python": "python",
}

HINT: Final = N_(
    "Run: a file that can be loaded again. CSV: every step. PNG, SVG: the plots. HTML: a page that plays scene and plots offline. "
    "Python: lines that make the run again."
)


class Export(Action, newest_by=("kind",)):
    kind: FileKind


class LoadRun(Action):
    name: str
    content: bytes = field(repr=False)


class ExportsPanel(PagePanel):
    """The buttons of the replay define the saved length."""

    def __init__(self, page: PanelContext) -> None:
        gui, session, replay = page.client.gui, page.session, page.panel(ReplayBar)
        self._gui, self.exports = gui, ExportQueue(session, session.player)
        self._send = partial(page.client.send_file_download, save_immediately=True)
        with page.keep:
            ChoiceButtons(
                gui, "save as", {said: Export(kind) for said, kind in EXPORTS.items()}, HINT, session.post
            )
            upload = gui.add_upload_button(
                tr("Load a run"),
                icon=viser.Icon.UPLOAD,
                color="gray",
                hint=tr(
                    "A file saved with Run: it is computed again, compared with the saved result, and replayed."
                ),
            )
            self._state = gui.add_html("")
        on_file(upload, lambda name, content: session.post(LoadRun(name, content)))
        page.handlers.add(Export, lambda action: self.exports.ask(action.kind, replay.length))
        page.handlers.add(LoadRun, lambda action: self.exports.load(action.content, action.name))

    def show(self, frame: Frame) -> None:
        del frame
        for file in self.exports.take_files():
            self._send(*file)
        if (snippet := self.exports.take_snippet()) is not None:
            with self._gui.add_modal(tr("This run in Python")) as modal:
                self._gui.add_html(macros("page/panels/copy.html").snippet(snippet))
                on_press(self._gui.add_button(tr("Close")), modal.close)
        busy = self.exports.busy
        text = tr("Making {what} …", what=tr(busy)) if busy else ""
        self._state.content = element("div", text, class_="duet duet-state", role="status") if text else ""

    def close(self) -> None:
        self.exports.close()
