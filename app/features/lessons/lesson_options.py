"""Options of `lwr-duet serve` for lessons. Imports nothing slow."""

import os
from dataclasses import dataclass
from pathlib import Path

from app.hosting.serve_options import FeatureOptions
from controllers.errors import BadSetting


@dataclass(frozen=True)
class LessonOptions(FeatureOptions):
    """Lessons of your own."""

    lessons: Path | None = None
    """Folder of lessons beside our own; see app/features/lessons/files/README.md."""
    playlist: Path | None = None
    """TOML file that names the lessons and single steps that are shown, in order: ours, those of --lessons, and files."""

    def check(self) -> None:
        if self.lessons is not None and not os.path.isdir(self.lessons):
            raise BadSetting(
                f"lessons = {self.lessons}: there is no such folder; name one with lesson files."
            )
        if self.playlist is not None and not os.path.isfile(self.playlist):
            raise BadSetting(
                f"playlist = {self.playlist}: there is no such file; see app/features/lessons/files/README.md."
            )
