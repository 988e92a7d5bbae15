"""The server's side of `law_editor.js`."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Protocol

import viser
from markupsafe import Markup

from app.features.custom_law.edited_file import MOST, ChangedMeanwhile, Version, read_version, save_text
from app.features.custom_law.examination import ExaminationProgress
from app.features.custom_law.law_html import law_html
from app.features.custom_law.student_law import examination, take_law_file, tests_of
from app.features.custom_law.trials import TRIALS
from app.i18n.speaking import N_, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.session.actions import Action
from app.session.frame import Frame
from app.session.relevant_settings import matters
from app.session.session import Session
from app.text.templates import element, macros
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of
from controllers.errors import DuetError
from scenes.files import readable
from scenes.laws import DEFAULT_LAW

WORDS: Final = {
    "run": N_("Save and run"),
    "how": N_("Ctrl+Enter saves and runs. Tab indents; Esc, then Tab leaves."),
    "saving": N_("Saving …"),
    "unsaved": N_("Not saved yet."),
    "saved": N_("Saved; it runs together with the paper’s law."),
    "fails": N_("Saved, but it does not run."),
    "conflict": N_("The file was changed by another editor since. Nothing was overwritten."),
    "keep": N_("Save mine over it"),
    "take": N_("Take the file’s text"),
    "large": N_("This text is too large to be edited here."),
}


class RunLaw(Action):
    """Save and run the law. `entry`: number, space, edited `Version.sha256`, line break, text."""

    entry: str


class LawTask(Protocol):
    """A part that leads the session and may ask for a custom law."""

    @property
    def asked(self) -> bool: ...

    @property
    def tab(self) -> viser.GuiTabHandle | None:
        """None while it is not on the page."""
        ...

    @property
    def order(self) -> float: ...

    def run_again(self) -> None: ...


class LawText:
    """A law's text.

    Attributes:
        name: key in the browser's memory.
        most: largest size [bytes].
        rows: initial height [lines].
    """

    name = ""
    words: Mapping[str, str] = WORDS
    most = MOST
    rows = 12

    @property
    def offered(self) -> bool:
        return True

    def title(self) -> str:
        return self.name

    def place(self) -> Markup:
        raise NotImplementedError

    def read(self) -> Version:
        """Current text.

        Raises:
            DuetError: it cannot be read.
        """
        raise NotImplementedError

    def save(self, text: str, base: str) -> Version:
        """Save and return a text.

        `base`: `sha256` of the edited version.

        Raises:
            ChangedMeanwhile: another editor changed the text.
            DuetError: it cannot be saved.
        """
        raise NotImplementedError

    def run(self) -> None:
        raise NotImplementedError


class FileText(LawText):
    """Text of a file, written when it first runs."""

    def __init__(self, session: Session, path: Path) -> None:
        self._session, self._path = session, path
        self.name = readable(path.name)

    def place(self) -> Markup:
        return macros("features/custom_law/law_editor.html").place(self.name)

    def read(self) -> Version:
        return read_version(self._path)

    def save(self, text: str, base: str) -> Version:
        return save_text(self._path, text, base)

    def run(self) -> None:
        take_law_file(self._session, self._path)


class LawEditor(PagePanel):
    """The editor of a person who may write a law here."""

    def __init__(self, page: PanelContext, text: LawText) -> None:
        self._gui, self._session, self._text = page.client.gui, page.session, text
        self.task: LawTask | None = None
        gui, session = self._gui, self._session
        box = gui.add_text("", "", visible=False)
        self._box = uuid_of(on_entry(box, lambda entry: session.post(RunLaw(entry))))
        self._version, self._number, self._said, self._refused = Version("", ""), "", "", ""
        self._seen = ""
        self._read()
        with page.controls.compare_tab:
            self._compare = self._add()
            self._tests = gui.add_html("")
        self._in_task: tuple[viser.GuiHtmlHandle, viser.GuiHtmlHandle] | None = None
        self._shown: object = None
        page.handlers.add(RunLaw, self._save_and_run)

    def _add(self, order: float | None = None) -> tuple[viser.GuiHtmlHandle, viser.GuiHtmlHandle]:
        return self._gui.add_html(self._text.place(), order=order), self._gui.add_html("", order=order)

    def _read(self) -> None:
        try:
            self._version, self._refused = self._text.read(), ""
        except DuetError as error:
            self._refused = str(error)

    def _save_and_run(self, action: RunLaw) -> None:
        head, _, text = action.entry.partition("\n")
        self._number, _, base = head.partition(" ")
        self._said, self._refused = "saved", ""
        try:
            self._version = self._text.save(text, base)
            self._run()
        except ChangedMeanwhile as changed:
            self._said, self._version = "conflict", changed.version
        except DuetError as error:
            self._said, self._refused = "refused", str(error)

    def _run(self) -> None:
        session, asked = self._session, self.task is not None and self.task.asked
        if session.parts.lead and not asked:
            # The run had another law.
            return
        session.change("ghost", DEFAULT_LAW)
        self._text.run()
        if self.task is not None and asked:
            self.task.run_again()
        session.control.halt.go_on()
        tests = examination(session)
        if tests is not None:
            tests.begin()

    def show(self, frame: Frame) -> None:
        law, task, tests = frame.live.law_status, self.task, tests_of(self._session)
        tab = None if task is None else task.tab
        offered = self._text.offered
        in_task = offered and task is not None and task.asked and tab is not None
        in_compare = offered and not self._session.parts.lead and matters("ghost", frame.live.settings)
        if law.sha256 not in (self._seen, self._version.sha256, ""):
            # Another editor has saved it; the text here stays.
            self._said = ""
            self._read()
        self._seen = law.sha256
        if task is not None and tab is not None and in_task and self._in_task is None:
            with tab:
                self._in_task = self._add(task.order)
        verdicts = () if tests.stale else tests.verdicts
        failed = [(one.reason, one.line) for one in verdicts if one.line is not None]
        problem, line = (law.problem, law.line) if law.problem or not failed else failed[0]
        state = (
            in_task,
            in_compare,
            self._version,
            self._number,
            self._said,
            self._refused,
            tests,
            line,
            problem,
            law.away,
        )
        if state == self._shown:
            return
        self._shown = state
        told = {
            "box": self._box,
            "file": self._text.name,
            "title": self._text.title(),
            "rows": self._text.rows,
            "text": self._version.text,
            "sha": self._version.sha256,
            "number": self._number,
            "said": self._said,
            "refused": tr(self._refused),
            "line": line,
            "problem": tr(problem),
            "lamps": [_lamp(tests, i, name) for i, name in enumerate(TRIALS)],
            "most": self._text.most,
            "words": {name: tr(word) for name, word in (WORDS | dict(self._text.words)).items()},
        }
        content = element("i", class_="duet-law-state", data_text=json.dumps(told))
        for pair, visible in ((self._compare, in_compare), (self._in_task, in_task)):
            if pair is not None:
                pair[1].content = content if visible else ""
                pair[0].visible = pair[1].visible = visible
        self._tests.visible = in_compare
        self._tests.content = law_html(tests, law.problem, law.away, edits=True) if in_compare else ""


def _lamp(tests: ExaminationProgress, place: int, name: str) -> tuple[str, str]:
    if place < len(tests.verdicts) and not tests.stale:
        verdict = tests.verdicts[place]
        return "ok" if verdict.passed else "no", f"{tr(name)}: {tr(verdict.reason)}"
    return "now" if tests.running and place == len(tests.verdicts) else "", tr(name)
