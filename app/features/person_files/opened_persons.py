"""A server's persons, shared by its sessions."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from app.features.person_files.bvh import from_bvh, read_bvh
from app.features.person_files.camera import CameraSource
from app.features.person_files.film import open_camera, open_detector, open_video
from app.features.person_files.person_options import MODEL_REMEDY, PersonOptions
from app.features.person_files.source_chooser import SourceChooser
from app.hosting.opened_feature import OpenedFeature
from app.page.panel_context import PanelMaker
from controllers.errors import BadSetting
from scenes.person.source import PersonTarget


class OpenedPersons(OpenedFeature):
    """A person from a file, and a camera or video."""

    def __init__(self, bvh: PersonTarget | None = None, camera: CameraSource | None = None) -> None:
        self.bvh, self.camera = bvh, camera
        self.panels: Sequence[PanelMaker] = (partial(SourceChooser, bvh=bvh, camera=camera),)

    def close(self) -> None:
        if self.camera is not None:
            self.camera.stop()


def open_persons(options: PersonOptions) -> OpenedPersons:
    """Read the file, and start the camera.

    Raises:
        BadSetting: a camera and a video, or no model for them.
        BadInputFile, MissingPackage: see `read_bvh`, `open_camera`, `open_video`, `open_detector`.
    """
    person = None if options.bvh is None else from_bvh(read_bvh(options.bvh))
    if options.camera is None and options.video is None:
        return OpenedPersons(person)
    if options.camera is not None and options.video is not None:
        raise BadSetting("--camera and --video are two sources for the same person; give one of them.")
    if options.pose_model is None:
        raise BadSetting(f"A camera or a video needs a model that finds the person: {MODEL_REMEDY}.")
    film = open_camera(options.camera) if options.camera is not None else open_video(options.video or Path())
    return OpenedPersons(person, CameraSource(film, open_detector(options.pose_model)).start())
