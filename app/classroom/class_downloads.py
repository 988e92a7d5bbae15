"""The class's report on the teacher's panel: what the class leaves behind, as a page to print or as a table."""

import time
from collections.abc import Callable
from functools import partial
from typing import Final

import viser

from app.export.class_report import class_report_bytes
from app.export.class_summary import ClassSummary
from app.export.class_table import class_table_bytes
from app.i18n.speaking import N_, set_language, tr
from app.lessons.lesson import LessonBook
from app.page.panels.choice_buttons import ChoiceButtons
from app.runtime.job_pool import Job, Jobs
from app.runtime.job_watch import JobWatch
from app.session.session import Session
from app.settings import Language
from app.text.html_element import element

Summaries = Callable[[], tuple[ClassSummary, ClassSummary | None]]
"""Returns what this class leaves behind so far, and what the one before has left, if anything."""

KINDS: Final = ("HTML", "CSV")


class ClassDownloads:
    """Two rows of buttons: for this class, and for the one before. All methods belong to the stage's thread.

    Args:
        session: the stage's.
        jobs: makes the files.
        book: the lessons in the teacher's language.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        jobs: Jobs,
        summaries: Summaries,
        book: LessonBook,
        language: Language,
    ) -> None:
        self._client, self._session, self._summaries = client, session, summaries
        self._lessons = book.lessons
        self._language: Language = language
        self._jobs = JobWatch(jobs, lambda: session.post(lambda: None, "news"), self._fail)

    def build(self) -> None:
        """Add the buttons. The caller has opened the container."""
        self._row(
            N_("class report"),
            N_("Every question with its counts, the challenges that were passed, and the reports handed in."),
            0,
        )
        last = self._summaries()[1]
        if last is not None:
            day = time.strftime("%Y-%m-%d, %H:%M", time.localtime(last.saved))
            ended = element("p", tr("The class before this one ended at {when}.", when=day), class_="soft")
            self._client.gui.add_html(element("div", "", ended, class_="duet-class"))
            self._row(N_("its report"), N_("The same for the class before this one."), 1)

    def _row(self, label: str, hint: str, which: int) -> None:
        ChoiceButtons(
            self._client.gui,
            label,
            KINDS,
            hint,
            lambda i: self._session.post(lambda: self._ask(which, i), ("class report", self._client.client_id, which, i)),
        )

    def _ask(self, which: int, kind: int) -> None:
        set_language(self._language)
        summary = self._summaries()[which]
        if summary is None or summary.empty:
            self._notify(tr("There is nothing to report yet"), tr("Let the class answer a question first."))
            return
        name = time.strftime("duet-class-%Y-%m-%d", time.localtime(summary.saved))
        if KINDS[kind] == "CSV":
            self._jobs.submit("class table", partial(self._send, name + ".csv"), class_table_bytes, summary, self._lessons)
        else:
            make = class_report_bytes, summary, self._lessons, self._language
            self._jobs.submit("class report", partial(self._send, name + ".html"), *make)

    def _send(self, name: str, content: bytes) -> None:
        self._client.send_file_download(name, content, save_immediately=True)

    def _notify(self, title: str, text: str) -> None:
        self._client.add_notification(title, text, color="orange", auto_close_seconds=8.0)

    def _fail(self, job: Job) -> None:
        self._notify(tr("The export failed"), tr(job.message))

    def show(self) -> None:
        """Hand over what is ready."""
        self._jobs.collect()

    def close(self) -> None:
        """Drop what is being made."""
        self._jobs.close()
