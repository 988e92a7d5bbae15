"""Downloads of the class's report."""

import time
from collections.abc import Callable
from functools import partial
from typing import Final

import viser

from app.features.classroom.class_report import class_report_bytes, class_table_bytes, class_zip_bytes
from app.features.classroom.class_summary import ClassSummary
from app.features.lessons.lesson import LessonBook
from app.i18n.speaking import N_, set_language, tr
from app.page.panels.choice_buttons import ChoiceButtons
from app.runtime.job_pool import Jobs, JobWatch
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action
from app.session.session import Session
from app.settings import Language
from app.text.templates import macros

Summaries = Callable[[], tuple[ClassSummary, ClassSummary | None]]
"""Reports of this class and of the last one, or None."""

KINDS: Final = ("HTML", "CSV", "ZIP")


class MakeReport(Action, newest_by=("client", "which", "kind")):
    """Make the report of this class (`which` = 0) or the last one (1); `kind`: of `KINDS`."""

    client: int
    which: int
    kind: str


class ClassDownloads:
    """Download buttons; on the shared session's thread. `book`: in the teacher's language."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        handlers: ActionHandlers,
        jobs: Jobs,
        summaries: Summaries,
        book: LessonBook,
        language: Language,
    ) -> None:
        self._client, self._session, self._summaries = client, session, summaries
        self._lessons = book.lessons
        self._language: Language = language
        self._jobs = JobWatch(
            jobs, session.wake, lambda job: self._notify(tr("The export failed"), tr(job.message))
        )
        handlers.add(MakeReport, self._make)

    def build(self) -> None:
        self._row(
            N_("class report"),
            N_(
                "Every question with its counts, the challenges that were passed, and the reports handed in; as ZIP these alone, one file "
                "a student, for lwr-duet grade."
            ),
            0,
        )
        last = self._summaries()[1]
        if last is not None:
            day = time.strftime("%Y-%m-%d, %H:%M", time.localtime(last.saved))
            ended = tr("The class before this one ended at {when}.", when=day)
            self._client.gui.add_html(macros("page/panels/pills.html").note(ended))
            self._row(N_("its report"), N_("The same for the class before this one."), 1)

    def _row(self, label: str, hint: str, which: int) -> None:
        ChoiceButtons(
            self._client.gui,
            label,
            {kind: MakeReport(self._client.client_id, which, kind) for kind in KINDS},
            hint,
            self._session.post,
        )

    def _make(self, action: MakeReport) -> None:
        if action.client != self._client.client_id:
            # The teacher who asked has given the controls away.
            return
        set_language(self._language)
        summary = self._summaries()[action.which]
        if summary is None or summary.empty:
            self._notify(tr("There is nothing to report yet"), tr("Let the class answer a question first."))
        elif action.kind == "ZIP" and not summary.hand_ins:
            self._notify(tr("There is nothing to report yet"), tr("reports handed in: {count}", count=0))
        else:
            self._submit(action.kind, summary)

    def _submit(self, kind: str, summary: ClassSummary) -> None:
        name = time.strftime(f"duet-class-%Y-%m-%d.{kind.lower()}", time.localtime(summary.saved))
        send = partial(self._client.send_file_download, name, save_immediately=True)
        if kind == "CSV":
            self._jobs.submit("class table", send, class_table_bytes, summary, self._lessons)
        else:
            make = class_zip_bytes if kind == "ZIP" else class_report_bytes
            self._jobs.submit("class report", send, make, summary, self._lessons, self._language)

    def _notify(self, title: str, text: str) -> None:
        self._client.add_notification(title, text, color="orange", auto_close_seconds=8.0)

    def show(self) -> None:
        self._jobs.collect()

    def close(self) -> None:
        self._jobs.close()
