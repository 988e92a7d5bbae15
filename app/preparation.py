"""What is slow when it is wanted for the first time is made ready before anybody asks: lessons and words of the other languages, robots
and how they are drawn. What the user's cache does not hold yet is made in another process: it would keep the frames waiting for seconds."""

import logging
import threading
from collections.abc import Callable
from itertools import product
from typing import Final, get_args

from app.background import Background
from app.languages.lesson_book import in_language
from app.languages.visitor import KNOWN
from app.languages.words import words_of
from app.lessons.lesson import LessonBook
from controllers.errors import DuetError
from scenes.glb import NotStored, stored_only
from scenes.lwr.shells import PALETTES
from scenes.robots import RobotName, robot
from scenes.robots.drawing import robot_glbs

log = logging.getLogger("duet.hosts")

PAUSE: Final = 0.02
"""Between two things, in which the frames have the interpreter for themselves [s]."""


class Preparation:
    """Goes through everything once, in a thread of its own.

    Args:
        book: the lessons.
        background: makes what is not stored.
    """

    def __init__(self, book: LessonBook, background: Background) -> None:
        self._book, self._background = book, background
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="duet-preparation", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End it after the thing that is being read."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        for language in KNOWN:
            words_of(language)
            in_language(self._book, language)
            if self._ended.wait(PAUSE):
                return
        for name, coarse, palette in product(get_args(RobotName), (False, True), PALETTES):
            try:
                with stored_only():
                    _draw(name, palette, coarse)
            except NotStored:
                self._background.submit(self, f"{name} {palette} {coarse}", make, name, palette, coarse)
            except DuetError as error:
                log.info("%s cannot be made ready: %s", name, error)
            if self._ended.wait(PAUSE):
                return


def _draw(name: RobotName, palette: str, coarse: bool) -> None:
    robot(name)
    robot_glbs(name, palette, coarse)


def make(name: RobotName, palette: str, coarse: bool, stopped: Callable[[], bool]) -> None:
    """Fill the user's cache with one way to draw a robot; in a worker."""
    if not stopped():
        _draw(name, palette, coarse)
