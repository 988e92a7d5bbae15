"""OpenCV and MediaPipe, the extra `[camera]`, imported only here."""

import importlib
import time
from pathlib import Path
from types import ModuleType
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from controllers.errors import BadInputFile, BadSetting, first_line
from controllers.kinematics import Array
from controllers.system_libraries import naming_missing_library
from scenes.person.source import MissingPackage

COUNT: Final = 33
"""Landmarks of MediaPipe Pose."""


class VideoFrame(NamedTuple):
    """`time`: since the film began [s]; `image`: RGB (height, width, 3)."""

    time: float
    image: NDArray[np.uint8]


class Film(Protocol):
    live: bool

    def next(self) -> VideoFrame | None:
        """None at the end."""
        ...

    def close(self) -> None:
        """Release the device or the file."""


class Detector(Protocol):
    """Finds a person in frames with increasing times."""

    def find(self, picture: VideoFrame) -> tuple[Array, Array] | None:
        """World landmarks (33, 3) [m] and their visibility (33,), or None."""
        ...

    def close(self) -> None: ...


def open_camera(index: int) -> Film:
    """Camera of this machine.

    Raises:
        MissingPackage: OpenCV is not installed.
        BadSetting: no such camera.
    """
    cv2 = _package("cv2", "opencv-contrib-python")
    if not 0 <= index < 100:
        raise BadSetting(f"Camera {index} is not possible; give 0 for the first camera, 1 for the next.")
    # OpenCV reports missing cameras on standard error, in addition to our message.
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        capture = cv2.VideoCapture(index)
    finally:
        cv2.utils.logging.setLogLevel(level)
    if not capture.isOpened():
        capture.release()
        raise BadSetting(
            f"Camera {index} cannot be opened: is it plugged in, and does no other program use it? Or give another number."
        )
    # A buffer of one picture: the newest counts, not the oldest.
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    return _Capture(cv2, capture, 0.0)


def open_video(path: Path) -> Film:
    """Raises `MissingPackage` without OpenCV, and `BadInputFile` without a video."""
    _must_exist(path, "video")
    cv2 = _package("cv2", "opencv-contrib-python")
    capture = cv2.VideoCapture(str(path))
    rate = float(capture.get(cv2.CAP_PROP_FPS)) if capture.isOpened() else 0.0
    if not 0.5 <= rate <= 1000.0:
        capture.release()
        raise BadInputFile(f"{path}: is not a video that OpenCV can read; give an .mp4 or .avi file.")
    return _Capture(cv2, capture, rate)


def open_detector(model: Path) -> Detector:
    """MediaPipe's pose landmarker.

    Raises:
        MissingPackage: MediaPipe is not installed.
        BadInputFile: not such a model.
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
            f"{model}: MediaPipe cannot use it ({first_line(error)}); give a pose_landmarker model (.task)."
        ) from None
    return _Landmarker(mediapipe, landmarker)


class _Capture:
    """A film, read by OpenCV. `rate`: 0 for a camera."""

    def __init__(self, cv2: ModuleType, capture: Any, rate: float) -> None:
        self._cv2, self._capture, self._rate = cv2, capture, rate
        self.live = rate == 0.0
        self._count, self._began = 0, time.monotonic()

    def next(self) -> VideoFrame | None:
        good, image = self._capture.read()
        if not good:
            return None
        seconds = time.monotonic() - self._began if self.live else self._count / self._rate
        self._count += 1
        return VideoFrame(seconds, self._cv2.cvtColor(image, self._cv2.COLOR_BGR2RGB))

    def close(self) -> None:
        self._capture.release()


class _Landmarker:
    def __init__(self, mediapipe: ModuleType, landmarker: Any) -> None:
        self._mediapipe, self._landmarker = mediapipe, landmarker
        self._milliseconds = -1

    def find(self, picture: VideoFrame) -> tuple[Array, Array] | None:
        # MediaPipe requires increasing times.
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
        with naming_missing_library():
            return importlib.import_module(module)
    except (ImportError, OSError) as error:
        raise MissingPackage(
            f"A camera or video needs the package {package} ({first_line(error)}). Install it with: pip install 'lwr-duet[camera]'"
        ) from None


def _must_exist(path: Path, what: str) -> None:
    if not path.is_file():
        raise BadInputFile(f"{path}: there is no such file; give the path of a {what}.")
