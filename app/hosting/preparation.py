"""Prepares slow things at the start; meshes in another process, to keep frames on time."""

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Final, get_args

from app.hosting.server_part import ServerPart
from app.i18n.catalogue import words_of
from app.runtime.job_pool import Jobs
from app.settings import LANGUAGES
from controllers.errors import DuetError
from scenes.given_robots import GIVEN
from scenes.glb import NotStored, stored_only
from scenes.lwr.shells import PALETTES
from scenes.person.body import body_parts
from scenes.rigs import ALONE, RIGS, Rig
from scenes.robots import RobotName, robot
from scenes.robots.drawing import robot_glbs
from scenes.room_shells import furniture_glb

log = logging.getLogger("duet.hosts")

PAUSE: Final = 0.02
"""Pause after each item, for the frames [s]."""

ROOMS: Final[dict[str, Rig]] = {**RIGS, "alone": ALONE}


class Preparation:
    """Reads or makes every item once, in its own thread."""

    def __init__(self, parts: Sequence[ServerPart], jobs: Jobs) -> None:
        self._parts, self._jobs = parts, jobs
        self._ended = threading.Event()
        self.thread = threading.Thread(target=self._run, name="duet-preparation", daemon=True)
        self.thread.start()

    def close(self) -> None:
        self._ended.set()
        self.thread.join()

    def _run(self) -> None:
        for language in LANGUAGES:
            words_of(language)
            for part in self._parts:
                part.prepare(language)
            if self._ended.wait(PAUSE):
                return
        for number, draw in enumerate(mesh_makers()):
            try:
                with stored_only():
                    draw()
            except NotStored:
                self._jobs.submit(self, f"drawing {number}", make, draw)
            except DuetError as error:
                log.info("something cannot be prepared: %s", error)
            if self._ended.wait(PAUSE):
                return


def mesh_makers() -> Iterator[Callable[[], object]]:
    """Functions that read or make one mesh each."""
    for coarse in (False, True):
        for rig in ROOMS:
            yield partial(_furnish, rig, coarse)
        for name in (*get_args(RobotName), *GIVEN):
            yield partial(robot, name)
            for palette in PALETTES:
                yield partial(robot_glbs, name, palette, coarse=coarse)
    yield body_parts


def _furnish(rig: str, coarse: bool) -> None:
    furniture_glb(ROOMS[rig], coarse)


def make(draw: Callable[[], object]) -> None:
    """Runs in a worker."""
    draw()
