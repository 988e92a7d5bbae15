"""A house: the server, its host (a private session for every tab, or one stage for a whole lecture), and its frames."""

import logging
import threading
import warnings
from pathlib import Path

from app.background import Background
from app.classroom.key import Guesses
from app.frame_loop import FrameLoop
from app.languages.visitor import language_script
from app.lecture import LectureHost
from app.lessons.loading import load_lessons, load_notes
from app.page.keys import relay_script
from app.page.lesson_resume import resume_script
from app.page.replay_box import box_script
from app.page.software import software_script
from app.page.teacher_key import key_script
from app.page.teacher_script import class_script
from app.people import NOBODY_ELSE, People
from app.private_host import PrivateHost
from app.server.server import DuetServer, start_server
from app.settings import Settings

log = logging.getLogger("duet.hosts")

# A tab that closes in the middle of a frame is no news; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)


class House:
    """A running server with its host and its frame loop; made by `open_house`.

    Attributes:
        server, host, background: as made.
        url: where the page is.
    """

    def __init__(
        self, server: DuetServer, host: PrivateHost | LectureHost, background: Background, people: People = NOBODY_ELSE
    ) -> None:
        self.server, self.host, self.background, self.url = server, host, background, server.url
        self._people = people
        self._loop = FrameLoop(host)
        self._loop.start()
        self._closed = threading.Event()

    def wait(self) -> None:
        """Block until `close` is called or Ctrl+C."""
        while not self._closed.wait(0.5):
            pass

    def close(self) -> None:
        """End the frames and everything that is being computed, close every connection and release the port."""
        self._loop.stop()
        self.host.close()
        self.background.close()
        self._people.close()
        self.server.stop()
        self._closed.set()


def open_house(
    host: str,
    port: int,
    settings: Settings,
    sessions: int = 8,
    lecture: bool = False,
    key: str | None = None,
    allowed_origins: tuple[str, ...] = (),
    people: People = NOBODY_ELSE,
    lessons: Path | None = None,
) -> House:
    """Start to serve the page.

    Args:
        host, port: where; port 0 takes any free one.
        settings: what the page shows at first.
        sessions: how many private sessions there may be at once; a lecture has no limit for those who watch.
        lecture: one stage for all.
        key: of the teacher, or None.
        allowed_origins: further web addresses whose pages may connect.
        people: who can be imitated beside the built-in person; let go of when the house is closed.
        lessons: folder of lessons; None for our own.

    Raises:
        PortInUse, BadSetting: see `app.server.server.start_server`.
    """
    server = start_server(
        host,
        port,
        allowed_origins=allowed_origins,
        max_clients=None if lecture else sessions,
        turn_away=Guesses(key).turn_away,
        script=key_script()
        + software_script()
        + relay_script()
        + resume_script()
        + box_script()
        + language_script()
        + class_script(),
    )
    server.scene.world_axes.visible = False
    background = Background()
    book = load_lessons() if lessons is None else load_lessons(lessons)
    for problem in book.problems:
        log.warning("a lesson was left out: %s", problem)
    # The notes are not even read where nobody has a key to them.
    notes = {} if key is None else load_notes() if lessons is None else load_notes(lessons)
    if lecture:
        stage = LectureHost(server, settings, key, background, people, book, notes, sessions, host)
        return House(server, stage, background, people)
    return House(server, PrivateHost(server, settings, background, people, book, key, notes), background, people)
