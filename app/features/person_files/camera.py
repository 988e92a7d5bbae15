"""A person before a camera or in a video."""

import math
import threading
import time
from collections.abc import Callable
from typing import Final, Self

import numpy as np

from app.features.person_files.film import Detector, Film, VideoFrame
from controllers.errors import BadInputFile, DuetError, LazyText, first_line
from controllers.kinematics import Array
from scenes.person.angles import BodyPoints, body_angles
from scenes.person.source import SampledAngles

STALE: Final = 0.5
"""Age at which a person counts as lost [s]."""

LONGEST_VIDEO: Final = 1800.0
"""Longest video that is read as a whole [s]."""


class CameraSource:
    """Last seen person; a `PersonSource` that ignores the asked time. The thread closes film and detector."""

    def __init__(self, film: Film, detector: Detector, clock: Callable[[], float] = time.monotonic) -> None:
        self._film, self._detector, self._clock = film, detector, clock
        # One tuple, replaced as a whole: readers need no lock.
        self._latest: tuple[float, Array | None] = (-math.inf, None)
        self._end = ""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)

    def start(self) -> Self:
        """Start the thread, once."""
        self._thread.start()
        return self

    def stop(self, patience: float = 5.0) -> None:
        """Wait at most `patience` [s] until the thread has released camera and model."""
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(patience)

    @property
    def running(self) -> bool:
        return self._thread.is_alive()

    @property
    def message(self) -> str:
        """Why no person is seen, or ""."""
        if self._end:
            return self._end
        if not self.running:
            return LazyText("The camera is off.")
        if self.angles(0.0) is not None:
            return ""
        return LazyText("No person is seen: step back until shoulders, elbows and wrists are in the picture.")

    def angles(self, time: float) -> Array | None:
        """Last seen angles (2, 4) [rad]; None if too long ago."""
        seen, angles = self._latest
        return None if angles is None or self._clock() - seen > STALE else angles.copy()

    def _run(self) -> None:
        try:
            self._watch()
        except DuetError as error:
            self._end = str(error)
        except Exception as error:
            self._end = LazyText(
                "The camera stopped: {reason}. Choose it again to continue.", reason=first_line(error)
            )
        finally:
            self._latest = (-math.inf, None)
            for part in (self._film, self._detector):
                try:
                    part.close()
                except Exception as error:
                    if not self._end:
                        self._end = LazyText(
                            "The camera could not be closed: {reason}.", reason=first_line(error)
                        )

    def _watch(self) -> None:
        began, previous = self._clock(), None
        while not self._stopping.is_set():
            picture = self._film.next()
            if picture is None:
                self._end = (
                    LazyText("The camera gives no more pictures.")
                    if self._film.live
                    else LazyText("The video has ended.")
                )
                return
            if not self._film.live:
                self._stopping.wait(max(0.0, began + picture.time - self._clock()))
            angles = _angles_in(picture, self._detector, previous)
            previous = angles if angles is not None else previous
            self._latest = (self._clock(), angles)


def read_film(film: Film, detector: Detector) -> SampledAngles:
    """Closes both. The same film always gives the same angles.

    Raises:
        BadInputFile: no person is seen, or the film is too long.
    """
    times: list[float] = []
    table: list[Array] = []
    previous = None
    try:
        while (picture := film.next()) is not None:
            if picture.time > LONGEST_VIDEO:
                raise BadInputFile(
                    "The video is longer than {minutes:g} minutes; cut it.", minutes=LONGEST_VIDEO / 60.0
                )
            angles = _angles_in(picture, detector, previous)
            previous = angles if angles is not None else previous
            times.append(picture.time)
            table.append(np.full((2, 4), np.nan) if angles is None else angles)
    finally:
        film.close()
        detector.close()
    if previous is None:
        raise BadInputFile(
            "No person is seen in the video: shoulders, elbows and wrists must be in the picture."
        )
    return SampledAngles(np.array(times), np.array(table))


def _angles_in(picture: VideoFrame, detector: Detector, previous: Array | None) -> Array | None:
    found = detector.find(picture)
    return None if found is None else landmarks_to_angles(*found, previous)


SHOULDERS: Final = (11, 12)
ELBOWS: Final = (13, 14)
WRISTS: Final = (15, 16)
HIPS: Final = (23, 24)
"""Indices of MediaPipe Pose, the person's left first."""

ARMS: Final = (*SHOULDERS, *ELBOWS, *WRISTS)

LEAST_VISIBILITY: Final = 0.5
"""Least visibility of a used landmark; 0 … 1."""

SHORTEST_BONE: Final = 0.03
"""Shorter bones are tracking errors [m]."""


def landmarks_to_angles(landmarks: Array, visibility: Array, previous: Array | None = None) -> Array | None:
    """Angles (2, 4) of both arms [rad], left first; None unless shoulders, elbows and wrists are visible.

    Without hips the body is assumed upright in the picture.

    Args:
        landmarks: (33, 3) [m]: x right in the picture, y down, z away from the camera.
        visibility: (33,), 0 … 1.
        previous: angles of the sample before, or None.
    """
    arms = landmarks[list(ARMS)]
    if not (visibility[list(ARMS)] >= LEAST_VISIBILITY).all() or not np.isfinite(arms).all():
        return None
    shoulders, elbows, wrists = arms[:2], arms[2:4], arms[4:]
    for a, b in ((shoulders, elbows), (elbows, wrists)):
        if (np.linalg.norm(b - a, axis=1) < SHORTEST_BONE).any():
            return None
    hips = landmarks[list(HIPS)].mean(axis=0)
    if not ((visibility[list(HIPS)] >= LEAST_VISIBILITY).all() and np.isfinite(hips).all()):
        hips = shoulders.mean(axis=0) + np.array([0.0, 0.5, 0.0])
    return body_angles(BodyPoints(shoulders, elbows, wrists, hips), previous)
