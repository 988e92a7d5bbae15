"""A person in front of a camera, or in a video: pictures → MediaPipe's pose landmarks → angles, in a thread of its own.

OpenCV and MediaPipe are the extra `[camera]` and are imported only here, only when asked for. MediaPipe comes without a model: the
user names a pose_landmarker file.
"""

import importlib
import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, Final, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from controllers.errors import BadInputFile, BadSetting, DuetError
from controllers.kinematics import Array
from scenes.person.landmarks import COUNT, LEAST_VISIBILITY, landmarks_to_angles
from scenes.person.source import MissingPackage, SampledAngles

STALE: Final = 0.5
"""A person seen longer ago than this is lost [s]."""

LONGEST_VIDEO: Final = 1800.0
"""Of a video that is read as a whole [s]."""


class Picture(NamedTuple):
    """One picture of a film.

    Attributes:
        time: since the film began [s].
        image: RGB (height, width, 3).
    """

    time: float
    image: NDArray[np.uint8]


class Film(Protocol):
    """Pictures, one after the other."""

    live: bool
    """Whether they come when they are made, not when they are asked for."""

    def next(self) -> Picture | None:
        """Return the next picture, or None at the end."""
        ...

    def close(self) -> None:
        """Let go of the device or the file."""
        ...


class Detector(Protocol):
    """Finds a person in pictures whose times grow."""

    def find(self, picture: Picture) -> tuple[Array, Array] | None:
        """Return world landmarks (33, 3) [m] and their visibility (33,), or None if nobody is there."""
        ...

    def close(self) -> None:
        """Let go of the model."""
        ...


class CameraSource:
    """The person in a film, as last seen; a `PersonSource` that does not look at the time it is asked for.

    Args:
        film: live pictures are taken as they come, those of a file at the file's own speed. Closed when the thread ends.
        detector: closed when the thread ends.
        least_visibility: see `landmarks_to_angles`.
        clock: a steady time [s].
    """

    def __init__(
        self,
        film: Film,
        detector: Detector,
        least_visibility: float = LEAST_VISIBILITY,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._film, self._detector, self._least_visibility, self._clock = film, detector, least_visibility, clock
        # One tuple, replaced as a whole: whoever reads it needs no lock.
        self._latest: tuple[float, Array | None] = (-math.inf, None)
        self._end = ""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)

    def start(self) -> Self:
        """Begin to look; once."""
        self._thread.start()
        return self

    def stop(self, patience: float = 5.0) -> None:
        """Stop looking, and wait for the thread to let go of camera and model, at most so long [s]. May be called again."""
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(patience)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def running(self) -> bool:
        """Whether the thread is at work."""
        return self._thread.is_alive()

    @property
    def message(self) -> str:
        """Why nobody is seen, in one line; "" while somebody is."""
        if self._end:
            return self._end
        if not self.running:
            return "The camera is off."
        return (
            ""
            if self.angles(0.0) is not None
            else "Nobody is seen: step back until shoulders, elbows and wrists are in the picture."
        )

    def angles(self, time: float) -> Array | None:
        """Return the angles (2, 4) last seen [rad], or None if that is too long ago or nobody was there."""
        seen, angles = self._latest
        return None if angles is None or self._clock() - seen > STALE else angles.copy()

    def _run(self) -> None:
        try:
            self._watch()
        except DuetError as error:
            self._end = str(error)
        except Exception as error:
            self._end = f"The camera stopped: {_first_line(error)}. Choose it again to go on."
        finally:
            self._latest = (-math.inf, None)
            for part in (self._film, self._detector):
                try:
                    part.close()
                except Exception as error:
                    self._end = self._end or f"The camera could not be closed: {_first_line(error)}."

    def _watch(self) -> None:
        began, previous = self._clock(), None
        while not self._stopping.is_set():
            picture = self._film.next()
            if picture is None:
                self._end = "The camera gives no more pictures." if self._film.live else "The video has ended."
                return
            if not self._film.live:
                self._stopping.wait(max(0.0, began + picture.time - self._clock()))
            angles = _angles_in(picture, self._detector, previous, self._least_visibility)
            previous = angles if angles is not None else previous
            self._latest = (self._clock(), angles)


def read_film(film: Film, detector: Detector, least_visibility: float = LEAST_VISIBILITY) -> SampledAngles:
    """Return the person in a whole film, picture by picture, and close both: the same film gives the same angles each time.

    Raises:
        BadInputFile: no pictures, nobody in any of them, or a film too long.
    """
    times: list[float] = []
    table: list[Array] = []
    previous = None
    try:
        while (picture := film.next()) is not None:
            if picture.time > LONGEST_VIDEO:
                raise BadInputFile(f"The video is longer than {LONGEST_VIDEO / 60.0:g} minutes; cut it.")
            angles = _angles_in(picture, detector, previous, least_visibility)
            previous = angles if angles is not None else previous
            times.append(picture.time)
            table.append(np.full((2, 4), np.nan) if angles is None else angles)
    finally:
        film.close()
        detector.close()
    if previous is None:
        raise BadInputFile("Nobody is seen in the video: shoulders, elbows and wrists must be in the picture.")
    return SampledAngles(np.array(times), np.array(table))


def _angles_in(picture: Picture, detector: Detector, previous: Array | None, least_visibility: float) -> Array | None:
    found = detector.find(picture)
    return None if found is None else landmarks_to_angles(*found, previous, least_visibility)


def open_camera(index: int) -> Film:
    """Return the pictures of a camera at this machine.

    Raises:
        MissingPackage: OpenCV is not installed.
        BadSetting: there is no such camera.
    """
    cv2 = _package("cv2", "opencv-contrib-python")
    if not 0 <= index < 100:
        raise BadSetting(f"Camera {index} is not possible; give 0 for the first camera, 1 for the next.")
    # OpenCV tells of missing cameras on standard error, in its own words, on top of ours.
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        capture = cv2.VideoCapture(index)
    finally:
        cv2.utils.logging.setLogLevel(level)
    if not capture.isOpened():
        capture.release()
        raise BadSetting(
            f"Camera {index} cannot be opened; check that it is plugged in and no other program uses it, or give another number."
        )
    # One picture in stock: the newest counts, not the oldest.
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    return _Capture(cv2, capture, 0.0)


def open_video(path: Path) -> Film:
    """Return the pictures of a video file.

    Raises:
        MissingPackage: OpenCV is not installed.
        BadInputFile: no such file, or not a video.
    """
    _must_exist(path, "video")
    cv2 = _package("cv2", "opencv-contrib-python")
    capture = cv2.VideoCapture(str(path))
    rate = float(capture.get(cv2.CAP_PROP_FPS)) if capture.isOpened() else 0.0
    if not 0.5 <= rate <= 1000.0:
        capture.release()
        raise BadInputFile(f"{path}: is not a video that OpenCV can read; give an .mp4 or .avi file.")
    return _Capture(cv2, capture, rate)


def open_detector(model: Path) -> Detector:
    """Return MediaPipe's pose landmarker with a model file.

    Raises:
        MissingPackage: MediaPipe is not installed.
        BadInputFile: no such file, or not such a model.
    """
    _must_exist(model, "pose_landmarker model (.task), which MediaPipe's web pages offer")
    mediapipe = _package("mediapipe", "mediapipe")
    vision = _package("mediapipe.tasks.python.vision", "mediapipe")
    base = _package("mediapipe.tasks.python", "mediapipe").BaseOptions(model_asset_path=str(model))
    options = vision.PoseLandmarkerOptions(base_options=base, running_mode=vision.RunningMode.VIDEO)
    try:
        landmarker = vision.PoseLandmarker.create_from_options(options)
    except Exception as error:
        raise BadInputFile(
            f"{model}: MediaPipe cannot use it ({_first_line(error)}); give a pose_landmarker model (.task)."
        ) from None
    return _Landmarker(mediapipe, landmarker)


class _Capture:
    """A film by OpenCV; `rate` is 0 for a camera."""

    def __init__(self, cv2: ModuleType, capture: Any, rate: float) -> None:
        self._cv2, self._capture, self._rate = cv2, capture, rate
        self.live = rate == 0.0
        self._count, self._began = 0, time.monotonic()

    def next(self) -> Picture | None:
        good, image = self._capture.read()
        if not good:
            return None
        seconds = time.monotonic() - self._began if self.live else self._count / self._rate
        self._count += 1
        return Picture(seconds, self._cv2.cvtColor(image, self._cv2.COLOR_BGR2RGB))

    def close(self) -> None:
        self._capture.release()


class _Landmarker:
    def __init__(self, mediapipe: ModuleType, landmarker: Any) -> None:
        self._mediapipe, self._landmarker = mediapipe, landmarker
        self._milliseconds = -1

    def find(self, picture: Picture) -> tuple[Array, Array] | None:
        # MediaPipe insists on times that grow.
        self._milliseconds = max(self._milliseconds + 1, round(1000.0 * picture.time))
        image = self._mediapipe.Image(image_format=self._mediapipe.ImageFormat.SRGB, data=picture.image)
        people = self._landmarker.detect_for_video(image, self._milliseconds).pose_world_landmarks
        if not people or len(people[0]) != COUNT:
            return None
        points = [(p.x, p.y, p.z, 0.0 if p.visibility is None else p.visibility) for p in people[0]]
        table = np.array(points, float)
        return table[:, :3], table[:, 3]

    def close(self) -> None:
        self._landmarker.close()


def _package(module: str, package: str) -> Any:
    try:
        return importlib.import_module(module)
    except (ImportError, OSError) as error:
        raise MissingPackage(
            f"A camera or video needs the package {package} ({_first_line(error)}). Install it with: pip install 'lwr-duet[camera]'"
        ) from None


def _must_exist(path: Path, what: str) -> None:
    if not path.is_file():
        raise BadInputFile(f"{path}: there is no such file; give the path of a {what}.")


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0].rstrip(".")[:200]
