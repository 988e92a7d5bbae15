"""Features' sources of targets and laws for `lwr-duet run`. Imports nothing slow."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from app.recording.headless_law import HeadlessLaw
    from scenes.roles import TargetSource
    from scenes.settings import RunSettings


@dataclass(frozen=True)
class RunSource:
    """Options of `lwr-duet run` that name files with a source of targets or a law; each option has a default."""

    @property
    def given(self) -> Mapping[str, Path]:
        raise NotImplementedError

    @property
    def read(self) -> tuple[Path, ...]:
        return tuple(self.given.values())

    def source(self, settings: "RunSettings") -> "TargetSource":
        """The only named source.

        Raises:
            BadSetting, BadInputFile, MissingPackage: unreadable, or unfit for the experiment.
        """
        raise NotImplementedError

    def law(self) -> "HeadlessLaw | None":
        """Law that replaces the settings' law.

        Raises:
            BadInputFile: unreadable file.
        """
        return None
