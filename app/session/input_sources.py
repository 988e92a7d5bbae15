"""The input sources of the server: persons to imitate beside the built-in clips and the figure, and the file of a custom law."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from app.custom_law.time_share import LawTimeShare
from controllers.errors import BadInputFile, BadSetting
from scenes.person.bvh import read_bvh
from scenes.person.camera import CameraSource
from scenes.person.film import open_camera, open_detector, open_video
from scenes.person.source import PersonSource, SampledAngles
from scenes.targets import AnglesTarget

MODEL_REMEDY: Final = "name a pose_landmarker model of MediaPipe (a .task file) with --pose-model FILE"


class PersonTarget:
    """A source as a person of the experiment.

    Args:
        source: of the angles.
        loop: start again after so many seconds; None for a source that does not end.
    """

    def __init__(self, source: PersonSource, loop: float | None = None) -> None:
        self._source, self._loop = source, loop

    def target(self, time: float) -> AnglesTarget:
        """Return how the person's arms are at a time [s]."""
        return AnglesTarget(self._source.angles(time % self._loop if self._loop else time))


def from_bvh(motion: SampledAngles) -> PersonTarget:
    """Return the person of a BVH file, again and again."""
    return PersonTarget(motion, max(motion.duration, 1e-3))


@dataclass(frozen=True)
class InputSources:
    """What was named when the server started.

    Attributes:
        bvh: a person from a file, None if none was named.
        camera: the person in front of the camera or in the video, shared by every visitor.
        law_file: a law of one's own; every session runs it in a process of its own.
        law_share: how long all of them together may be waited for.
    """

    bvh: PersonTarget | None = None
    camera: CameraSource | None = None
    law_file: Path | None = None
    law_share: LawTimeShare = field(default_factory=LawTimeShare, compare=False)

    def close(self) -> None:
        """Let go of the camera."""
        if self.camera is not None:
            self.camera.stop()


NO_SOURCES: Final = InputSources()


def find_input_sources(
    bvh: Path | None, camera: int | None, video: Path | None, model: Path | None, law_file: Path | None = None
) -> InputSources:
    """Return who can be imitated.

    Args:
        bvh: a BVH file.
        camera: number of a camera at this computer.
        video: a video file, instead of a camera.
        model: MediaPipe's model for either.
        law_file: a law of one's own.

    Raises:
        BadSetting: a camera and a video, or no model for them.
        BadInputFile, MissingPackage: see `read_bvh`, `open_camera`, `open_video`, `open_detector`.
    """
    if law_file is not None and not law_file.is_file():
        raise BadInputFile(f"{law_file}: there is no such file; `lwr-duet new-law {law_file}` writes one to begin with.")
    person = None if bvh is None else from_bvh(read_bvh(bvh))
    if camera is None and video is None:
        return InputSources(person, None, law_file)
    if camera is not None and video is not None:
        raise BadSetting("--camera and --video are two sources for the same person; give one of them.")
    if model is None:
        raise BadSetting(f"A camera or a video needs a model that finds the person: {MODEL_REMEDY}.")
    film = open_camera(camera) if camera is not None else open_video(video or Path())
    return InputSources(person, CameraSource(film, open_detector(model)).start(), law_file)
