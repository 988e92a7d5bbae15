"""A house: the server, its host (a private session for every tab, or one stage for a whole lecture), and its frames."""

import logging
import threading
import warnings
from functools import partial
from pathlib import Path

from app.classroom.lecture import LectureHost
from app.hosting.frame_loop import FrameLoop
from app.hosting.preparation import Preparation
from app.hosting.private_host import PrivateHost
from app.hosting.teacher_key import Guesses
from app.lessons.loading import load_lessons, load_notes
from app.page.page_scripts import loading_html, page_assets
from app.runtime.job_pool import JobPool
from app.session.input_sources import NO_SOURCES, InputSources
from app.settings import Settings
from app.text.documents import DOCUMENTS, PREFIX, document_page
from app.web.server import DuetServer

log = logging.getLogger("duet.hosts")

# A tab that closes in the middle of a frame is no news; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)


class App:
    """A running server with its host and its frame loop; made by `start_app`.

    Attributes:
        server, host, background: as made.
        url: where the page is.
    """

    def __init__(
        self,
        server: DuetServer,
        host: PrivateHost | LectureHost,
        background: JobPool,
        people: InputSources = NO_SOURCES,
        preparation: Preparation | None = None,
    ) -> None:
        self.server, self.host, self.background, self.url = server, host, background, server.url
        self._people = people
        self._preparation = preparation
        self._loop = FrameLoop(host)
        server.is_at_work = self._loop.is_at_work
        self._loop.start()
        self._closed = threading.Event()

    def wait(self) -> None:
        """Block until `close` is called or Ctrl+C."""
        while not self._closed.wait(0.5):
            pass

    def close(self) -> None:
        """End the frames and everything that is being computed, close every connection and release the port."""
        if self._preparation is not None:
            self._preparation.close()
        self._loop.stop()
        self.host.close()
        self.background.close()
        self._people.close()
        self.server.stop()
        self._closed.set()


def start_app(
    host: str,
    port: int,
    settings: Settings,
    sessions: int = 8,
    lecture: bool = False,
    key: str | None = None,
    allowed_origins: tuple[str, ...] = (),
    people: InputSources = NO_SOURCES,
    lessons: Path | None = None,
    watchers: int = 200,
    ahead: bool = False,
) -> App:
    """Start to serve the page.

    Args:
        host, port: where; port 0 takes any free one.
        settings: what the page shows at first.
        sessions: how many private sessions there may be at once.
        lecture: one stage for all.
        key: of the teacher, or None.
        allowed_origins: further web addresses whose pages may connect.
        people: who can be imitated beside the built-in person; let go of when the house is closed.
        lessons: folder of lessons; None for our own.
        watchers: how many pages may be open in a lecture at once; who has the key gets in besides.
        ahead: whether what is slow the first time is made ready before anybody asks for it.

    Raises:
        PortInUse, BadSetting: see `app.web.server.DuetServer`.
    """
    server = DuetServer(
        host,
        port,
        allowed_origins=allowed_origins,
        max_clients=watchers if lecture else sessions,
        turn_away=Guesses(key).turn_away,
        assets=page_assets(settings.page),
        body=loading_html(),
        documents={PREFIX + name: partial(document_page, name) for name in DOCUMENTS},
    )
    server.scene.world_axes.visible = False
    background = JobPool()
    book = load_lessons() if lessons is None else load_lessons(lessons)
    for problem in book.problems:
        log.warning("a lesson was left out: %s", problem)
    # The notes are not even read where nobody has a key to them.
    notes = {} if key is None else load_notes() if lessons is None else load_notes(lessons)
    preparation = Preparation(book, background) if ahead else None
    if lecture:
        stage = LectureHost(server, settings, key, background, people, book, notes, sessions, host)
        return App(server, stage, background, people, preparation)
    return App(server, PrivateHost(server, settings, background, people, book, key, notes), background, people, preparation)
