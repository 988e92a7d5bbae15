"""Options of `lwr-duet serve` and `run` that name a person to imitate. Imports nothing slow."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.hosting.serve_options import FeatureOptions
from app.recording.run_source import RunSource
from controllers.errors import BadSetting
from scenes.experiments import IMITATION

if TYPE_CHECKING:
    from scenes.roles import TargetSource
    from scenes.settings import RunSettings

MODEL_REMEDY: Final = "name a pose_landmarker model of MediaPipe (a .task file) with --pose-model FILE"


@dataclass(frozen=True)
class PersonOptions(FeatureOptions):
    """A person from a file or a camera."""

    bvh: Path | None = None
    """A person's recorded motion to imitate, as BVH; used when `source` is `file`."""
    camera: int | None = None
    """Number of a camera at this computer; its person is imitated when `source` is `camera` (needs the extra `camera`)."""
    video: Path | None = None
    """A video file instead of a camera."""
    pose_model: Path | None = None
    """MediaPipe's model that finds the person, a pose_landmarker .task file."""

    @property
    def one_process(self) -> str:
        return "" if self.camera is None and self.video is None else "one process reads the camera"


@dataclass(frozen=True)
class PersonRunSource(RunSource):
    """A person from a file."""

    bvh: Path | None = None
    """In `imitation`: a person's recorded motion as BVH, instead of a built-in clip."""
    video: Path | None = None
    """In `imitation`: a person in a video file (needs the extra `camera`)."""
    pose_model: Path | None = None
    """MediaPipe's model that finds the person in the video."""

    @property
    def given(self) -> Mapping[str, Path]:
        named = {"bvh": self.bvh, "video": self.video}
        return {name: path for name, path in named.items() if path is not None}

    @property
    def read(self) -> tuple[Path, ...]:
        return (*self.given.values(), *(() if self.pose_model is None else (self.pose_model,)))

    def source(self, settings: "RunSettings") -> "TargetSource":
        (name,) = self.given
        if settings.experiment.follows != "person":
            raise BadSetting(f"--{name} is a person to imitate; add --scene {IMITATION}.")
        if self.bvh is not None:
            from app.features.person_files.bvh import from_bvh, read_bvh

            return from_bvh(read_bvh(self.bvh))
        from app.features.person_files.camera import read_film
        from app.features.person_files.film import open_detector, open_video
        from scenes.person.source import PersonTarget

        if self.pose_model is None:
            raise BadSetting(f"A video needs a model that finds the person: {MODEL_REMEDY}.")
        assert self.video is not None
        return PersonTarget(read_film(open_video(self.video), open_detector(self.pose_model)))
